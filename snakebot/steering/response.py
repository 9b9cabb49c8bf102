"""What a gait's offset does to a robot: turn rate per offset, from simulating its description with its effects."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.gait import Gait
    from snakebot.robot import Robot

_CYCLES = 6  # simulated from rest; the last two whole ones count
_SAMPLES = 200  # a cycle
_TRIAL_RAD = math.radians(10)  # offset to either side that the turn rate is taken at; chosen
_LEAST_TURN_RAD = math.radians(2)  # in a cycle, at the trial offset: less is no steering; chosen
_LEAST_SPEED = 0.01  # body lengths a cycle: a robot that stands has no track; chosen


@dataclass(frozen=True, slots=True)
class Response:
    """Turning and speed of one gait on one robot, as simulated.

    Attributes:
        turn_per_offset_1_s: turn rate in rad/s per rad of offset; negative where an offset to the left turns right.
        bias_rad_s: turn rate without an offset.
        speed_m_s: along the heading; negative where the gait drives the robot backwards.
        period_s: of the gait.
        body_m: length of the straight robot.
    """

    turn_per_offset_1_s: float
    bias_rad_s: float
    speed_m_s: float
    period_s: float
    body_m: float

    @property
    def turn_per_cycle(self) -> float:
        """Rad of turn that a cycle makes per rad of offset."""
        return self.turn_per_offset_1_s * self.period_s


@functools.lru_cache(maxsize=64)
def _simulated(description: str, gait: Gait) -> Response:
    from snakebot.robot import Robot

    robot = Robot.model_validate_json(description)
    assert robot.body is not None
    right, middle, left = (
        _turn_and_speed(robot, replace(gait, offset_rad=gait.offset_rad + by))
        for by in (-_TRIAL_RAD, 0.0, _TRIAL_RAD)
    )
    bias, speed = middle
    return Response(
        (left[0] - right[0]) / (2 * _TRIAL_RAD),
        bias,
        speed,
        gait.period_s,
        2 * robot.body.half_length_m * robot.body.links,
    )


def response_of(robot: Robot, gait: Gait) -> Response:
    """Simulate the gait with offsets to both sides; a tenth of a second, kept for the next time.

    Raises:
        BadInputError: a robot without a body, or a gait that does not turn by its offset, or does not move at all.
    """
    if robot.body is None:
        raise BadInputError(f"robot {robot.name!r} has no body that could hold a course")
    if not math.isfinite(gait.period_s):
        raise BadInputError("a course needs a gait with a cycle: give --omega above zero")
    response = _simulated(robot.model_dump_json(by_alias=True), gait)
    turn = abs(response.turn_per_cycle) * _TRIAL_RAD
    if not turn >= _LEAST_TURN_RAD:
        raise BadInputError(
            f"this gait cannot be steered: {math.degrees(_TRIAL_RAD):g} deg of offset turn the simulated robot by "
            f"{math.degrees(turn):.2g} deg a cycle; give another --alpha or --beta"
        )
    if not abs(response.speed_m_s) * response.period_s >= _LEAST_SPEED * response.body_m:
        raise BadInputError("this gait does not move the simulated robot: it has no course to hold")
    return response


def _turn_and_speed(robot: Robot, gait: Gait) -> tuple[float, float]:
    """Turn rate (rad/s) between the last two whole cycles, and speed along the heading in the last (m/s)."""
    from snakebot.effects.prediction import predict
    from snakebot.gait import GaitMotion

    period = gait.period_s
    t: Floats = np.arange(_CYCLES * _SAMPLES + 1, dtype=np.float64) * (period / _SAMPLES)
    motion = GaitMotion(gait, robot.joints, (_CYCLES + 1) * period, period / 2)
    made = predict(robot, (), t, motion.sampled(t), quantise=False).motion
    assert made is not None

    def mean(values: Floats, cycle: int) -> float:
        part = values[cycle * _SAMPLES : (cycle + 1) * _SAMPLES + 1]
        return float(np.trapezoid(part, dx=1 / _SAMPLES))

    last = _CYCLES - 1
    turn = (mean(made.heading_rad, last) - mean(made.heading_rad, last - 1)) / period
    return turn, mean(made.speed_m_s, last)
