"""One explanation put to the test: fitted to all runs that may be fitted, and scored on gaits left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.context import Context
from snakebot.diagnosis.fit import Fit, Problem, multi_start
from snakebot.diagnosis.fitting import angle_columns, fit_runs, predicted_readings, residual_of
from snakebot.diagnosis.fold_fits import fold_thetas
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.hypothesis import Hypothesis, Term, bounds
from snakebot.effects.spec import EffectSpec

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FULL_STEPS = 30
ROUGH_STEPS = 6
DEAR_STEPS = 12  # where the whole body must be simulated, and a start is near


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

    def score(self, context: Context) -> float:
        """Mean held-out score over the deciding blocks."""
        return float(context.score(self.held_square)[context.selects].mean())

    def fitted_score(self, context: Context) -> float:
        """The same of the fit, nothing held out."""
        return float(context.score(self.fitted_square)[context.selects].mean())


def nominal_trial(context: Context) -> Trial:
    """The robot without any effect."""
    nothing = np.zeros(0)
    return _scored(
        context, Hypothesis(), nothing, np.zeros((0, 0)), (nothing,) * len(context.data.runs), cross=True
    )


def run_trial(
    context: Context,
    hypothesis: Hypothesis,
    starts: Sequence[Floats],
    *,
    cross: bool = True,
    keep: int = 1,
    rough: bool = False,
    last: bool = False,
) -> Trial:
    """Fit ``hypothesis`` from each of ``starts`` (p,), and cross-validate it unless ``cross`` is False.

    ``rough``: a first look, with loads of the nominal motion, no interval; where the whole body must be simulated
    even so, with two runs, and all terms but the last as they start. ``last``: so in any case.
    """
    runs, steps = context.free_runs, FULL_STEPS
    specs = hypothesis.specs(starts[0]) if len(starts) else ()
    if rough and context.simulator.dear(specs):
        runs, steps, last = context.telling_runs, ROUGH_STEPS, True
    elif not rough and context.simulator.coupled(specs):
        steps = DEAR_STEPS
    count = len(hypothesis.parameters)
    only = np.arange(count) >= count - len(hypothesis.terms[-1].open) if last else None
    theta, covariance, _ = fit_runs(
        context, hypothesis, starts, runs, steps, keep, covariance=not rough, rough=rough, only=only
    )
    fold_theta = [theta] * len(context.folds)
    if cross and theta.size:
        fold_theta = fold_thetas(context, hypothesis, theta)
    return _scored(context, hypothesis, theta, covariance, fold_theta, cross=cross, rough=rough)


def _scored(
    context: Context,
    hypothesis: Hypothesis,
    theta: Floats,
    covariance: Floats,
    fold_theta: Sequence[Floats],
    *,
    cross: bool,
    rough: bool = False,
) -> Trial:
    """The trial of a fit: each fold's runs are predicted, and shifted in time, by what its other runs say."""
    limit = context.shift_limits_s(hypothesis)
    blocks = context.angle_blocks
    coupled = context.simulator.coupled(hypothesis.specs(theta))

    def predicted(at: Floats, runs: Sequence[int]) -> list[Floats]:
        return predicted_readings(context, hypothesis.specs(at), runs, rough)

    every = range(len(context.data.runs))
    readings = predicted(theta, every)
    left = context.residuals(readings, context.shifts_s(readings, context.free_runs, limit))
    angles = blocks.mean_square(left)
    ground = context.ground_square(hypothesis.specs(theta))
    fitted = context.credited(np.concatenate([angles, ground]))
    run_theta = [theta] * len(every)
    if not cross or not context.folds:
        return Trial(hypothesis, theta, covariance, fitted, fitted, readings, left, tuple(run_theta))
    held = fitted.copy()
    held_readings, held_left = list(readings), list(left)
    for fold, own in zip(context.folds, fold_theta, strict=False):
        mixed = list(readings)
        if own is not theta:
            # Where a body must be simulated, the shifts in time of the fitted runs are those at ``theta``.
            seen = sorted((*fold.fit, *fold.score)) if limit.any() and not coupled else sorted(fold.score)
            for index, reading in zip(seen, predicted(own, seen), strict=True):
                mixed[index] = reading
        shifted = context.residuals(mixed, context.shifts_s(mixed, fold.fit, limit))
        for index in fold.score:
            run_theta[index] = own
            held_readings[index], held_left[index] = mixed[index], shifted[index]
        ground = np.zeros(0)
        if context.ground is not None:
            ground = np.square(context.ground_left(hypothesis.specs(own), context.free_runs))
        square = context.credited(np.concatenate([blocks.mean_square(shifted), ground]))
        mine = np.isin(context.block_run, fold.score)
        held[mine] = square[mine]
    return Trial(hypothesis, theta, covariance, fitted, held, held_readings, held_left, tuple(run_theta))


def each_joint(
    context: Context, base: Trial, effect_terms: Sequence[Term], starts: Sequence[Floats]
) -> tuple[tuple[int, ...], Fit]:
    """Fit one effect to every joint on its own, all at once, on top of what ``base`` says; the runs used, and the fit.

    Args:
        effect_terms: (k,) the term of each joint.
        starts: each (k, p).
    """
    joints = context.data.joints
    first = [*base.specs, *(term.spec(row) for term, row in zip(effect_terms, starts[0], strict=True))]
    dear = context.simulator.dear(first)
    runs = context.telling_runs if dear else context.free_runs
    columns = np.arange(joints, dtype=np.int64)
    wanted = np.flatnonzero(gap_of(context, base).significant)
    measured, use, block = angle_columns(context, columns, runs)
    absent = np.setdiff1d(columns, wanted)
    use[:, absent], block[:, absent] = False, -1
    lower, upper, log = bounds(effect_terms[0].open)
    limit = context.shift_limits_s(Hypothesis((*base.hypothesis.terms, *effect_terms)))

    def left(*more: EffectSpec) -> Floats:
        specs = [*base.specs, *more]
        predicted = context.simulator.predict(specs, runs, rough=True, columns=[int(j) for j in wanted])
        made = [p.reading_rad for p in predicted]
        return residual_of(context, made, runs, measured, use, block, limit)

    def residual(theta: Floats) -> Floats:
        return left(*(term.spec(row) for term, row in zip(effect_terms, theta, strict=True)))

    problem = Problem(residual, columns, block, context.scale.square, lower, upper, log, idle=left())
    return runs, multi_start(problem, starts, 1, ROUGH_STEPS if dear else 10, covariance=False)
