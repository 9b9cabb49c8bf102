"""One explanation put to the test: fitted to all runs that may be fitted, and scored on gaits left out.

Effects before the ground are fitted to the joint angles, effects of the body to the motion over ground; each
side sees the other's effects at their fitted values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.allowance import shifts_s, stacked_rates
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.fit import Fit, Problem, minimise, multi_start, refit
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.hypothesis import Hypothesis, Term, bounds
from snakebot.effects.spec import EffectSpec

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FOLD_STEPS = 8
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
        run_theta: parameters by which each run was predicted, one (p,) a run.
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


def predicted_readings(
    context: Context, specs: Sequence[EffectSpec], runs: Sequence[int], rough: bool = False
) -> list[Floats]:
    """Readings (N, k) of some runs; joints that no effect acts on are taken from the nominal prediction."""
    every = set(range(context.data.joints))
    acted = set().union(
        *(every if s.joints is None else {j - 1 for j in s.joints} for s in specs if s.effect.stage != "body")
    )
    made = context.simulator.predict(specs, runs, rough=rough, columns=sorted(acted))
    out = []
    for index, predicted in zip(runs, made, strict=True):
        reading = predicted.reading_rad
        gone = ~np.isfinite(reading)
        out.append(np.where(gone, context.nominal[index], reading) if gone.any() else reading)
    return out


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
    theta, covariance = _fit(
        context, hypothesis, starts, runs, steps, keep, covariance=not rough, rough=rough, last=last
    )
    fold_theta = [theta] * len(context.folds)
    if cross and theta.size:
        fold_theta = _fold_thetas(context, hypothesis, theta)
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
        specs = hypothesis.specs(at)
        if any(s.effect.stage != "body" for s in specs):
            return predicted_readings(context, specs, runs, rough)
        return [context.nominal[i] for i in runs]

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


def _fold_thetas(context: Context, hypothesis: Hypothesis, theta: Floats) -> list[Floats]:
    """Parameters (p,) fitted to each fold's runs, from ``theta``, which was fitted to all. Where the whole body must be
    simulated, those before the ground take one step from there: what a run more or less changes is little.
    """
    coupled = context.simulator.coupled(hypothesis.specs(theta))
    sides = (True,) if coupled else (True, False)
    found = [
        _fit(context, hypothesis, [theta], fold.fit, FOLD_STEPS, 1, covariance=False, sides=sides)[0]
        for fold in context.folds
    ]
    mine = ~_of_body(hypothesis)
    if not (coupled and mine.any()):
        return found

    lower, upper, log = bounds(hypothesis.parameters)
    box = (lower[mine], upper[mine], log[mine])
    whole = _specs_from(hypothesis, theta, mine)
    problem = _angle_problem(context, hypothesis, whole, context.free_runs, *box, rough=False)
    if problem is None:
        return found
    uses = [
        np.isin(context.block_run, fold.fit)[problem.block] & (problem.block >= 0) for fold in context.folds
    ]
    for full, part in zip(found, refit(problem, theta[mine], uses), strict=True):
        full[mine] = part
    return found


def _specs_from(
    hypothesis: Hypothesis, base: Floats, mine: NDArray[np.bool_]
) -> Callable[[Floats], tuple[EffectSpec, ...]]:
    """The effects as a function of those parameters that are ``mine``, the others as in ``base`` (p,)."""

    def specs(part: Floats) -> tuple[EffectSpec, ...]:
        full = base.copy()
        full[mine] = part
        return hypothesis.specs(full)

    return specs


def _of_body(hypothesis: Hypothesis) -> NDArray[np.bool_]:
    """(p,) which parameters are those of the body."""
    return np.array([term.stage == "body" for term in hypothesis.terms for _ in term.open], dtype=bool)


def _fit(
    context: Context,
    hypothesis: Hypothesis,
    starts: Sequence[Floats],
    runs: Sequence[int],
    steps: int,
    keep: int,
    covariance: bool = True,
    rough: bool = False,
    sides: Sequence[bool] = (True, False),
    last: bool = False,
) -> tuple[Floats, Floats]:
    """Parameters (p,) and their covariance, fitted to some runs.

    ``sides``: parameters of the body (True), all others (False). The body comes first: angles hardly know of it, but it
    knows of the load. ``last``: only the parameters of the last term.
    """
    count = len(hypothesis.parameters)
    best = np.array(starts[0], dtype=np.float64) if len(starts) else np.zeros(0)
    spread = np.full((count, count), np.nan)
    if count == 0:
        return best, spread
    lower, upper, log = bounds(hypothesis.parameters)
    body = _of_body(hypothesis)
    for side in sides:
        mine = body if side else ~body
        if last:
            mine = mine & (np.arange(count) >= count - len(hypothesis.terms[-1].open))
        if not mine.any():
            continue
        whole = _specs_from(hypothesis, best, mine)
        box = (lower[mine], upper[mine], log[mine])
        if side:
            problem = _ground_problem(context, whole, runs, *box)
        else:
            problem = _angle_problem(context, hypothesis, whole, runs, *box, rough=rough)
        if problem is None:
            continue
        begin = [np.asarray(start, dtype=np.float64)[mine][None] for start in starts]
        fit: Fit = (
            multi_start(problem, begin, keep, steps, covariance=covariance)
            if len(begin) > 1
            else minimise(problem, begin[0], steps, covariance=covariance)
        )
        best = best.copy()
        best[mine] = fit.theta[0]
        spread[np.ix_(mine, mine)] = fit.covariance[0]
    return best, spread


def _angle_problem(
    context: Context,
    hypothesis: Hypothesis,
    whole: object,
    runs: Sequence[int],
    lower: Floats,
    upper: Floats,
    log: NDArray[np.bool_],
    *,
    rough: bool,
) -> Problem | None:
    assert callable(whole)
    joints = [j - 1 for j in hypothesis.joints(context.data.joints)]
    columns = np.array(joints, dtype=np.int64)
    measured, use, block = angle_columns(context, columns, runs)
    if not use.any():
        return None

    limit = context.shift_limits_s(hypothesis)[columns]

    def residual(theta: Floats) -> Floats:
        predicted = context.simulator.predict(whole(theta[0]), runs, rough=rough, columns=joints)
        made = [p.reading_rad[:, columns] for p in predicted]
        return _left(context, made, runs, measured, use, block, limit)

    return Problem(
        residual, np.zeros(columns.size, dtype=np.int64), block, context.scale.square, lower, upper, log
    )


def _left(
    context: Context,
    readings: Sequence[Floats],
    runs: Sequence[int],
    measured: Floats,
    use: NDArray[np.bool_],
    block: Ints,
    limit_s: Floats,
) -> Floats:
    """Residual (N, k) of some joints in some runs, one below the other, with the shifts they are allowed."""
    residual = np.where(use, measured - np.concatenate(readings), 0.0)
    if limit_s.any():
        times = [context.data.runs[i].t_s for i in runs]
        rate = np.where(use, stacked_rates(readings, times), 0.0)
        residual -= rate * shifts_s(residual, rate, block, context.scale.square, limit_s)
    return residual


def angle_columns(
    context: Context, columns: Ints, runs: Sequence[int]
) -> tuple[Floats, NDArray[np.bool_], Ints]:
    """Measured angles, use and block numbers of some joints (columns) in some runs, one below the other."""
    measured = np.concatenate([context.data.runs[i].measured_rad[:, columns] for i in runs])
    block = np.concatenate([context.angle_blocks.of_sample[i][:, columns] for i in runs])
    return np.nan_to_num(measured), block >= 0, block


def _ground_problem(
    context: Context,
    whole: object,
    runs: Sequence[int],
    lower: Floats,
    upper: Floats,
    log: NDArray[np.bool_],
) -> Problem | None:
    assert callable(whole)
    ground = context.ground
    if ground is None:
        return None
    rows = np.isin(ground.run, list(runs))
    if not rows.any():
        return None
    block = np.where(rows, np.arange(ground.count), -1)[:, None]

    def residual(theta: Floats) -> Floats:
        left = context.ground_left(whole(theta[0]), runs, runs)
        return np.where(rows, np.nan_to_num(left), 0.0)[:, None]

    return Problem(
        residual, np.zeros(1, dtype=np.int64), block, context.ground_allowed_square, lower, upper, log
    )


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
        return _left(context, made, runs, measured, use, block, limit)

    def residual(theta: Floats) -> Floats:
        return left(*(term.spec(row) for term, row in zip(effect_terms, theta, strict=True)))

    problem = Problem(residual, columns, block, context.scale.square, lower, upper, log, idle=left())
    return runs, multi_start(problem, starts, 1, ROUGH_STEPS if dear else 10, covariance=False)
