"""Where the body was over a run: its recorded pose, or the nominal model moved by the joints' angles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.analysis.prediction import fill_gaps
from snakebot.analysis.sine import Array

if TYPE_CHECKING:
    from snakebot.robot import Robot
    from snakebot.runlog import Run


@dataclass(frozen=True)
class BodyPath:
    """Centre of mass in m, mean link angle in rad (T,) and joint angles in rad (T, joints) at times
    ``t_s``."""

    t_s: Array
    x_m: Array
    y_m: Array
    heading_rad: Array
    joint_angle_rad: Array


def recorded_path(run: Run) -> BodyPath | None:
    """The pose that was recorded with the run, if one was; joint angles as measured."""
    if run.pose is None or not np.isfinite(run.pose).all(axis=1).any():
        return None
    angle = fill_gaps(run.t_s, run.measured_rad, most=0.95)
    if angle is None:
        return None
    x, y, heading = run.pose.T
    return BodyPath(run.t_s, x, y, heading, angle)


def model_path(run: Run, robot: Robot, angle_rad: Array) -> BodyPath | None:
    """The nominal body with these joint angles (N, joints) prescribed, from the run's first known pose.

    ``None`` without a body, or where too many angles are lost.
    """
    from snakebot.errors import BadInputError
    from snakebot.physics import replay
    from snakebot.physics.model import ChainModel

    filled = fill_gaps(run.t_s, angle_rad)
    if robot.body is None or filled is None:
        return None
    start = _start(run)
    try:
        moved = replay(
            ChainModel.from_body(robot.body),
            run.t_s,
            filled,
            x_m=start[0],
            y_m=start[1],
            heading_rad=start[2],
        )
    except BadInputError:
        return None
    return BodyPath(moved.t_s, moved.com_m[:, 0], moved.com_m[:, 1], moved.heading_rad, filled)


def _start(run: Run) -> tuple[float, float, float]:
    if run.pose is not None:
        known = np.flatnonzero(np.isfinite(run.pose).all(axis=1))
        if len(known):
            x, y, heading = run.pose[known[0]]
            return float(x), float(y), float(heading)
    return 0.0, 0.0, 0.0
