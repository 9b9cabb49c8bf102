"""How well a robot's numbers are known, and robots that may be meant by its description.

Fitted numbers come with the 95 % intervals that the diagnosis left in the description (``intervals``), stated ones with
their tolerance. Each is taken as normal on its own scale, and none as bound to another: where two numbers of an effect
make up for each other, draws are wider than what is known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.effects.registry import find_effect
from snakebot.effects.spec import EffectSpec, robot_effects
from snakebot.errors import BadInputError
from snakebot.robot import SERVO_LAG
from snakebot.robust import SIGMAS_95

if TYPE_CHECKING:
    from snakebot.effects.parameter import Parameter
    from snakebot.robot import Body, Interval, Robot

TRIES = 200  # at a draw within bounds; then the estimate itself


@dataclass(frozen=True)
class Known:
    """A number with what is known of it.

    Attributes:
        number: as in the description: ``effects.rate_limit.limit_rad_s``, ``servo.time_constant_s``, ``friction.ct``.
        joints: 1-based; none: of all that it acts on.
        estimate: what the description says.
        sigma: one standard deviation: of the natural logarithm where ``log``, in the unit elsewhere.
        lower, upper: bounds that a draw keeps.
        source: fitted; stated; or prior, where the recordings say nothing: the spread is then the effect's own.
    """

    number: str
    joints: tuple[int, ...]
    unit: str
    estimate: float
    sigma: float
    log: bool
    lower: float
    upper: float
    source: str

    @property
    def ci95(self) -> tuple[float, float]:
        """Of the distribution that is drawn from."""
        if self.log:
            factor = math.exp(min(SIGMAS_95 * self.sigma, 50.0))
            low, high = self.estimate / factor, self.estimate * factor
        else:
            low, high = self.estimate - SIGMAS_95 * self.sigma, self.estimate + SIGMAS_95 * self.sigma
        return max(low, self.lower), min(high, self.upper)

    def draw(self, rng: np.random.Generator) -> float:
        """A value that may be meant, within the bounds."""
        for _ in range(TRIES):
            step = self.sigma * rng.normal()
            value = self.estimate * math.exp(step) if self.log else self.estimate + step
            if self.lower <= value <= self.upper:
                return float(value)
        return self.estimate


def known_numbers(robot: Robot) -> tuple[Known, ...]:
    """All numbers of a robot that are not exact: those of its effects, then stated ones.

    Raises:
        BadInputError: an interval is of a number that its effects do not have.
    """
    return (*(_of_effect(robot, interval) for interval in robot.intervals), *_stated(robot))


def drawn(robot: Robot, numbers: Sequence[Known], rng: np.random.Generator) -> Robot:
    """A robot as this one may be: each of ``numbers`` drawn once."""
    effects = list(robot_effects(robot))
    factors: dict[str, float] = {}
    servo = robot.servo
    for known in numbers:
        value = known.draw(rng)
        if known.number.startswith("effects."):
            effects = [_with(spec, known, value) for spec in effects]
        elif known.number == SERVO_LAG:
            servo = servo.model_copy(update={"time_constant_s": value})
        else:
            factors[known.number] = value / known.estimate
    body = None if robot.body is None else _scaled(robot.body, factors)
    update = {"effects": tuple(map(str, effects)), "intervals": (), "servo": servo, "body": body}
    return robot.model_copy(update=update)


def _with(spec: EffectSpec, known: Known, value: float) -> EffectSpec:
    """The effect with the number in it, if the number is one of its own."""
    _, name, parameter = known.number.split(".")
    if spec.name != name:
        return spec
    old = spec.values.get(parameter)
    if isinstance(old, tuple):
        if spec.joints is None or len(known.joints) != 1 or known.joints[0] not in spec.joints:
            return spec
        at = spec.joints.index(known.joints[0])
        return spec.with_values(**{parameter: (*old[:at], value, *old[at + 1 :])})
    if known.joints != (spec.joints or ()):
        return spec
    return spec.with_values(**{parameter: value})


def _of_effect(robot: Robot, interval: Interval) -> Known:
    _, name, parameter_name = interval.number.split(".")
    parameter = find_effect(name).parameter(parameter_name)
    found = Known(
        number=interval.number,
        joints=interval.joints,
        unit=parameter.unit,
        estimate=interval.estimate,
        sigma=_sigma(parameter, interval),
        log=parameter.scale == "log" and interval.estimate > 0,
        lower=parameter.lower,
        upper=parameter.upper,
        source="prior" if interval.ci95 is None else "fitted",
    )
    probe = math.nan
    if all(_with(spec, found, probe) is spec for spec in robot_effects(robot)):
        where = f" on joints {'+'.join(map(str, interval.joints))}" if interval.joints else ""
        raise BadInputError(
            f"robot {robot.name}: intervals: {interval.number}{where}: the robot has no such effect; "
            "give the interval the joints of the effect, or take it out"
        )
    return found


def _sigma(parameter: Parameter, interval: Interval) -> float:
    """Of an interval: where one end stands at a bound of the parameter, the other end tells."""
    if interval.ci95 is None:
        return parameter.spread
    low, high = interval.ci95
    value = interval.estimate
    if parameter.scale == "log" and value > 0 and low > 0:
        below, above = math.log(value / low), math.log(high / value)
    else:
        below, above = value - low, high - value
    cut_below, cut_above = low <= parameter.lower, high >= parameter.upper
    if cut_below != cut_above:
        return (above if cut_below else below) / SIGMAS_95
    return 0.5 * (below + above) / SIGMAS_95


def _stated(robot: Robot) -> list[Known]:
    """Numbers with a tolerance. What the wire's delay may be off by counts as lag."""
    tolerance, tau = robot.tolerance, robot.servo.time_constant_s
    out = [_one(SERVO_LAG, "s", tau, math.hypot(robot.lag_spread_s, tolerance.delay_s))]
    if robot.body is not None:
        friction = robot.body.friction
        for key in ("ct", "cn"):
            mean = float(np.mean(getattr(friction, key)))
            out.append(_one(f"friction.{key}", "N s/m", mean, tolerance.friction * mean))
        mass = float(np.mean(robot.body.link_mass_kg))
        out.append(_one("link_mass_kg", "kg", mass, tolerance.mass * mass))
    return [known for known in out if known.sigma > 0 and known.estimate > 0]


def _one(number: str, unit: str, value: float, sigma: float) -> Known:
    return Known(number, (), unit, value, sigma, False, 0.05 * value, math.inf, "stated")


def _scaled(body: Body, factors: dict[str, float]) -> Body:
    """Viscous and dry friction of a direction are off together, and the links' masses."""
    friction = body.friction
    along, across = factors.get("friction.ct", 1.0), factors.get("friction.cn", 1.0)
    changed = friction.model_copy(
        update={
            name: _times(getattr(friction, name), factor)
            for name, factor in (("ct", along), ("ct0", along), ("cn", across), ("cn0", across))
        }
    )
    mass = _times(body.link_mass_kg, factors.get("link_mass_kg", 1.0))
    return body.model_copy(update={"friction": changed, "link_mass_kg": mass})


def _times(value: float | tuple[float, ...], factor: float) -> float | tuple[float, ...]:
    return tuple(v * factor for v in value) if isinstance(value, tuple) else value * factor
