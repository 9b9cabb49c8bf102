"""What a gait that nobody has run will do: speed, tracking error and power, with what is not known of the robot."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.calibrated.spread import drawn, known_numbers
from snakebot.clock import RATE_HZ
from snakebot.effects.prediction import predict, replay_stage
from snakebot.effects.stages import assemble
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.gait import Motion
    from snakebot.robot import Robot

LEAST_S = 1.0  # between the ramps; chosen
MOST_S = 3600.0  # of a motion; a gait repeats itself long before, and samples of all of it are held; chosen
LEAST_DRAWS = 39  # the fewest of which a 95 % band is not just the extremes: 2 / 0.05 - 1
INSIDE = 0.95  # of a band
SCATTER = 200  # errors of the speed that are tried on each draw; chosen


@dataclass(frozen=True)
class Banded:
    """A figure at the description's numbers, and its 95 % band."""

    estimate: float
    low: float
    high: float


@dataclass(frozen=True)
class Forecast:
    """A gait's figures, over its whole cycles between the ramps.

    Attributes:
        forward_speed_m_s, power_w: of the way along the heading, and mean of torque times rate over all joints; None
            without a body.
        tracking_error_deg: root mean square of set-point less reading, over all joints; ``by_joint`` of each.
        draws: of robots that may be meant; ``numbers``: what was drawn.
    """

    forward_speed_m_s: Banded | None
    power_w: Banded | None
    tracking_error_deg: Banded
    by_joint: tuple[Banded, ...]
    draws: int
    numbers: tuple[str, ...]

    def to_mapping(self) -> dict[str, Any]:
        return {"schema": "snakebot.forecast/1", **asdict(self)}


def forecast(
    robot: Robot,
    motion: Motion,
    *,
    period_s: float,
    ramp_s: float,
    draws: int = 64,
    seed: int = 0,
    progress: Callable[[float], None] = lambda share: None,
) -> Forecast:
    """Simulate the motion for the robot, and for ``draws`` robots that it may be.

    Args:
        period_s: of the gait.
        ramp_s: at either end.
        seed: of the draws.

    Raises:
        BadInputError: no cycle, too short, too long, too few draws, or numbers that do not fit the robot.
    """
    if draws < LEAST_DRAWS:
        raise BadInputError(f"--draws {draws}: a 95 % band needs at least {LEAST_DRAWS}")
    if not math.isfinite(period_s):
        raise BadInputError("--omega 0: without a cycle there are no figures of one")
    if motion.duration_s > MOST_S:
        raise BadInputError(f"--duration {motion.duration_s:g}: at most {MOST_S:g} s are predicted")
    end_s = motion.duration_s - ramp_s
    cycles = math.floor((end_s - ramp_s) / period_s + 1e-9)
    if end_s - ramp_s < LEAST_S or cycles < 1:
        raise BadInputError(
            f"--duration {motion.duration_s:g}: leaves no whole cycle of {period_s:.3g} s and {LEAST_S:g} s between "
            f"the ramps of {ramp_s:g} s"
        )
    numbers = known_numbers(robot)
    rng = np.random.default_rng(seed)
    span = (end_s - cycles * period_s, end_s)
    point = figures(robot, motion, span)
    rows = []
    for index in range(draws if numbers else 0):
        rows.append(figures(drawn(robot, numbers, rng), motion, span))
        progress((index + 1) / draws)
    table = np.array(rows) if rows else point[None, :]
    banded = _bands(point, table)
    left_m_s = robot.tolerance.left_of_speed_m_s(float(point[0])) if robot.body is not None else 0.0
    if left_m_s > 0:  # a calibration's error on runs that it was not fitted to
        scatter = np.random.default_rng(seed).normal(scale=left_m_s, size=(SCATTER, table.shape[0], 1))
        banded[0] = _bands(point[:1], (table[:, :1] + scatter).reshape(-1, 1))[0]
    body = robot.body is not None
    return Forecast(
        forward_speed_m_s=banded[0] if body else None,
        power_w=banded[1] if body else None,
        tracking_error_deg=banded[2],
        by_joint=tuple(banded[3:]),
        draws=len(rows),
        numbers=tuple(dict.fromkeys(known.number for known in numbers)),
    )


def figures(robot: Robot, motion: Motion, span_s: tuple[float, float]) -> Floats:
    """(3 + joints,) forward speed, power, tracking error of all joints and of each; NaN where there is no body."""
    t = np.arange(round(motion.duration_s * RATE_HZ) + 1) / RATE_HZ
    command = motion.sampled(t)
    made = predict(robot, (), t, command, body=False, quantise=False)
    use = (t >= span_s[0] - 1e-9) & (t <= span_s[1] + 1e-9)
    square = np.mean(np.square(command - made.encoder_rad)[use] + made.variance_rad2[use], axis=0)
    speed = power = math.nan
    if robot.body is not None:
        path = replay_stage(assemble(robot), t, made.joint_angle_rad)
        speed = path.forward_speed_m_s(*span_s)
        power = float(np.mean(path.power_in_w[use]))
    errors = np.degrees(np.sqrt([square.mean(), *square]))
    return np.array([speed, power, *errors])


def _bands(point: Floats, rows: Floats) -> list[Banded]:
    """The band of each figure: one more draw falls into it with a probability of ``INSIDE``."""
    tail = 0.5 * (1 - INSIDE)
    low, high = np.quantile(rows, [tail, 1 - tail], axis=0, method="weibull")
    return [Banded(float(p), float(a), float(b)) for p, a, b in zip(point, low, high, strict=True)]
