"""One explanation fitted to some runs: parameters of the body to the motion over ground, all others to the angles.

Each side sees the other's effects at their fitted values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.allowance import shifts_s, stacked_rates
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.fit import Fit, Problem, minimise, multi_start
from snakebot.diagnosis.hypothesis import Hypothesis, bounds
from snakebot.effects.spec import EffectSpec

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def predicted_readings(
    context: Context, specs: Sequence[EffectSpec], runs: Sequence[int], rough: bool = False
) -> list[Floats]:
    """Readings (N, k) of some runs; joints that no effect acts on are taken from the nominal prediction."""
    if all(s.effect.stage == "body" for s in specs):
        return [context.nominal[i] for i in runs]
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


def specs_from(
    hypothesis: Hypothesis, base: Floats, mine: NDArray[np.bool_]
) -> Callable[[Floats], tuple[EffectSpec, ...]]:
    """The effects as a function of those parameters that are ``mine``, the others as in ``base`` (p,)."""

    def specs(part: Floats) -> tuple[EffectSpec, ...]:
        full = base.copy()
        full[mine] = part
        return hypothesis.specs(full)

    return specs


def of_body(hypothesis: Hypothesis) -> NDArray[np.bool_]:
    """(p,) which parameters are those of the body."""
    return np.array([term.stage == "body" for term in hypothesis.terms for _ in term.open], dtype=bool)


class Fitted(NamedTuple):
    """Parameters ``theta`` (p,), their ``covariance`` (p, p), nan where nothing was fitted, and what the runs ``told``
    (p,) of each: see ``fit.Fit``; zero where none of the runs shows its side, nan where it was not fitted.
    """

    theta: Floats
    covariance: Floats
    told: Floats


def fit_runs(
    context: Context,
    hypothesis: Hypothesis,
    starts: Sequence[Floats],
    runs: Sequence[int],
    steps: int,
    keep: int = 1,
    *,
    covariance: bool = False,
    rough: bool = False,
    sides: Sequence[bool] = (True, False),
    only: Bools | None = None,
) -> Fitted:
    """Fit an explanation to some runs from each of ``starts`` (p,).

    ``sides``: parameters of the body (True), all others (False). The body comes first: angles hardly know of it, but it
    knows of the load. ``only``: (p,) the parameters that are fitted, all if None.
    """
    count = len(hypothesis.parameters)
    best = np.array(starts[0], dtype=np.float64) if len(starts) else np.zeros(0)
    spread, told = np.full((count, count), np.nan), np.full(count, np.nan)
    lower, upper, log = bounds(hypothesis.parameters)
    body = of_body(hypothesis)
    for side in sides:
        mine = body if side else ~body
        if only is not None:
            mine = mine & only
        if not mine.any():
            continue
        whole = specs_from(hypothesis, best, mine)
        box = (lower[mine], upper[mine], log[mine])
        if side:
            problem = ground_problem(context, whole, runs, *box)
        else:
            problem = angle_problem(context, hypothesis, whole, runs, *box, rough=rough)
        if problem is None:
            told[mine] = 0.0
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
        told[mine] = fit.told[0]
    return Fitted(best, spread, told)


def angle_problem(
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
        return residual_of(context, made, runs, measured, use, block, limit)

    return Problem(
        residual, np.zeros(columns.size, dtype=np.int64), block, context.scale.square, lower, upper, log
    )


def residual_of(
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


def ground_problem(
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
