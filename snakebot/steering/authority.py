"""How far an offset may go, and how fast, without breaking a limit of the robot."""

from __future__ import annotations

import copy
import itertools
import math
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion
from snakebot.gait.blend import BLEND_PEAK_CURVATURE, BLEND_PEAK_SLOPE
from snakebot.gait.limits import CHECK_STEP_S
from snakebot.robot import Robot

# Farther out the body curls: on the built-in robot at (37, 80, 2) the turn is in proportion up to here, and the speed
# down to 0.6 of that without an offset.
MOST_RAD = math.radians(30)
_LEAST_RAD = math.radians(1)  # less to either side is no steering; chosen
_LEAST_STEP_RAD = math.radians(0.5)  # that one change must be able to make; chosen
_BLEND_S = 1.0  # of a change, where the cycle is long enough; chosen, as for a change of gait
_BLEND_SHARE = 0.5  # of the cycle, where it is not
_PHASES = (0.0, 0.25, 0.5, 0.75)  # of a step: where the samples of another check may stand
# Share of a limit that is used: the rest is for rounding, and for a peak of 20 rad/s an eighth of a step off a sample.
_EXACT = 1 - 2e-5


@dataclass(frozen=True, slots=True)
class Authority:
    """Where the steering offset may be, what one change of it may be, and within what time it blends."""

    low_rad: float
    high_rad: float
    step_rad: float
    blend_s: float

    def limited(self, wanted_rad: float, before_rad: float) -> float:
        """The nearest offset that may follow ``before_rad``, which may lie outside: another gait has another room."""
        within = min(max(wanted_rad, self.low_rad), self.high_rad)
        return min(max(within, before_rad - self.step_rad), before_rad + self.step_rad)


def authority_of(motion: GaitMotion, robot: Robot) -> Authority:
    """What may be added to a gait that keeps the limits itself. The offset stands still during the run's two ramps.

    What the motion is steered by already does not count: the result is for the whole steering offset.

    Raises:
        BadInputError: the limits leave no room to steer with.
    """
    gait = motion.gait
    angle = _EXACT * min(robot.angle_limit_rad) - gait.alpha_rad
    aside = min(MOST_RAD, _EXACT * _room_in_ramps(motion, robot))
    low, high = max(-angle - gait.offset_rad, -aside), min(angle - gait.offset_rad, aside)
    if min(-low, high) < _LEAST_RAD:
        raise BadInputError(
            f"robot {robot.name!r} leaves {max(math.degrees(min(-low, high)), 0.0):.2g} deg beside this gait to steer "
            "with: lower --alpha, --omega or --offset, or lengthen --ramp"
        )
    speed = min(robot.speed_limit_rad_s) - gait.alpha_rad * gait.omega_rad_s
    acceleration = min(robot.acceleration_limit_rad_s2) - gait.alpha_rad * gait.omega_rad_s**2
    step = blend_s = 0.0
    for blend_s in (min(_BLEND_S, _BLEND_SHARE * gait.period_s), 0.95 * gait.period_s):
        step = _EXACT * min(
            speed * blend_s / BLEND_PEAK_SLOPE, acceleration * blend_s**2 / BLEND_PEAK_CURVATURE
        )
        if step >= high - low:
            break
    if step < _LEAST_STEP_RAD:
        raise BadInputError(
            f"this gait is so near the speed or acceleration limits of robot {robot.name!r} that no change of its "
            "offset fits beside it: lower --omega or --alpha"
        )
    return Authority(low, high, step, blend_s)


def _room_in_ramps(motion: GaitMotion, robot: Robot) -> float:
    """The largest constant offset, to either side, with which both ramps keep all limits, rad.

    A ramp multiplies the offset by a share of time, so that angles, speeds and accelerations are linear in it.
    """
    if motion.ramp_s <= 0:
        return math.inf
    plain = copy.copy(motion)
    plain.steering = None
    room = math.inf
    ticks = np.arange(-2, math.ceil(motion.ramp_s / CHECK_STEP_S) + 3, dtype=np.float64)
    for begin_s, phase in itertools.product((0.0, motion.duration_s - motion.ramp_s), _PHASES):
        t: Floats = begin_s + CHECK_STEP_S * (ticks + phase)
        parts = [plain.sampled(t), _share(motion, t)[:, None]]
        for limit in (robot.angle_limit_rad, robot.speed_limit_rad_s, robot.acceleration_limit_rad_s2):
            wave, share = parts
            left = np.maximum(np.asarray(limit) - np.abs(wave), 0.0)
            moves = np.abs(share[:, 0]) > 1e-9
            if moves.any():
                room = min(room, float((left[moves] / np.abs(share[moves])).min()))
            parts = [np.diff(part, axis=0) / CHECK_STEP_S for part in parts]
    return room


def _share(motion: GaitMotion, t_s: Floats) -> Floats:
    """Share (T,) of an offset that reaches the joints: that of a motion which is nothing but an offset of 1 rad."""
    bend = GaitMotion(Gait(0.0, 0.0, 0.0, 1.0), 1, motion.duration_s, motion.ramp_s)
    return np.asarray(bend.sampled(t_s)[:, 0])
