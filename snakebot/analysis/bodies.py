"""Where the body was over a run: its recorded pose, or the nominal model moved by the joints' angles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.analysis.prediction import fill_gaps
from snakebot.arrays import Floats
from snakebot.runlog.merging import course_rad

if TYPE_CHECKING:
    from snakebot.robot import Robot
    from snakebot.runlog import Run


_COURSE_S = 1.0  # over which a direction of travel is taken where no gait says a cycle; chosen


@dataclass(frozen=True)
class BodyPath:
    """Centre of mass in m, mean link angle in rad (T,) and joint angles in rad (T, joints) at times
    ``t_s``."""

    t_s: Floats
    x_m: Floats
    y_m: Floats
    heading_rad: Floats
    joint_angle_rad: Floats


def recorded_path(run: Run) -> BodyPath | None:
    """The pose that was recorded with the run, if one was; joint angles as measured.

    Where no heading was recorded, it is the direction of travel.
    """
    pose = headed_pose(run)
    if pose is None:
        return None
    angle = fill_gaps(run.t_s, run.measured_rad, most=0.95)
    if angle is None:
        return None
    x, y, heading = pose.T
    return BodyPath(run.t_s, x, y, heading, angle)


def model_path(run: Run, robot: Robot, angle_rad: Floats) -> BodyPath | None:
    """The nominal body with these joint angles (N, joints) prescribed, from the run's first known pose.

    ``None`` without a body, or where too many angles are lost.
    """
    from snakebot.errors import BadInputError
    from snakebot.physics import replayed_pose
    from snakebot.physics.model import ChainModel

    filled = fill_gaps(run.t_s, angle_rad)
    if robot.body is None or filled is None:
        return None
    start = _start(run)
    try:
        pose = replayed_pose(ChainModel.from_body(robot.body), run.t_s, filled, start)
    except BadInputError:
        return None
    return BodyPath(run.t_s, pose[:, 0], pose[:, 1], pose[:, 2], filled)


def _start(run: Run) -> tuple[float, float, float]:
    pose = headed_pose(run)
    if pose is None:
        return 0.0, 0.0, 0.0
    x, y, heading = pose[np.flatnonzero(np.isfinite(pose).all(axis=1))[0]]
    return float(x), float(y), float(heading)


def headed_pose(run: Run) -> Floats | None:
    """The recorded pose (N, 3), its heading that of travel where none was recorded; None without a position."""
    if run.pose is None or not np.isfinite(run.pose[:, :2]).all(axis=1).any():
        return None
    if np.isfinite(run.pose).all(axis=1).any():
        return run.pose
    moving = run.gait is not None and run.gait.omega_rad_s
    period_s = 2 * np.pi / abs(run.gait.omega_rad_s) if run.gait is not None and moving else _COURSE_S
    return np.column_stack([run.pose[:, :2], course_rad(run.t_s, run.pose[:, :2], period_s)])
