"""Bounded fits of a Cauchy loss for many small problems at once: Levenberg-Marquardt, iteratively reweighted by block.

The problems (*units*: joints, or all joints together) share one simulation: joints do not disturb each other before the
ground, so perturbing a parameter of every joint at once costs one simulation, not one a joint.

Parameters are fitted on a scale of their own (logarithmic where they span decades), within bounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.fit.step import (
    A_THOUSANDTH,
    Problem,
    Quadratic,
    Weights,
    carry_slopes,
    damped_step,
    from_scale,
    information_on,
    jacobian_at,
    quadratic,
    sandwich,
    to_scale,
)
from snakebot.diagnosis.sizes import HALF, LITTLE, NEXT_TO_NOTHING, ROUNDING, SOME

# Iterations of a fit; of one to the whole body, of all joints together, near the end of another or for a first look;
# and of one of which each is costly, or that only prepares or mends another fit; chosen.
FULL_STEPS, SOME_STEPS, FEWEST_STEPS = 30, 10, 6
# Share that a fit neglects where no residual takes a body: of the cost, below which a fall ends the fit of a unit; of
# such a fall, below which a step promises too little to be tried; of an undamped step, below which a damped one has no
# length any more.
NEGLIGIBLE = LITTLE * A_THOUSANDTH
# Factor on the damping after a step that did not lower the cost, and its inverse after one that did; chosen.
MORE_DAMPING = 8.0
# Damping of the steps to a minimum near by that are tried, each if that before it did not lower the cost: in one
# dimension the whole step, two thirds, a fifth, a thirtieth of it, and so on.
DAMPED_MORE = (A_THOUSANDTH, *(HALF * MORE_DAMPING**k for k in range(SOME)))


@dataclass(frozen=True, eq=False)
class Fit:
    """Where the search ended.

    Attributes:
        theta: (U, p).
        cost: (U,) sum over blocks of samples x 1/2 log(1 + mean square / allowed).
        residual: (N, U') at ``theta``.
        covariance: (U, p, p) of ``theta``, robust to correlation within blocks.
        information: (U, p) on each parameter, where the search began, see ``information_on``.
        about: the problem about ``theta``, where that was worked out for the covariance.
    """

    theta: Floats
    cost: Floats
    residual: Floats
    covariance: Floats
    information: Floats
    evaluations: int
    about: Linearised | None = None


class Linearised(NamedTuple):
    """A problem about some parameters.

    Attributes:
        z: (U, p) the parameters on the fitted scale.
        residual: (N, U').
        jacobian: (p, N, U') its slopes on that scale.
        weight: (N, U') of each residual.
    """

    z: Floats
    residual: Floats
    jacobian: Floats
    weight: Floats


class Refit(NamedTuple):
    """A minimum near another: ``theta`` (U, p), and the ``information`` (U, p) of the counted residuals on each."""

    theta: Floats
    information: Floats


def minimise(problem: Problem, start: Floats, most_steps: int, *, covariance: bool = True) -> Fit:
    """Run from ``start`` (U, p) to the nearest minimum of each unit's cost."""
    units, p = start.shape
    z = np.clip(to_scale(start, problem), problem.low, problem.high)
    weights = Weights(problem)
    residual = problem.residual(from_scale(z, problem))
    cost, weight = weights.cost(residual)
    evaluations = 1
    damping, length = np.full(units, A_THOUSANDTH), np.ones(units)
    # Where a residual takes a body, a failure must not be repeated nearly unchanged. Elsewhere it may be: the damping
    # that ends that also turns the step, which leads further along a narrow valley.
    costly = problem.is_costly
    small_fall = A_THOUSANDTH if costly else NEGLIGIBLE
    active = np.ones(units, dtype=bool)
    jacobian, stale, whole = np.zeros((0, *residual.shape)), True, True
    guessed = np.zeros(units, dtype=bool)  # units whose slopes were carried along by a secant
    information = np.full((units, p), np.nan)
    models: dict[int, Quadratic] = {}
    for turn in range(most_steps):
        if stale:
            jacobian, stale, whole = jacobian_at(problem, z, residual, active), False, bool(active.all())
            guessed[:] = False
            models.clear()
            evaluations += p
        if turn == 0:
            information = information_on(problem, jacobian, weight)
        step, promise = np.zeros_like(z), np.zeros(units)
        for u in np.flatnonzero(active).tolist():
            if u not in models:
                models[u] = quadratic(problem, u, jacobian, residual, weight)
            step[u], promise[u] = damped_step(problem, models[u], damping[u], z[u])
        step *= length[:, None]
        part = length * (2 - length)  # of what a whole step promises
        step[part * promise < NEGLIGIBLE * small_fall * cost] = 0.0
        going = np.any(step != 0, axis=1)
        stale = bool(np.any(active & ~going & guessed))
        active &= going | guessed
        if stale:
            continue
        if not active.any():
            break
        trial = np.clip(z + step, problem.low, problem.high)
        trial_residual = problem.residual_of(active[problem.unit], from_scale(trial, problem))
        evaluations += 1
        trial_cost, trial_weight = weights.cost(trial_residual)
        fell = active & (trial_cost < cost)
        fall = np.where(fell, (cost - trial_cost) / part, promise)  # of a whole step
        if costly:
            share, shorter_fall = _shorter(part * promise, trial_cost - cost)
            length = np.where(fell, 1.0, length * share)
            if problem.secant:  # not repeated for that little
                fall = np.where(fell, fall, np.minimum(fall, shorter_fall))
        small = fall <= small_fall * np.maximum(cost, 1e-9)
        moved = fell[problem.unit]
        if problem.secant:
            carry_slopes(problem, jacobian, trial - z, np.where(moved, trial_residual - residual, 0.0), fell)
        for u in np.flatnonzero(fell).tolist():
            models.pop(u, None)
        z[fell] = trial[fell]
        residual = np.where(moved, trial_residual, residual)
        weight = np.where(moved, trial_weight, weight)
        cost = np.where(fell, trial_cost, cost)
        unsure = active & guessed & (small | ~fell)  # where slopes are guessed no end is believed
        damping = np.where(
            fell, np.maximum(damping / MORE_DAMPING, 1e-9), np.where(unsure, damping, damping * MORE_DAMPING)
        )
        active &= (~small & (damping * NEGLIGIBLE < 1)) | unsure
        if problem.secant:
            guessed |= fell
            stale = bool(unsure.any())
        else:
            stale |= bool(fell.any())
        if not active.any():
            break
    theta = from_scale(z, problem)
    spread = np.full((units, p, p), np.nan)
    about = None
    if covariance:
        if stale or not whole or guessed.any():
            jacobian = jacobian_at(problem, z, residual)
            evaluations += p
        about = Linearised(z, residual, jacobian, weight)
        for unit in range(units):
            spread[unit] = sandwich(problem, unit, jacobian, residual, weight)
        scale = np.where(problem.logarithmic, theta, 1.0)
        spread *= scale[:, :, None] * scale[:, None, :]
    return Fit(theta, cost, residual, spread, information, evaluations, about)


def approach(problem: Problem, start: Floats) -> Floats:
    """Where to begin instead of at ``start`` (1, p), of a problem that has another near it for all parameters.

    Joints that disturb each other are one unit: one of them that steps too far holds all others back. Under the torques
    of the motion so far they are apart. So each goes where it wants to go there, the motion is made anew, and so on as
    long as that leaves less.
    """
    if problem.near is None or (problem.near_for is not None and not problem.near_for.all()):
        return start
    best, weights = start, Weights(problem)
    left = problem.residual(best)
    least = float(weights.cost(left)[0].sum())
    for _ in range(FEWEST_STEPS):
        near = problem.about(best, left).apart()
        found = minimise(near, near.for_each(best[0]), FEWEST_STEPS, covariance=False)
        tried = problem.for_each(near.of_all(found.theta))
        left = problem.residual(tried)
        cost = float(weights.cost(left)[0].sum())
        if not cost < least:
            break
        small = least - cost <= A_THOUSANDTH * cost
        best, least = tried, cost
        if small:
            break
    return best


def _shorter(promise: Floats, rise: Floats) -> tuple[Floats, Floats]:
    """(U,) shares of steps to take next, which promised to lower the cost by ``promise`` and raised it by ``rise``; and
    (U,) what the best shares promise: where a parabola through what is known of the cost along the step has its
    minimum, but from a little to half of it, as usual (Nocedal and Wright 2006, section 3.5).
    """
    known = np.isfinite(promise) & np.isfinite(rise)
    slope = np.where(known, 2 * promise, 0.0)
    least = 0.5 * slope / np.maximum(slope + np.where(known, rise, 1.0), 1e-300)
    return np.clip(least, LITTLE, HALF), np.where(known, 0.5 * slope * np.minimum(least, 1.0), np.inf)


def multi_start(
    problem: Problem,
    starts: Sequence[Floats],
    keep: int,
    most_steps: int,
    *,
    covariance: bool = True,
) -> Fit:
    """Try every start (each (U, p)), search on from the best ``keep`` of each unit, and keep each unit's best end.

    The Cauchy cost is flat far from its minimum and has side valleys; plain least squares is neither and leads near the
    right one. So the searches come in two kinds: straight on, and by least squares first. Where more than one is kept
    side valleys are the rule: how good a start is tells little then, so that all are followed for some steps first.
    """
    if keep > 1:
        starts = [minimise(problem, start, FEWEST_STEPS, covariance=False).theta for start in starts]
    wide = replace(problem, allowed_square=wide_allowance(problem, problem.residual(starts[0])))
    stacked = np.stack(starts)
    units = np.arange(stacked.shape[1])
    residuals = [problem.residual(start) for start in starts]
    idle_starts = np.stack([_is_idle(problem, r, units.size) for r in residuals])
    best: Fit | None = None
    for first in (wide, problem):
        weights = Weights(first)
        cost = np.array([weights.cost(r)[0] for r in residuals])
        order = np.argsort(np.where(idle_starts, np.inf, cost), axis=0, kind="stable")
        for place in range(min(keep, len(starts))):
            begin = stacked[order[place], units].copy()
            if first is wide:
                begin = minimise(wide, begin, max(most_steps // 2, FEWEST_STEPS), covariance=False).theta
            fit = minimise(problem, begin, most_steps, covariance=False)
            best = fit if best is None else _better(best, fit, problem)
    assert best is not None
    return minimise(problem, best.theta, 1, covariance=True) if covariance else best


def refit(
    problem: Problem, theta: Floats, uses: Sequence[Bools], about: Linearised | None = None
) -> list[Refit]:
    """Minima near ``theta`` (U, p) of each unit's cost where only some residuals count, one for each of ``uses``
    (N, U'): one Gauss-Newton step each, from one simulation and one Jacobian that all share. A step that does not lower
    the cost is damped more; where a residual takes a body, as far as a cheaper one can say that, if there is one.
    ``about``: the problem about ``theta``, where it is known.
    """
    z, residual, jacobian, weight = about or linearised(problem, theta)
    judge, judged = problem.cheaper(from_scale(z, problem))
    if judge is not None:
        here = residual if judge is problem else judge.residual(from_scale(z, problem))
    out = []
    for use in uses:
        counted = np.where(use, weight, 0.0)
        models = [quadratic(problem, u, jacobian, residual, counted) for u in range(z.shape[0])]
        there, higher = z.copy(), np.ones(z.shape[0], dtype=bool)
        if judge is not None:
            weights = Weights(replace(problem, block=np.where(use, problem.block, -1)))
            least, _ = weights.cost(here)
        for damping in DAMPED_MORE:
            for u in np.flatnonzero(higher).tolist():
                step, _ = damped_step(problem, models[u], damping, z[u])
                there[u] = np.clip(z[u] + step, problem.low, problem.high)
            if judge is None:
                break
            tried = from_scale(np.where(judged, there, z), problem)
            left = judge.residual_of(higher[problem.unit], tried)
            higher &= weights.cost(left)[0] > least
            there[higher] = z[higher]
            if not higher.any():
                break
        out.append(Refit(from_scale(there, problem), information_on(problem, jacobian, counted)))
    return out


def linearised(problem: Problem, theta: Floats) -> Linearised:
    """A problem about ``theta`` (U, p)."""
    z = np.clip(to_scale(theta, problem), problem.low, problem.high)
    residual = problem.residual(from_scale(z, problem))
    _, weight = Weights(problem).cost(residual)
    return Linearised(z, residual, jacobian_at(problem, z, residual), weight)


def _is_idle(problem: Problem, residual: Floats, units: int) -> Bools:
    """(U,) whether what is fitted does nothing there."""
    if problem.idle is None:
        return np.zeros(units, dtype=bool)
    moved = np.zeros(units)
    np.maximum.at(moved, problem.unit, np.abs(residual - problem.idle).max(axis=0, initial=0.0))
    return moved < ROUNDING


def wide_allowance(problem: Problem, residual: Floats) -> Floats:
    """An allowed spread (B,) so wide beside ``residual`` (N, U') that the cost is a plain sum of squares, of one size
    for each unit.
    """
    out = problem.allowed_square.copy()
    for unit in np.unique(problem.unit):
        columns = problem.unit == unit
        used = problem.block[:, columns] >= 0
        if used.any():
            names = np.unique(problem.block[:, columns][used])
            size = float(np.mean(np.square(residual[:, columns][used])))
            out[names] = np.maximum(out[names], size / NEXT_TO_NOTHING)
    return out


def _better(a: Fit, b: Fit, problem: Problem) -> Fit:
    wins = b.cost < a.cost
    return Fit(
        np.where(wins[:, None], b.theta, a.theta),
        np.where(wins, b.cost, a.cost),
        np.where(wins[problem.unit], b.residual, a.residual),
        np.where(wins[:, None, None], b.covariance, a.covariance),
        np.where(wins[:, None], b.information, a.information),
        a.evaluations + b.evaluations,
    )
