"""From what stands on a command line to runs with their robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.robot import Robot
    from snakebot.runlog import Run

SESSION_FILE = "session.yaml"


@dataclass(frozen=True)
class Loaded:
    """A run, its robot, and where it was read from."""

    run: Run
    robot: Robot
    source: Path


def load(paths: Sequence[str | Path], robot: Robot | None = None) -> list[Loaded]:
    """Read run logs, session folders (all their runs) and single runs of a session (``session/run_01.csv``).

    Args:
        robot: use this description in place of the one that came with the runs.

    Raises:
        BadInputError: a path is none of these, or has another number of joints than ``robot``.
        LogError: a file is no run log.
    """
    out = [item for path in paths for item in _load(Path(path))]
    if robot is None:
        return out
    for item in out:
        if item.run.joints != robot.joints:
            raise BadInputError(
                f"{item.source}: has {item.run.joints} joints, the robot {robot.name} has {robot.joints}"
            )
    return [Loaded(item.run, robot, item.source) for item in out]


def load_one(path: str | Path, robot: Robot | None = None) -> Loaded:
    """Read one run.

    Raises:
        BadInputError, LogError: as ``load``; or the path holds several runs.
    """
    found = load([path], robot)
    if len(found) > 1:
        names = ", ".join(item.run.name for item in found[:4]) + (", ..." if len(found) > 4 else "")
        raise BadInputError(
            f"{path}: holds {len(found)} runs; name one, for example {Path(path) / found[0].run.name} ({names})"
        )
    return found[0]


def _load(path: Path) -> list[Loaded]:
    from snakebot.runlog import read_log, read_session

    if not path.exists():
        raise BadInputError(f"{path}: no such log or session")
    if path.is_dir() or path.name == SESSION_FILE:
        session = read_session(path)
        return [Loaded(run, session.robot, path) for run in session.runs]
    if path.name.endswith((".mcap", ".mcap.part", ".part")):
        log = read_log(path)
        return [Loaded(log.to_run(), log.robot, path)]
    if (path.parent / SESSION_FILE).is_file():
        session = read_session(path.parent)
        for run in session.runs:
            if run.name == path.name:
                return [Loaded(run, session.robot, path)]
        raise BadInputError(f"{path}: {path.parent / SESSION_FILE} does not list this run")
    raise BadInputError(
        f"{path}: neither a run log (.mcap), a session folder, nor a run of one; "
        "other tables: snakebot log import"
    )
