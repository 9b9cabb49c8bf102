"""One explanation put to the test: fitted to all runs that may be fitted, and scored on gaits left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import GROUND, Scoring
from snakebot.diagnosis.fit.fit_runs import StackedAngles, fit_runs, ground_residuals, shift_limits
from snakebot.diagnosis.fit.fold_fits import fold_thetas
from snakebot.diagnosis.fit.hypothesis import Box, Hypothesis, Term
from snakebot.diagnosis.fit.least_squares import FEWEST_STEPS, FULL_STEPS, SOME_STEPS, Fit, multi_start
from snakebot.diagnosis.fit.step import Problem
from snakebot.diagnosis.sizes import HALF, LITTLE, OUTSTANDING
from snakebot.effects.spec import EffectSpec

# Readings of joints that a first look is made on, where there are more: five joints for a minute at 100 Hz; chosen.
FIRST_SAMPLES = 30_000
# Iterations after which such a fit is given up where it is plainly behind another explanation, and by so much held-out
# score, a fifth of the mean square: the rest of them does not make up for that.
FEW_STEPS, FAR_BEHIND = int(HALF * FEWEST_STEPS), LITTLE


@dataclass(frozen=True, eq=False)
class Trial:
    """An explanation with its fit.

    Attributes:
        theta: (p,) fitted to all free runs, in the order of the terms.
        covariance: (p, p); nan where nothing was fitted.
        fitted_square: (B,) mean squares of the blocks at ``theta``.
        held_square: (B,) the same, each run predicted from parameters that it had no part in.
        readings: held-out predictions (N, k) a run.
        left: their residuals (N, k) a run, with the shifts in time that the nominal numbers are allowed.
        run_theta: parameters by which each run was predicted, one (p,) a run; nan: the runs that were fitted say
            nothing of the effect, and it was predicted without.
    """

    hypothesis: Hypothesis
    theta: Floats
    covariance: Floats
    fitted_square: Floats
    held_square: Floats
    readings: list[Floats]
    left: list[Floats]
    run_theta: tuple[Floats, ...]

    @property
    def specs(self) -> tuple[EffectSpec, ...]:
        return self.hypothesis.specs(self.theta)

    @property
    def is_held_out(self) -> bool:
        """Whether it was cross-validated: a fit that was not is taken for what it predicts."""
        return self.held_square is not self.fitted_square

    def score(self, scoring: Scoring) -> float:
        """Mean held-out score over the deciding blocks."""
        return scoring.mean_score(self.held_square)

    def fitted_score(self, scoring: Scoring) -> float:
        """The same of the fit, nothing held out."""
        return scoring.mean_score(self.fitted_square)


def nominal_trial(evidence: Evidence) -> Trial:
    """The robot without any effect."""
    nothing = np.zeros(0)
    return _scored(
        evidence, Hypothesis(), nothing, np.zeros((0, 0)), (nothing,) * len(evidence.data.runs), cross=True
    )


def against_nominal(evidence: Evidence) -> tuple[Trial, Evidence]:
    """The robot without any effect; and the evidence in which no explanation is credited for doing better than that
    where there is no gap.
    """
    nominal = nominal_trial(evidence)
    gap = gap_of(evidence.scoring, nominal.held_square)
    with_gap = [*np.flatnonzero(gap.significant), *([GROUND] if gap.ground_significant else [])]
    healthy = ~np.isin(evidence.scoring.joint, with_gap)
    return nominal, replace(evidence, scoring=evidence.scoring.without_credit(healthy, nominal.held_square))


def informative_runs(evidence: Evidence) -> tuple[int, ...]:
    """Two of the free runs for a first look at what is slow to simulate: the largest gap, and the middling one."""
    order = _by_gap(evidence)
    return tuple(dict.fromkeys((order[0], order[len(order) // 2]))) if order else evidence.split.free


def first_runs(evidence: Evidence) -> tuple[int, ...]:
    """The free runs for a first look: of long sessions some, from the largest gap to the smallest."""
    order = _by_gap(evidence)
    sizes = [evidence.data.runs[i].use.size for i in order]
    most = int(len(order) * FIRST_SAMPLES / sum(sizes)) if sizes else 0
    if most >= len(order):
        return evidence.split.free
    picked = np.linspace(0, len(order) - 1, max(most, 2)).round().astype(int)
    return tuple(sorted({order[i] for i in picked.tolist()}))


def _by_gap(evidence: Evidence) -> list[int]:
    """The free runs that are compared, largest gap first."""
    blocks = evidence.angles.blocks
    gap = evidence.angles.mean_square(evidence.predictor.nominal)
    size = {i: float(gap[blocks.run == i].mean()) for i in evidence.split.free if np.any(blocks.run == i)}
    return sorted(size, key=lambda i: (-size[i], i))


def trial_at(evidence: Evidence, hypothesis: Hypothesis, theta: Floats) -> Trial:
    """An explanation at given parameters: nothing is fitted, nothing held out."""
    unknown = np.full((theta.size, theta.size), np.nan)
    return _scored(evidence, hypothesis, theta, unknown, [theta] * len(evidence.split.folds), cross=False)


def run_trial(
    evidence: Evidence,
    hypothesis: Hypothesis,
    starts: Sequence[Floats],
    *,
    cross: bool = True,
    rough: bool = False,
    last: bool | None = None,
    most_steps: int = FULL_STEPS,
    fitted_runs: Sequence[int] | None = None,
    interval: bool | None = None,
) -> Trial:
    """Fit ``hypothesis`` from each of ``starts`` (p,), and cross-validate it unless ``cross`` is False.

    ``rough``: a first look, with loads of the measured motion; where the whole body must be simulated even so, with
    two runs, and all terms but the last as they start. ``last``: these so in any case, or in none. ``fitted_runs``:
    those that are fitted, if others than these. ``interval``: whether a covariance is worked out; None: where it is
    cross-validated.
    """
    runs, steps = first_runs(evidence) if rough else evidence.split.free, most_steps
    specs = hypothesis.specs(starts[0]) if len(starts) else ()
    if rough and evidence.predictor.simulator.rough_needs_body(specs):
        runs, steps = informative_runs(evidence), FEWEST_STEPS
        last = last is None or last
    takes_long = last if rough else evidence.predictor.simulator.needs_body(specs)
    if takes_long:
        steps = min(steps, SOME_STEPS)
    count = len(hypothesis.parameters)
    only = np.arange(count) >= count - len(hypothesis.terms[-1].open) if last else None
    keep = hypothesis.followed
    used = runs if fitted_runs is None else fitted_runs
    fit = fit_runs(
        evidence,
        hypothesis,
        starts,
        used,
        steps,
        keep,
        covariance=cross if interval is None else interval,
        rough=rough,
        only=only,
    )
    theta, covariance = fit.theta, fit.covariance
    fold_theta = [theta] * len(evidence.split.folds)
    if cross and theta.size:
        fold_theta = fold_thetas(evidence, hypothesis, fit)
    return _scored(evidence, hypothesis, theta, covariance, fold_theta, cross=cross, rough=rough)


def run_trial_against(
    evidence: Evidence, ahead: Trial, hypothesis: Hypothesis, starts: Sequence[Floats], *, last: bool = False
) -> Trial:
    """``run_trial``; but where the whole body must be simulated, a trial that is soon seen to be far behind another
    one, ``ahead``, is left as it is then: fitted roughly, nothing held out.
    """
    if len(starts) and evidence.predictor.simulator.needs_body(hypothesis.specs(starts[0])):
        first = run_trial(evidence, hypothesis, starts, cross=False, last=last, most_steps=FEW_STEPS)
        behind = evidence.scoring.gain(ahead.held_square, first.held_square)
        if behind.mean > FAR_BEHIND and behind.z > OUTSTANDING:
            return first
        starts = [first.theta]
    return run_trial(evidence, hypothesis, starts, last=last)


def _scored(
    evidence: Evidence,
    hypothesis: Hypothesis,
    theta: Floats,
    covariance: Floats,
    fold_theta: Sequence[Floats],
    *,
    cross: bool,
    rough: bool = False,
) -> Trial:
    """The trial of a fit: each fold's runs are predicted, and shifted in time, by what its other runs say."""
    angles, scoring = evidence.angles, evidence.scoring
    limits = shift_limits(angles, hypothesis)
    coupled = evidence.predictor.simulator.needs_body(hypothesis.specs(theta))

    def predicted(at: Floats, runs: Sequence[int]) -> list[Floats]:
        return evidence.predictor.readings(hypothesis.specs(at), runs, rough)

    def ground_square(at: Floats) -> Floats:
        return np.square(
            ground_residuals(evidence.ground, evidence.predictor, hypothesis.specs(at), evidence.split.free)
        )

    every = range(len(evidence.data.runs))
    readings = predicted(theta, every)
    left = angles.residuals(readings, angles.shifts_s(readings, evidence.split.free, limits))
    fitted = np.concatenate([angles.blocks.mean_square(left), ground_square(theta)])
    run_theta = [theta] * len(every)
    if not cross or not evidence.split.folds:
        fitted = scoring.credited(fitted)
        return Trial(hypothesis, theta, covariance, fitted, fitted, readings, left, tuple(run_theta))
    held = fitted.copy()
    held_readings, held_left = list(readings), list(left)
    for fold, own in zip(evidence.split.folds, fold_theta, strict=False):
        mixed = list(readings)
        if own is not theta:
            # Where a body must be simulated, the shifts in time of the fitted runs are those at ``theta``.
            seen = sorted((*fold.fit, *fold.score)) if limits.any and not coupled else sorted(fold.score)
            for index, reading in zip(seen, predicted(own, seen), strict=True):
                mixed[index] = reading
        shifted = angles.residuals(mixed, angles.shifts_s(mixed, fold.fit, limits))
        for index in fold.score:
            run_theta[index] = own
            held_readings[index], held_left[index] = mixed[index], shifted[index]
        mine = np.isin(scoring.run, fold.score)
        held[mine] = np.concatenate([angles.blocks.mean_square(shifted), ground_square(own)])[mine]
    fitted, held = scoring.credited(fitted), scoring.credited(held)
    return Trial(hypothesis, theta, covariance, fitted, held, held_readings, held_left, tuple(run_theta))


