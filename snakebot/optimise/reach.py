"""How far a gait goes beyond the recordings that a description was calibrated on, and what of its promise is left if
the servos can do no more than they did there.

A limit of torque or speed that no recorded motion came to leaves no mark, and no interval of a fit knows of it. The
description has the recorded range (``Robot.recorded``), so the least that a gait can be relied on for is known: what it
does on a robot whose servos end there. It is a bound of what was seen, not a belief about the servos.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects import EffectSpec, assemble
from snakebot.effects.registry import effects
from snakebot.errors import BadInputError
from snakebot.optimise.space import WITHIN
from snakebot.physics import servo_layout as layout

if TYPE_CHECKING:
    from snakebot.robot import Recorded, Robot

BEYOND = 1.1  # times what was recorded, from which on a gait is told to go beyond it; chosen
LEAST_NM = 1e-3  # that a joint is taken to have, which was never loaded; chosen


@dataclass(frozen=True)
class Beyond:
    """What a gait asks for more of than any recording did, in ``unit``; of the joint that goes farthest beyond."""

    what: str
    asked: float
    recorded: float
    unit: str

    def __str__(self) -> str:
        return f"{self.what} of {self.asked:.3g} {self.unit} where {self.recorded:.3g} were recorded"


def beyond(recorded: Recorded, gait: Floats, torque_nm: float) -> tuple[Beyond, ...]:
    """What a gait (3,) or (3 + joints,) in rad and rad/s asks for beyond the recordings.

    Args:
        torque_nm: the largest that the simulation says of it.
    """
    speed = np.array(recorded.joint_speed_rad_s)
    asked = gait[0] * gait[2] * (gait[3:] if len(gait) > 3 else np.ones(len(speed)))
    with np.errstate(divide="ignore", invalid="ignore"):
        at = int(np.argmax(np.where(asked > 0, asked / speed, 0.0)))
    found = [Beyond("a joint speed", float(asked[at]), float(speed[at]), "rad/s")]
    if recorded.omega_rad_s is not None:
        found.insert(0, Beyond("an omega", float(gait[2]), recorded.omega_rad_s, "rad/s"))
    if recorded.torque_nm is not None:
        found.append(Beyond("a torque", torque_nm, max(recorded.torque_nm), "N m"))
    return tuple(one for one in found if one.asked > BEYOND * one.recorded)


def no_more(robot: Robot, faults: Iterable[EffectSpec] = ()) -> tuple[EffectSpec, ...]:
    """Limits of each joint's servo at what the recordings asked of it, or at its own where that is less; none where
    nothing is recorded, or where the servo is simulated as a position loop, which has no such limits.
    """
    if robot.recorded is None:
        return ()
    rows = assemble(robot, faults).servo_rows
    if (rows[:, layout.LOOP_STIFFNESS_NM_RAD] > 0).any():
        return ()
    out = []
    for effect in effects().values():
        for key, values in effect.at_most(robot.recorded, rows).items():
            clip = effect.parameter(key).clip
            out += [
                EffectSpec(effect.name, {key: clip(float(v))}, (j,)) for j, v in enumerate(values, start=1)
            ]
    return tuple(out)


@dataclass(frozen=True)
class Reach:
    """What ``--within-recorded`` leaves: ranges as in ``space.WITHIN``, joint speed, and torque of each joint."""

    within: Mapping[str, tuple[float, float]]
    joint_speed_rad_s: float
    torque_nm: tuple[float, ...] | None

    @staticmethod
    def of(robot: Robot, within: Mapping[str, tuple[float, float]] | None, margin: float) -> Reach:
        """
        Args:
            margin: share of a servo's torque to be left: what was recorded may be used up all the same.

        Raises:
            BadInputError: the description does not say what was recorded, or all that is asked about lies beyond.
        """
        recorded = robot.recorded
        if recorded is None:
            raise BadInputError(
                f"--within-recorded: robot {robot.name!r} does not say what was recorded: write its description by "
                "`snakebot diagnose SESSION --apply FILE`"
            )
        ranges = {**WITHIN, **(within or {})}
        if recorded.omega_rad_s is not None:
            low, high = ranges["omega"]
            if low > recorded.omega_rad_s:
                raise BadInputError(
                    f"--within-recorded: omega from {low:g} rad/s on is beyond the fastest recorded gait, "
                    f"{recorded.omega_rad_s:g} rad/s"
                )
            ranges["omega"] = low, min(high, recorded.omega_rad_s)
        torque = None
        if recorded.torque_nm is not None:
            torque = tuple(max(end, LEAST_NM) / (1 - margin) for end in recorded.torque_nm)
        return Reach(ranges, min(recorded.joint_speed_rad_s), torque)
