"""How far recordings went: fastest gait, joint speeds asked for, torques. What shows only beyond, they do not tell.

A servo that cannot do more than it was asked for leaves no mark. So a gait that asks for more is promised by a
simulation that nothing has confirmed there.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.prediction import replay_stage
from snakebot.effects.servo_stage import ServoRun, servo_stages
from snakebot.effects.stages import assemble, filled
from snakebot.lifted import lifted
from snakebot.robot import Recorded

if TYPE_CHECKING:
    from snakebot.robot import Robot
    from snakebot.runlog import Run

STEP_S = 0.01  # of the times at which set-points are compared; chosen
# Such steps, over which a joint speed is a mean: a step of the set-point asks for no speed; chosen.
LASTING = 10
DIGITS = 4  # of what is written; chosen


def reached(robot: Robot, runs: Iterable[Run]) -> Recorded | None:
    """How far the runs went; None where none has two samples.

    Args:
        robot: as it was calibrated on them: its simulation tells the torques.
    """
    seen = [run for run in runs if len(run) >= 2 and run.joints == robot.joints]
    if not seen:
        return None
    omegas = [run.gait.omega_rad_s for run in seen if run.gait is not None and run.gait.alpha_rad > 0]
    torque = None
    if robot.body is not None:
        most = np.max([torque_of(robot, run) for run in seen], axis=0)
        torque = _rounded(most) if np.isfinite(most).all() else None
    return Recorded(
        omega_rad_s=max(omegas) if omegas and max(omegas) > 0 else None,
        joint_speed_rad_s=_rounded(np.max([asked_speed(run) for run in seen], axis=0)),
        torque_nm=torque,
    )


def asked_speed(run: Run) -> Floats:
    """(joints,) largest speed of the set-points in rad/s, each a mean over a tenth of a second."""
    t = np.arange(run.t_s[0], run.t_s[-1] + STEP_S / 2, STEP_S)
    command = filled(run.command_rad)
    angle = np.column_stack([np.interp(t, run.t_s, column) for column in command.T])
    if len(t) <= LASTING:
        return np.zeros(run.joints)
    return np.asarray(np.abs(angle[LASTING:] - angle[:-LASTING]).max(axis=0) / (LASTING * STEP_S))


def torque_of(robot: Robot, run: Run) -> Floats:
    """(joints,) torque of each joint in N m that is exceeded for no more than a tenth of a second of the simulated run,
    its ramps included: there, with a body that is still straight, joints bear more than in the gait.
    """
    stages = assemble(lifted(robot) if run.metadata.get("lifted") is True else robot)
    driven = ServoRun(run.t_s, stages.link(run.t_s, run.command_rad), known_rad=filled(run.measured_rad))
    (servos,) = servo_stages(stages, [driven])
    torque = servos.torque_nm
    if torque is None:
        torque = replay_stage(stages, run.t_s, servos.joint_angle_rad).joint_torque_nm
    lasting = 1 - LASTING * STEP_S / max(run.duration_s, LASTING * STEP_S)
    return np.asarray(np.quantile(np.abs(torque), lasting, axis=0))


def _rounded(values: Floats) -> tuple[float, ...]:
    """To as many digits as a description is read with."""
    return tuple(float(f"{value:.{DIGITS}g}") for value in values)
