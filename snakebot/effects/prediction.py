"""Whole runs at once: what a robot with its effects would have shown, stage by stage, for a fit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Bools, Floats
from snakebot.effects.effect import Track
from snakebot.effects.servo_stage import GRID_S, ServoRun, Servos, servo_stages, setpoint_at
from snakebot.effects.stages import Stages, assemble, filled
from snakebot.errors import BadInputError
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.effects.spec import EffectSpec
    from snakebot.physics import Trajectory
    from snakebot.robot import Robot


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """What the body stage makes of joint angles: centre of mass (T, 2), mean link angle (T,), and velocity (T, 2)."""

    t_s: Floats
    com_m: Floats
    heading_rad: Floats
    velocity_m_s: Floats

    @property
    def speed_m_s(self) -> Floats:
        """(T,) along the heading."""
        speed: Floats = self.velocity_m_s[:, 0] * np.cos(self.heading_rad) + self.velocity_m_s[:, 1] * np.sin(
            self.heading_rad
        )
        return speed

    def forward_speed_m_s(self, from_s: float = -np.inf, to_s: float = np.inf) -> float:
        """Mean velocity over a span of time, along the mean heading over that span; NaN for fewer than two samples."""
        rows = np.flatnonzero((self.t_s >= from_s) & (self.t_s <= to_s))
        if rows.size < 2:
            return float("nan")
        a, b = rows[0], rows[-1]
        span = self.t_s[b] - self.t_s[a]
        heading = np.trapezoid(self.heading_rad[a : b + 1], self.t_s[a : b + 1]) / span
        way = self.com_m[b] - self.com_m[a]
        return float((way[0] * np.cos(heading) + way[1] * np.sin(heading)) / span)


@dataclass(frozen=True, eq=False)
class PredictedRun:
    """A predicted run at T samples.

    Attributes:
        t_s: (T,).
        applied_rad: (T, joints) set-point in force from that sample on.
        joint_angle_rad: (T, joints).
        encoder_rad: (T, joints) mean reading, noiseless.
        variance_rad2: (T, joints) of the reading about it, as far as chance has a part: noise, counts, lost set-points
            (of these an upper bound).
        load_nm: (T, joints) torque that each servo felt; zeros where the angles are known without simulating it.
        powered: (T, joints), see ``Servos``.
        motion: over ground; None on a bench or where not asked for.
    """

    t_s: Floats
    applied_rad: Floats
    joint_angle_rad: Floats
    encoder_rad: Floats
    variance_rad2: Floats
    load_nm: Floats
    powered: Bools
    motion: BodyMotion | None


def predict(
    robot: Robot,
    specs: Iterable[EffectSpec | str],
    t_s: npt.ArrayLike,
    command_rad: npt.ArrayLike,
    *,
    measured_rad: npt.ArrayLike | None = None,
    applied_rad: npt.ArrayLike | None = None,
    joint_angle_rad: npt.ArrayLike | None = None,
    initial_rad: npt.ArrayLike | None = None,
    load_nm: npt.ArrayLike | None = None,
    pose: npt.ArrayLike = (0.0, 0.0, 0.0),
    body: bool = True,
    quantise: bool = True,
) -> PredictedRun:
    """What this robot with these effects shows of a run. Deterministic; the same kernel as ``Plant``.

    A reading at ``t_s[i]`` is taken before the command of row i can have an effect. Commands are held until the next.

    Args:
        robot: its own effects are part of it.
        specs: further effects.
        t_s: (T,) rising times of the samples, as they were.
        command_rad: (T, joints); NaN: servo off.
        measured_rad: (T, joints) readings. Taken from it: the joints' start, and joints while their servo is off.
        applied_rad: (T, joints) set-points that the board said were in force: the link stage is skipped.
        joint_angle_rad: (T, joints) true joint angles: link and servo stage are skipped.
        initial_rad: (joints,) joint angles at the first sample; otherwise those measured, or rest at the first command.
        load_nm: (T, joints) known torques on the servos; otherwise they are simulated where an effect needs them.
        pose: x, y, heading at the first sample.
        body: False skips the motion over ground.
        quantise: round readings to the encoder's counts. A fit is better off without: the objective stays smooth, and
            the variance accounts for it either way.

    Raises:
        BadInputError: shapes that do not fit, or effects that do not fit the robot.
    """
    stages = assemble(robot, specs)
    t = np.asarray(t_s, dtype=np.float64)
    if t.ndim != 1 or t.size < 2 or not np.all(np.isfinite(t)) or np.any(np.diff(t) <= 0):
        raise BadInputError("prediction: the times of a run must be two or more, and rise")
    command = _table(command_rad, t, stages.robot, "command_rad")
    measured = None if measured_rad is None else _table(measured_rad, t, stages.robot, "measured_rad")
    if applied_rad is None:
        track = stages.link(t, command)
    else:
        track = Track(t, _table(applied_rad, t, stages.robot, "applied_rad"))
    known = None if measured is None else stages.true_angle(t, measured)
    base: Floats | None = None
    if joint_angle_rad is None:
        load = None if load_nm is None else _table(load_nm, t, stages.robot, "load_nm")
        made = joint_run(stages, ServoRun(t, track, initial_rad, known, load, pose))
        angle, base, reading = made.angle_rad, made.servos.base, made.reading_rad
        load_felt, powered = made.servos.load_nm, made.servos.powered
    else:
        angle = _table(joint_angle_rad, t, stages.robot, "joint_angle_rad")
        load_felt, powered = np.zeros_like(angle), np.isfinite(setpoint_at(track, t))
        reading = stages.reading(t, angle)
    variance = stages.reading_variance_rad2(t, angle.shape)
    if track.variance_rad2 is not None:
        variance = variance + setpoint_variance_rad2(stages, track, t)
    motion = None
    if body and stages.model is not None:
        motion = body_stage(stages, t, angle, pose=pose) if base is None else _motion(t, base)
    if quantise:
        reading = stages.in_counts(reading)
    return PredictedRun(t, setpoint_at(track, t), angle, reading, variance, load_felt, powered, motion)


def setpoint_variance_rad2(stages: Stages, track: Track, t_s: Floats) -> Floats:
    """Upper bound (T, joints) on the variance of joint angles when chance decides on the set-points (``track``).

    The standard deviation behind a linear filter is at most the filtered standard deviation (Minkowski); what is
    nonlinear in the servos is left out.
    """
    from snakebot.physics.servo_chain import DrivenChain

    if track.variance_rad2 is None:
        return np.zeros((t_s.size, track.setpoint_rad.shape[1]))
    rows = layout.nominal_parameters(stages.robot.joints, 0.0)
    for column in (
        layout.SOURCE,
        layout.GAIN,
        layout.TIME_CONSTANT_S,
        layout.NATURAL_FREQ_RAD_S,
        layout.DAMPING_RATIO,
    ):
        rows[:, column] = stages.servo_rows[:, column]
    track = track.of_one_clock()
    assert track.variance_rad2 is not None
    deviation = np.sqrt(np.nan_to_num(track.variance_rad2))
    servos = DrivenChain(rows, np.zeros(stages.robot.joints), t_s=float(t_s[0]), grid_s=GRID_S)
    found: Floats = servos.run(t_s, track.time_s, deviation).angle ** 2
    return found


@dataclass(frozen=True, eq=False)
class JointRun:
    """What the joints of a robot do and show in a run: the servo stage, and mean readings (T, joints)."""

    servos: Servos
    reading_rad: Floats

    @property
    def angle_rad(self) -> Floats:
        """(T, joints) joint angles."""
        return self.servos.joint_angle_rad


def joint_run(stages: Stages, run: ServoRun, joints: Sequence[int] | None = None) -> JointRun:
    """Set-points behind the link (``Stages.link``) through servos and sensors to readings. See ``servo_stages``."""
    return joint_runs(stages, [run], joints)[0]


def joint_runs(
    stages: Stages, runs: Sequence[ServoRun], joints: Sequence[int] | None = None
) -> list[JointRun]:
    """The same of several runs."""
    made = servo_stages(stages, runs, joints)
    return [
        JointRun(servos, stages.reading(run.t_s, servos.joint_angle_rad))
        for run, servos in zip(runs, made, strict=True)
    ]


def body_stage(
    stages: Stages,
    t_s: npt.ArrayLike,
    joint_angle_rad: npt.ArrayLike,
    *,
    pose: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> BodyMotion:
    """Joint angles (T, joints) to motion over ground; gaps (NaN) are bridged by straight lines."""
    trajectory = replay_stage(stages, t_s, joint_angle_rad, pose=pose)
    return BodyMotion(trajectory.t_s, trajectory.com_m, trajectory.heading_rad, trajectory.com_velocity_m_s)


def replay_stage(
    stages: Stages,
    t_s: npt.ArrayLike,
    joint_angle_rad: npt.ArrayLike,
    *,
    pose: npt.ArrayLike = (0.0, 0.0, 0.0),
    max_step_s: float | None = None,
) -> Trajectory:
    """``body_stage`` with joint torques and powers; ``max_step_s`` as for ``replay``, None: its own.

    Raises:
        BadInputError: the robot has no body.
    """
    from snakebot.physics import replay

    if stages.model is None:
        raise BadInputError(f"robot {stages.robot.name} has no body to move")
    x, y, heading = (float(v) for v in np.asarray(pose, dtype=np.float64))
    angle = filled(np.asarray(joint_angle_rad, dtype=np.float64))
    step = {} if max_step_s is None else {"max_step_s": max_step_s}
    return replay(stages.model, t_s, angle, x_m=x, y_m=y, heading_rad=heading, **step)


def _motion(t_s: Floats, base: Floats) -> BodyMotion:
    return BodyMotion(t_s, base[:, 0:2], base[:, 2], base[:, 3:5])


def _table(given: npt.ArrayLike, t_s: Floats, robot: Robot, name: str) -> Floats:
    table = np.asarray(given, dtype=np.float64)
    if table.shape != (t_s.size, robot.joints):
        raise BadInputError(
            f"prediction: {name} is {table.shape}; expected ({t_s.size}, {robot.joints}) for {robot.joints} joints"
        )
    return table
