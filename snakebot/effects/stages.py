"""A robot with its effects, cut at the boundaries of the signal: link, servo, sensor, body."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Floats
from snakebot.effects.effect import LinkFilter, SensorFilter, ServoFilter, Track
from snakebot.effects.ground import Ground
from snakebot.effects.registry import effects
from snakebot.effects.spec import EffectSpec, parse_effects, robot_effects
from snakebot.errors import BadInputError
from snakebot.nearest import did_you_mean
from snakebot.physics import servo_layout as layout
from snakebot.physics.model import STANDARD_GRAVITY_M_S2

if TYPE_CHECKING:
    from snakebot.physics.model import ChainModel
    from snakebot.robot import Body, Robot


FILTER_STEP_S = 2e-3  # of servo filters, counted from time zero; chosen: as the grid of predictions
_UNIT_ARM_M = 0.15  # length of an arm that weighs 1 N m; only inertia depends on it. Chosen, a bench arm's


@dataclass(frozen=True)
class Arm:
    """What a bench's servo carries: ``servo.arm`` of a robot without a body. Angles are the joint's own.

    Attributes:
        mass_kg, length_m: a point mass at the end of a massless arm.
        down_deg: joint angle at which it hangs straight down.
        drag_nm_s, coulomb_nm: friction of the joint while the servo is off.
    """

    mass_kg: float
    length_m: float
    down_deg: float = 0.0
    drag_nm_s: float = 0.0
    coulomb_nm: float = 0.0


class Stages:
    """What ``assemble`` makes; immutable, cheap, good for any number of runs."""

    def __init__(self, robot: Robot, specs: tuple[EffectSpec, ...]) -> None:
        self.robot = robot
        self.specs = specs

    @cached_property
    def servo_rows(self) -> Floats:
        """(joints, PARAMETERS) of ``physics.servo_layout``, all servo effects in it."""
        robot = self.robot
        rows = layout.nominal_parameters(robot.joints, robot.servo.time_constant_s)
        arm = arm_of(robot)
        if arm is not None:
            inertia = arm.mass_kg * arm.length_m**2
            rows[:, layout.ARM_GRAVITY_NM] = arm.mass_kg * STANDARD_GRAVITY_M_S2 * arm.length_m
            rows[:, layout.ARM_DOWN_RAD] = math.radians(arm.down_deg)
            rows[:, layout.ARM_INERTIA_KG_M2] = inertia
            rows[:, layout.ARM_DRAG_NM_S] = arm.drag_nm_s
            rows[:, layout.ARM_COULOMB_NM] = arm.coulomb_nm
        for spec in self.specs:
            spec.effect.write_servo(rows, spec.joint_indices(robot.joints), spec, robot)
        rows.setflags(write=False)
        return rows

    @cached_property
    def model(self) -> ChainModel | None:
        """The body on its ground, all body effects in it; None on a bench."""
        if self.robot.body is None:
            return None
        if not any(spec.effect.stage == "body" for spec in self.specs):
            return _as_described(self.robot.body)
        ground = Ground(self.robot.body)
        for spec in self.specs:
            spec.effect.write_ground(ground, spec, self.robot)
        return ground.model()

    @cached_property
    def feels_load(self) -> bool:
        """Whether the servos' motion depends on the torque they bear."""
        return layout.feels_load(self.servo_rows)

    @cached_property
    def broken(self) -> tuple[bool, bool]:
        """Whether any joint is free; and whether any is rigid."""
        locked = self.servo_rows[:, layout.LOCKED]
        return bool((locked == layout.FREE_JOINT).any()), bool((locked == layout.RIGID_JOINT).any())

    def link_filters(self) -> list[LinkFilter]:
        """Fresh ones, in the order of the signal."""
        return [f for s in self.specs if (f := s.effect.link_filter(s, self.robot)) is not None]

    @cached_property
    def late_s(self) -> Floats:
        """(joints,) how much later than the others each joint gets its set-points."""
        late = np.zeros(self.robot.joints)
        for spec in self.specs:
            late[list(spec.joint_indices(late.size))] += spec.effect.late_s(spec)
        return late

    def servo_filters(self) -> list[ServoFilter]:
        """Fresh ones, in the order of the signal."""
        return [f for s in self.specs if (f := s.effect.servo_filter(s, self.robot)) is not None]

    def sensor_filters(self) -> list[SensorFilter]:
        """Fresh ones, in the order of the signal."""
        return [f for s in self.specs if (f := s.effect.sensor_filter(s, self.robot)) is not None]

    def link(self, t_s: npt.ArrayLike, command_rad: npt.ArrayLike) -> Track:
        """Set-points in force from commands (T, joints) that were sent at ``t_s`` (T,)."""
        track = Track(np.asarray(t_s, dtype=np.float64), np.asarray(command_rad, dtype=np.float64))
        for link_filter in self.link_filters():
            track = link_filter.batch(track)
        return replace(track, late_s=self.late_s) if self.late_s.any() else track

    def reading(self, t_s: npt.ArrayLike, joint_angle_rad: npt.ArrayLike) -> Floats:
        """Mean reading (T, joints) of joint angles (T, joints), before it is rounded to counts."""
        t = np.asarray(t_s, dtype=np.float64)
        reading: Floats = np.asarray(joint_angle_rad, dtype=np.float64)
        for sensor_filter in self.sensor_filters():
            reading = sensor_filter.batch(t, reading)
        return reading

    def reading_variance_rad2(self, t_s: npt.ArrayLike, shape: tuple[int, ...]) -> Floats:
        """Variance (T, joints) of readings about their mean, with that of the counts."""
        t = np.asarray(t_s, dtype=np.float64)
        variance = np.full(shape, self.robot.rad_per_count**2 / 12)
        for sensor_filter in self.sensor_filters():
            variance = variance + sensor_filter.variance_rad2(t)
        return variance

    def in_counts(self, reading_rad: Floats) -> Floats:
        """Readings rounded to the encoder's counts."""
        step = self.robot.rad_per_count
        rounded: Floats = np.round(reading_rad / step) * step
        return rounded

    def true_angle(self, t_s: npt.ArrayLike, encoder_rad: npt.ArrayLike) -> Floats:
        """Joint angles that would give these readings: the sensor stage undone, as far as it is affine."""
        t, reading = np.asarray(t_s, dtype=np.float64), np.asarray(encoder_rad, dtype=np.float64)
        zero = self.reading(t, np.zeros_like(reading))
        one = self.reading(t, np.ones_like(reading))
        angle: Floats = (reading - zero) / (one - zero)
        return angle

    def torque_of(self, t_s: npt.ArrayLike, joint_angle_rad: npt.ArrayLike) -> Floats | None:
        """Joint torques (T, joints) of a motion; None where neither body nor arm is known."""
        t, angle = np.asarray(t_s, dtype=np.float64), filled(np.asarray(joint_angle_rad, dtype=np.float64))
        if self.model is not None:
            from snakebot.physics import replay

            return replay(self.model, t, angle).joint_torque_nm
        rows = self.servo_rows
        if not rows[:, layout.ARM_GRAVITY_NM].any():
            return None
        rate = np.gradient(angle, t, axis=0)
        gravity = rows[:, layout.ARM_GRAVITY_NM] * np.sin(angle - rows[:, layout.ARM_DOWN_RAD])
        torque: Floats = gravity + rows[:, layout.ARM_INERTIA_KG_M2] * np.gradient(rate, t, axis=0)
        return torque


