"""Descriptions in files, and those that come with snakebot, by name."""

from __future__ import annotations

import os
from pathlib import Path

from snakebot.errors import BadInputError
from snakebot.resources import DEFAULT_ROBOT, config_path, configs_root
from snakebot.robot.checked import robot_from_mapping
from snakebot.robot.description import Robot
from snakebot.safe_yaml import Lines, load_yaml

ITS_FILE = "ROBOT.yaml"  # in commands, of a robot whose description only its owner has
_RECORDINGS = (".mcap", ".mcap.part", ".csv", ".csv.gz", ".parquet")


def load_robot(source: str | Path) -> Robot:
    """Load a description from a YAML file, or by the bare name of one that comes with snakebot (``penn_state``).

    Raises:
        BadInputError: the file is missing, is not YAML, or describes no possible robot.
    """
    try:
        path = config_path("robots", source)
    except BadInputError:
        if os.path.isdir(source):
            raise _recordings(Path(source)) from None
        raise
    if path.name == "session.yaml" or path.name.endswith(_RECORDINGS):
        raise _recordings(path)
    try:
        text = path.read_bytes()
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the robot description: {error.strerror}") from None
    return robot_from_mapping(load_yaml(text, str(path)), str(path), Lines(text))


def shipped_name(robot: Robot) -> str | None:
    """By which name commands know this description; None of one that does not come with snakebot."""
    for path in (configs_root() / "robots").glob("*.yaml"):
        if path.stem == robot.name:
            ours = load_robot(path).model_copy(update={"provenance": robot.provenance})
            return robot.name if ours == robot else None
    return None


def robot_option(robot: Robot) -> str:
    """What `snakebot run` needs to be of this robot, a space before it; nothing for the one that it takes by itself."""
    name = shipped_name(robot) or ITS_FILE
    return "" if name == DEFAULT_ROBOT else f" --robot {name}"


def _recordings(path: Path) -> BadInputError:
    return BadInputError(
        f"{path}: recordings, no robot description; `snakebot diagnose {path} --apply robot.yaml` writes one"
    )
