"""From the words of a command line to runs with their robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.robot import Robot
    from snakebot.runlog import Run


@dataclass(frozen=True)
class Loaded:
    """A run, its robot, and where it was read from."""

    run: Run
    robot: Robot
    source: Path


def load(paths: Sequence[str | Path], robot: Robot | None = None) -> list[Loaded]:
    """Read run logs, session folders (all their runs) and single runs of a session (``session/run_01.csv``).

    Of several, logs without ticks are left out, with a warning.

    Args:
        robot: use this description in place of the one that came with the runs.

    Raises:
        BadInputError: a path is none of these, or has another number of joints than ``robot``.
        LogError: a file is no run log.
    """
    from snakebot.runlog.opening import open_each

    for path in paths:
        if not Path(path).exists():
            raise BadInputError(f"{path}: no such log or session")
    opened, _ = open_each(paths)
    out = [Loaded(run, robot or session.robot, path) for path, session in opened for run in session.runs]
    for item in out:
        if item.run.joints != item.robot.joints:
            raise BadInputError(
                f"{item.source}: has {item.run.joints} joints, the robot {item.robot.name} has {item.robot.joints}"
            )
    return out


def load_one(path: str | Path, robot: Robot | None = None) -> Loaded:
    """Read one run.

    Raises:
        BadInputError, LogError: as ``load``; or the path holds several runs.
    """
    found = load([path], robot)
    if len(found) > 1:
        raise BadInputError(
            f"{path}: holds {len(found)} runs; name one, for example {Path(path) / found[0].run.name}"
        )
    return found[0]
