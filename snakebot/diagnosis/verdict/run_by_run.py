"""Values that differ from run to run: a limit of speed that falls with the battery, a lag that a load adds to.

An explanation has one value for all runs. Where it leaves a rest, the first number of each of its effects may be
another one in each run that was fitted, all others as they are. If that takes much of the rest away, and the values
are clearly apart, the robot was not the same in all runs, or what ails it follows another law than the effect named.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from snakebot.arrays import Floats, Ints
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.fit_runs import fit_runs, shift_limits
from snakebot.diagnosis.fit.least_squares import FULL_STEPS
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.fit.uncertainty import interval
from snakebot.diagnosis.result import RunEstimate, RunValues
from snakebot.diagnosis.sizes import BEYOND_CHANCE, MUCH
from snakebot.effects.parameter import Parameter
from snakebot.effects.registry import find_effect
from snakebot.effects.telling import joints_in_words, shown, title


@dataclass(frozen=True, eq=False)
class _Number:
    """The first parameter of a term, of joints that share it.

    Attributes:
        at: its place among all parameters of the hypothesis.
        joints: 1-based, that it acts on.
    """

    at: int
    effect: str
    parameter: Parameter
    joints: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class _Own:
    """A parameter with a value of its own in each of some runs.

    Attributes:
        value: (R,).
        scatter: (R,) standard errors by the scatter of each run.
    """

    parameter: Parameter
    runs: tuple[int, ...]
    value: Floats
    scatter: Floats

    @property
    def error(self) -> Floats:
        """(R,) standard errors, with what a real effect differs in from the library's."""
        return np.hypot(self.scatter, self.parameter.real_share * (self.value - self.parameter.neutral))

    def apart(self, low: Ints | int, high: Ints | int, error: Floats) -> Floats:
        """By how many of some standard errors (R,) values are above others, on the scale that they are fitted on."""
        value = self.value
        if self.parameter.scale == "log":
            value, error = np.log(value), error / value
        gap = np.maximum(np.hypot(error[low], error[high]), 1e-300)
        return np.asarray((value[high] - value[low]) / gap)

    @property
    def differ(self) -> bool:
        """Whether the lowest and the highest value are clearly apart, and further than chance drives the ends of so
        many.
        """
        count = len(self.runs)
        if count < 2:
            return False
        ends = int(np.argmin(self.value)), int(np.argmax(self.value))
        pairs = count * (count - 1) / 2
        by_chance = -NormalDist().inv_cdf(NormalDist().cdf(-BEYOND_CHANCE) / pairs)
        return bool(
            self.apart(*ends, self.scatter) > by_chance and self.apart(*ends, self.error) > BEYOND_CHANCE
        )

    @property
    def unlike(self) -> list[int]:
        """Places of the runs below or above the clearest step between two values: the fewer, or later."""
        order = np.argsort(self.value, kind="stable")
        cut = int(np.argmax(self.apart(order[:-1], order[1:], self.error))) + 1
        sides = (sorted(side.tolist()) for side in (order[:cut], order[cut:]))
        return min(sides, key=lambda side: (len(side), -side[0]))


def run_values(evidence: Evidence, best: Trial) -> RunValues | None:
    """The number that differs most between the runs that were fitted, if any does so clearly and much of the rest there
    goes with it. None where the body must be simulated for every guess.
    """
    simulator = evidence.predictor.simulator
    with_rest = gap_of(evidence.scoring, best.held_square).significant
    if not with_rest.any() or simulator.rough_needs_body(best.specs):
        return None
    rough = simulator.needs_body(best.specs)
    at_rest = set((np.flatnonzero(with_rest) + 1).tolist())
    numbers = [n for n in _numbers(best, evidence.data.joints) if not at_rest.isdisjoint(n.joints)]
    asked = [(number, _each_run(evidence, best, number, rough)) for number in numbers]
    differ = [(number, own) for number, own in asked if own.differ]
    if not differ:
        return None
    left = _Left(evidence, best, rough)
    gains = [left.gain(number.at, own, at_rest.intersection(number.joints)) for number, own in differ]
    found = [
        _told(evidence, number, own, gain)
        for (number, own), gain in zip(differ, gains, strict=True)
        if gain > MUCH
    ]
    # of joints that are as clear, the first
    return max(found, key=lambda values: values.of_rest, default=None)