def each_joint(
    evidence: Evidence, base: Trial, effect_terms: Sequence[Term], starts: Sequence[Floats]
) -> tuple[tuple[int, ...], Fit]:
    """Fit one effect to every joint on its own, all at once, on top of what ``base`` says; the runs used, and the fit.

    Args:
        effect_terms: (k,) the term of each joint.
        starts: each (k, p).
    """
    simulator, every = evidence.predictor.simulator, range(evidence.data.joints)
    runs = first_runs(evidence)
    with_gap = gap_of(evidence.scoring, base.held_square).significant
    limits = shift_limits(evidence.angles, Hypothesis((*base.hypothesis.terms, *effect_terms)))
    stacked = StackedAngles.of(evidence.angles, every, runs, limits)
    stacked = replace(stacked, block=np.where(with_gap, stacked.block, -1))

    def left(some: StackedAngles, *more: EffectSpec) -> Floats:
        wanted = [int(j) for j in some.columns if with_gap[j]]
        predicted = simulator.predict([*base.specs, *more], runs, rough=True, columns=wanted)
        return some.residual([p.reading_rad for p in predicted])

    def residual(theta: Floats, some: StackedAngles) -> Floats:
        return left(some, *specs_of(effect_terms, theta))

    problem = Problem(
        lambda theta: residual(theta, stacked),
        stacked.columns,
        stacked.block,
        stacked.allowed_square,
        *Box.of(effect_terms[0].open),
        idle=left(stacked),
        some=stacked.spread(residual),
    )
    keep = Hypothesis(tuple(effect_terms)).followed
    return runs, multi_start(problem, starts, keep, SOME_STEPS, covariance=False)


def specs_of(terms: Sequence[Term], rows: Floats) -> list[EffectSpec]:
    """Each term at its row of values."""
    return [spec for term, row in zip(terms, rows, strict=True) for spec in term.specs(row.tolist())]