def assemble(robot: Robot, specs: Iterable[EffectSpec | str] = (), *, own_effects: bool = True) -> Stages:
    """Put a robot and its effects together, in the order of the signal whatever the order given.

    The same effect may be given several times, for different joints; on the same joint the last one holds, but link
    effects add up.

    Args:
        specs: on top of the effects in the robot's own description.
        own_effects: False leaves those out.

    Raises:
        BadInputError: an effect that does not fit the robot.
    """
    given = tuple(robot_effects(robot)) if own_effects else ()
    for spec in specs:
        given += parse_effects([spec], robot) if isinstance(spec, str) else (spec.checked(robot),)
    given = tuple(part for spec in given for part in spec.by_joint())
    order = {name: rank for rank, name in enumerate(effects())}
    return Stages(robot, tuple(sorted(given, key=lambda spec: order[spec.name])))


@lru_cache(maxsize=16)
def _as_described(body: Body) -> ChainModel:
    """A body without any effect: a diagnosis asks for the same one thousands of times."""
    return Ground(body).model()


def arm_of(robot: Robot) -> Arm | None:
    """The arm that a bench's description gives its servo (``servo: {arm: {...}}``), or None.

    Raises:
        BadInputError: the arm has other keys or is no arm.
    """
    given: Any = (robot.servo.model_extra or {}).get("arm")
    if given is None or robot.body is not None:
        return None
    try:
        arm = (
            Arm(**{key: float(value) for key, value in given.items()}) if isinstance(given, Mapping) else None
        )
    except (TypeError, ValueError):
        arm = None
    if arm is None or not (0 < arm.mass_kg < math.inf and 0 < arm.length_m < math.inf):
        keys = list(Arm.__dataclass_fields__)
        strange = [key for key in given if key not in keys] if isinstance(given, Mapping) else []
        hint = did_you_mean(strange[0], keys).replace(";", f"; {strange[0]} is not known,") if strange else ""
        raise BadInputError(
            f"robot {robot.name}: servo.arm takes numbers for {', '.join(keys)}; mass_kg and length_m above zero{hint}"
        )
    return arm


def with_unit_arm(robot: Robot, hangs_at_rad: float) -> Robot:
    """A bench whose arm is not described, with one that weighs 1 N m when it is level.

    What load effects then find in N m is in units of the true arm's weight. ``hangs_at_rad``: joint angle at which the
    arm hangs straight down, as ``Observed.hangs_at_rad`` reads it off a drop test. A robot with a body, or with an arm
    of its own, comes back as it is.
    """
    if robot.body is not None or arm_of(robot) is not None or not math.isfinite(hangs_at_rad):
        return robot
    arm = {"mass_kg": 1.0 / (STANDARD_GRAVITY_M_S2 * _UNIT_ARM_M), "length_m": _UNIT_ARM_M}
    arm["down_deg"] = math.degrees(hangs_at_rad)
    return robot.model_copy(update={"servo": robot.servo.model_copy(update={"arm": arm})})


def filled(table: Floats) -> Floats:
    """(T, joints) with NaN bridged by straight lines, held at the ends; a column without a number becomes 0."""
    if np.isfinite(table).all():
        return table
    out = table.copy()
    rows = np.arange(table.shape[0])
    for column in out.T:
        good = np.isfinite(column)
        column[~good] = np.interp(rows[~good], rows[good], column[good]) if good.any() else 0.0
    return out