def _numbers(best: Trial, count: int) -> list[_Number]:
    """Of servos and sensors; what is lost at random has no value that a run could be asked for."""
    found, at = [], 0
    for term in best.hypothesis.terms:
        of_one = term.open_of_one
        for joints in term.alike:
            if of_one and term.stage != "body" and "scatter" not in find_effect(term.effect).shows_in:
                found.append(_Number(at, term.effect, of_one[0], joints or tuple(range(1, count + 1))))
            at += len(of_one)
    return found


def _each_run(evidence: Evidence, best: Trial, number: _Number, rough: bool) -> _Own:
    """The runs that say something of a number, and what; none at the end of what it may be, where a run that does not
    meet a limit puts it, unless the effect is absent there.
    """
    only = np.arange(best.theta.size) == number.at

    def fitted(run: int) -> tuple[float, float]:
        fit = fit_runs(
            evidence,
            best.hypothesis,
            [best.theta],
            [run],
            FULL_STEPS,
            covariance=True,
            rough=rough,
            sides=(False,),
            only=only,
        )
        return float(fit.theta[number.at]), math.sqrt(fit.covariance[number.at, number.at])

    free, parameter = evidence.split.free, number.parameter
    rows = [
        (run, value, error)
        for run, (value, error) in zip(free, in_parallel(fitted, free), strict=True)
        if math.isfinite(error) and (parameter.lower < value < parameter.upper or value == parameter.neutral)
    ]
    runs, values, errors = zip(*rows, strict=True) if rows else ((), (), ())
    return _Own(parameter, tuple(runs), np.array(values), np.array(errors))


class _Left:
    """What the explanation leaves over, with a number of its own in each run or without."""

    def __init__(self, evidence: Evidence, best: Trial, rough: bool) -> None:
        self._evidence, self._best, self._rough = evidence, best, rough
        every = range(len(evidence.data.runs))
        self._readings = evidence.predictor.readings(best.specs, every, rough)
        self._square = self._squares(self._readings)

    def _squares(self, readings: Sequence[Floats]) -> Floats:
        """(B,) mean squares, with the lags as far off as is credible and the fitted runs say."""
        angles, free = self._evidence.angles, self._evidence.split.free
        shifts_s = angles.shifts_s(readings, free, shift_limits(angles, self._best.hypothesis))
        return angles.blocks.mean_square(angles.residuals(readings, shifts_s))

    def gain(self, at: int, own: _Own, joints: Collection[int]) -> float:
        """Share of the rest of the fitted runs, on some joints (1-based), that goes with values of the parameter ``at``
        of each run's own.
        """
        blocks, readings = self._evidence.angles.blocks, list(self._readings)
        for run, value in zip(own.runs, own.value.tolist(), strict=True):
            theta = self._best.theta.copy()
            theta[at] = value
            specs = self._best.hypothesis.specs(theta)
            readings[run] = self._evidence.predictor.readings(specs, [run], self._rough)[0]
        rows = np.isin(blocks.joint + 1, list(joints)) & np.isin(blocks.run, self._evidence.split.free)
        allowed = self._evidence.angles.allowed_square
        before, after = (
            float((np.maximum(square - allowed, 0.0) * blocks.samples)[rows].sum())
            for square in (self._square, self._squares(readings))
        )
        return 1 - after / before if before > 0 else 0.0


def _told(evidence: Evidence, number: _Number, own: _Own, gain: float) -> RunValues:
    parameter, data = number.parameter, evidence.data
    rows = [
        RunEstimate(run=data.runs[run].name, estimate=v, ci95=interval(parameter, v, e))
        for run, v, e in zip(own.runs, own.value.tolist(), own.error.tolist(), strict=True)
    ]
    return RunValues(
        effect=number.effect,
        parameter=parameter.name,
        unit=parameter.unit,
        joints=number.joints,
        values=tuple(rows),
        unlike=tuple(rows[at].run for at in own.unlike),
        of_rest=round(min(gain, 1.0), 4),
    )


def in_words(values: RunValues, count: int) -> str:
    """A warning: of a robot with ``count`` joints."""
    effect = find_effect(values.effect)
    parameter = effect.parameter(values.parameter)
    low, high = (pick(values.values, key=lambda row: row.estimate) for pick in (min, max))
    on = joints_in_words(values.joints, count)
    return (
        f"{on}, {title(effect)}: {parameter.called} differs from run to run, from {shown(parameter, low.estimate)} in "
        f"{low.run} to {shown(parameter, high.estimate)} in {high.run}; with a value for each run "
        f"{values.of_rest:.0%} of the rest goes away. Look at what differs between these runs (load, supply, "
        "temperature, a setting: diagnose such runs apart); if only the motion does, it follows another law"
    )
