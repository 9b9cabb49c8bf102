"""One explanation put to the test: fitted to all runs that may be fitted, and scored on gaits left out.

Effects before the ground are fitted to the joint angles, effects of the body to the motion over ground; each
side sees the other's effects at their fitted values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.context import Context
from snakebot.diagnosis.fit import Fit, Problem, minimise, multi_start
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.hypothesis import Hypothesis, Term, bounds
from snakebot.effects.spec import EffectSpec

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FOLD_STEPS = 8
FULL_STEPS = 30
ROUGH_STEPS = 6


@dataclass(frozen=True, eq=False)
class Trial:
    """An explanation with its fit.

    Attributes:
        theta: (p,) fitted to all free runs, in the order of the terms.
        covariance: (p, p); nan where nothing was fitted.
        fitted_square: (B,) mean squares of the blocks at ``theta``.
        held_square: (B,) the same, each run predicted from parameters that it had no part in.
        readings: held-out predictions (N, k) a run.
        run_theta: parameters by which each run was predicted, one (p,) a run.
    """

    hypothesis: Hypothesis
    theta: Floats
    covariance: Floats
    fitted_square: Floats
    held_square: Floats
    readings: list[Floats]
    run_theta: tuple[Floats, ...]

    @property
    def specs(self) -> tuple[EffectSpec, ...]:
        return self.hypothesis.specs(self.theta)

    def score(self, context: Context) -> float:
        """Mean held-out score over the deciding blocks."""
        return float(context.score(self.held_square)[context.selects].mean())


def squares(
    context: Context, specs: Sequence[EffectSpec], *, rough: bool = False
) -> tuple[Floats, list[Floats]]:
    """(B,) mean squares of all blocks under some effects, and the readings."""
    angle_specs = [s for s in specs if s.effect.stage != "body"]
    readings = (
        [p.reading_rad for p in context.simulator.predict(specs, rough=rough)]
        if angle_specs
        else context.nominal
    )
    angles = context.angle_blocks.mean_square(context.residuals(readings))
    return context.credited(np.concatenate([angles, context.ground_square(specs)])), readings


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
    square, readings = squares(context, ())
    nothing = np.zeros(0)
    return Trial(
        Hypothesis(), nothing, np.zeros((0, 0)), square, square, readings, (nothing,) * len(context.data.runs)
    )


def run_trial(
    context: Context,
    hypothesis: Hypothesis,
    starts: Sequence[Floats],
    *,
    cross: bool = True,
    keep: int = 1,
    rough: bool = False,
) -> Trial:
    """Fit ``hypothesis`` from each of ``starts`` (p,), and cross-validate it unless ``cross`` is False.

    ``rough``: a first look, with loads of the nominal motion, no interval.
    """
    runs, steps = context.free_runs, FULL_STEPS
    if rough and len(starts) and context.simulator.dear(hypothesis.specs(starts[0])):
        runs, steps = context.telling_runs, ROUGH_STEPS
    theta, covariance = _fit(
        context, hypothesis, starts, runs, steps, keep, covariance=not rough, rough=rough
    )
    specs = hypothesis.specs(theta)
    fitted, readings = squares(context, specs, rough=rough)
    if not cross or not context.folds or theta.size == 0:
        everywhere = (theta,) * len(context.data.runs)
        return Trial(hypothesis, theta, covariance, fitted, fitted, readings, everywhere)
    run_theta = [theta] * len(context.data.runs)
    held = fitted.copy()
    readings = list(readings)
    block_run = context.block_run
    for fold in context.folds:
        fold_theta, _ = _fit(context, hypothesis, [theta], fold.fit, FOLD_STEPS, 1, covariance=False)
        fold_specs = hypothesis.specs(fold_theta)
        score = list(fold.score)
        for index in score:
            run_theta[index] = fold_theta
        if any(s.effect.stage != "body" for s in fold_specs):
            for index, reading in zip(score, predicted_readings(context, fold_specs, score), strict=True):
                readings[index] = reading
        residual = [
            np.where(run.use, run.measured_rad - reading, 0.0)
            for run, reading in zip(context.data.runs, readings, strict=True)
        ]
        angles = context.angle_blocks.mean_square(residual)
        ground = np.zeros(0)
        if context.ground is not None:
            ground = np.square(context.ground_features(fold_specs, score) - context.ground.value)
        square = context.credited(np.concatenate([angles, ground]))
        mine = np.isin(block_run, score)
        held[mine] = square[mine]
    return Trial(hypothesis, theta, covariance, fitted, held, readings, tuple(run_theta))


def _fit(
    context: Context,
    hypothesis: Hypothesis,
    starts: Sequence[Floats],
    runs: Sequence[int],
    steps: int,
    keep: int,
    covariance: bool = True,
    rough: bool = False,
) -> tuple[Floats, Floats]:
    """Parameters (p,) and their covariance, fitted to some runs."""
    count = len(hypothesis.parameters)
    best = np.array(starts[0], dtype=np.float64) if len(starts) else np.zeros(0)
    spread = np.full((count, count), np.nan)
    if count == 0:
        return best, spread
    lower, upper, log = bounds(hypothesis.parameters)
    body = np.array([term.stage == "body" for term in hypothesis.terms for _ in term.open], dtype=bool)
    for side in (True, False):  # body first: angles hardly know of it, but it knows of the load
        mine = body if side else ~body
        if not mine.any():
            continue

        def whole(
            part: Floats, mine: NDArray[np.bool_] = mine, base: Floats = best
        ) -> tuple[EffectSpec, ...]:
            full = base.copy()
            full[mine] = part
            return hypothesis.specs(full)

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

    def residual(theta: Floats) -> Floats:
        predicted = context.simulator.predict(whole(theta[0]), runs, rough=rough, columns=joints)
        reading = np.concatenate([p.reading_rad[:, columns] for p in predicted])
        return np.where(use, measured - reading, 0.0)

    return Problem(
        residual, np.zeros(columns.size, dtype=np.int64), block, context.scale.square, lower, upper, log
    )


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
        found = context.ground_features(whole(theta[0]), runs)
        return np.where(rows, ground.value - np.nan_to_num(found), 0.0)[:, None]

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

    def residual(theta: Floats) -> Floats:
        specs = [*base.specs, *(term.spec(row) for term, row in zip(effect_terms, theta, strict=True))]
        predicted = context.simulator.predict(specs, runs, rough=True, columns=[int(j) for j in wanted])
        reading = np.concatenate([p.reading_rad for p in predicted])
        return np.where(use, measured - reading, 0.0)

    problem = Problem(residual, columns, block, context.scale.square, lower, upper, log)
    return runs, multi_start(problem, starts, 1, ROUGH_STEPS if dear else 10, covariance=False)
