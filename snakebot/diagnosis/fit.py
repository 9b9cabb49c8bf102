"""Bounded least squares for many small problems at once: Levenberg-Marquardt with a fresh weight for every block.

The problems (*units*: joints, or all joints together) share one simulation: joints do not disturb each other before the
ground, so perturbing a parameter of every joint at once costs one simulation, not one a joint.

Parameters are fitted on a scale of their own (logarithmic where they span decades), within bounds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STEP = 1e-3  # of finite differences, on the fitted scale
ENOUGH = 1e-4  # relative fall of the cost below which a unit is done
WORTH_A_LOOK = 1e-4  # of that: a step that promises less is not tried
LEAST_CURVATURE = 1e-12
SLEEP_RAD = 1e-7


@dataclass(frozen=True, eq=False)
class Problem:
    """What is fitted.

    Attributes:
        residual: maps parameters (U, p) to residuals, one matrix (N, U') whose columns belong to units ``unit``.
        unit: (U',) unit of every column.
        block: (N, U') number of the block of each residual, -1 where unused; a block belongs to one column.
        allowed_square: (B,) allowed spread of each block.
        lower, upper: (p,) bounds.
        logarithmic: (p,) fitted on a logarithmic scale.
        idle: residual where what is fitted does nothing: a search that starts there stays there.
    """

    residual: Callable[[Floats], Floats]
    unit: Ints
    block: Ints
    allowed_square: Floats
    lower: Floats
    upper: Floats
    logarithmic: NDArray[np.bool_]
    idle: Floats | None = None


@dataclass(frozen=True, eq=False)
class Fit:
    """Where the search ended.

    Attributes:
        theta: (U, p).
        cost: (U,) sum over blocks of samples x 1/2 log(1 + mean square / allowed).
        residual: (N, U') at ``theta``.
        covariance: (U, p, p) of ``theta``, robust to correlation within blocks.
        told: (U, p) what the residuals said of each parameter where the search began, see ``_told``.
    """

    theta: Floats
    cost: Floats
    residual: Floats
    covariance: Floats
    told: Floats
    evaluations: int


class Refit(NamedTuple):
    """A minimum near another: ``theta`` (p,), and what the residuals that count ``told`` (p,) of each parameter."""

    theta: Floats
    told: Floats


class _Weights:
    """Costs and weights of blocks."""

    def __init__(self, problem: Problem) -> None:
        self.block = problem.block
        self.used = problem.block >= 0
        self.flat = problem.block[self.used]
        self.allowed = problem.allowed_square
        self.size = np.bincount(self.flat, minlength=self.allowed.size).astype(np.float64)
        columns = np.broadcast_to(problem.unit, problem.block.shape)[self.used]
        self.unit = np.zeros(self.allowed.size, dtype=np.int64)
        self.unit[self.flat] = columns
        self.units = int(problem.unit.max()) + 1 if problem.unit.size else 0

    def cost(self, residual: Floats) -> tuple[Floats, Floats]:
        """Cost of each unit, and the weight of every residual."""
        total = np.bincount(self.flat, weights=np.square(residual[self.used]), minlength=self.allowed.size)
        square = total / np.maximum(self.size, 1.0)
        square = np.where(np.isfinite(square), square, 1e30)
        per_block = 0.5 * self.size * np.log1p(square / self.allowed)
        weight = np.zeros(residual.shape)
        weight[self.used] = (1.0 / (self.allowed + square))[self.flat]
        totals = np.zeros(self.units)
        np.add.at(totals, self.unit, per_block)
        return totals, np.asarray(weight)


def to_scale(theta: Floats, problem: Problem) -> Floats:
    return np.where(problem.logarithmic, np.log(np.maximum(theta, 1e-300)), theta)


def from_scale(z: Floats, problem: Problem) -> Floats:
    return np.where(problem.logarithmic, np.exp(np.where(problem.logarithmic, z, 0.0)), z)


def minimise(problem: Problem, start: Floats, most_steps: int = 25, *, covariance: bool = True) -> Fit:
    """Run from ``start`` (U, p) to the nearest minimum of each unit's cost."""
    units, p = start.shape
    low, high = to_scale(problem.lower, problem), to_scale(problem.upper, problem)
    span = high - low
    z = np.clip(to_scale(start, problem), low, high)
    weights = _Weights(problem)
    residual = problem.residual(from_scale(z, problem))
    cost, weight = weights.cost(residual)
    evaluations = 1
    damping = np.full(units, 1e-3)
    active = np.ones(units, dtype=bool)
    jacobian, stale = np.zeros((0, *residual.shape)), True
    told = np.full((units, p), np.nan)
    for turn in range(most_steps):
        if stale:
            jacobian, stale = _jacobian(problem, z, residual, span), False
            evaluations += p
        if turn == 0:
            told = _told(problem, jacobian, weight)
        step, promise = np.zeros_like(z), np.zeros(units)
        for u in np.flatnonzero(active):
            columns = problem.unit == u
            step[u], promise[u] = _step(
                jacobian[:, :, columns], residual[:, columns], weight[:, columns], damping[u], z[u], low, high
            )
        step[promise < WORTH_A_LOOK * ENOUGH * cost] = 0.0
        active &= np.any(step != 0, axis=1)
        if not active.any():
            break
        trial = np.clip(z + step, low, high)
        trial_residual = problem.residual(from_scale(trial, problem))
        evaluations += 1
        trial_cost, trial_weight = weights.cost(trial_residual)
        fell = active & (trial_cost < cost)
        small = np.where(fell, cost - trial_cost, promise) <= ENOUGH * np.maximum(cost, 1e-9)
        moved = fell[problem.unit]
        z[fell] = trial[fell]
        residual = np.where(moved, trial_residual, residual)
        weight = np.where(moved, trial_weight, weight)
        cost = np.where(fell, trial_cost, cost)
        damping = np.where(fell, np.maximum(damping * 0.2, 1e-9), damping * 8.0)
        active &= ~small & (damping < 1e5)
        stale |= bool(fell.any())
        if not active.any():
            break
    theta = from_scale(z, problem)
    spread = np.full((units, p, p), np.nan)
    if covariance:
        if stale:
            jacobian = _jacobian(problem, z, residual, span)
            evaluations += p
        for unit in range(units):
            columns = problem.unit == unit
            spread[unit] = _covariance(
                jacobian[:, :, columns], residual[:, columns], weight[:, columns], problem.block[:, columns]
            )
        scale = np.where(problem.logarithmic, theta, 1.0)
        spread *= scale[:, :, None] * scale[:, None, :]
    return Fit(theta, cost, residual, spread, told, evaluations)


def multi_start(
    problem: Problem,
    starts: Sequence[Floats],
    keep: int = 2,
    most_steps: int = 25,
    *,
    covariance: bool = True,
) -> Fit:
    """Try every start (each (U, p)), search on from the best ``keep`` of each unit, and keep each unit's best end.

    The cost is flat far from its minimum and has side valleys; plain least squares is not and leads near the right one.
    So the searches come in two kinds: straight on, and by least squares first.
    """
    blunt = replace(problem, allowed_square=_blunt(problem, starts[0]))
    stacked = np.stack(starts)
    units = np.arange(stacked.shape[1])
    residuals = [problem.residual(start) for start in starts]
    asleep = np.stack([_asleep(problem, r, units.size) for r in residuals])
    best: Fit | None = None
    for first in (blunt, problem):
        weights = _Weights(first)
        cost = np.array([weights.cost(r)[0] for r in residuals])
        order = np.argsort(np.where(asleep, np.inf, cost), axis=0, kind="stable")
        for place in range(min(keep, len(starts))):
            begin = stacked[order[place], units].copy()
            if first is blunt:
                begin = minimise(blunt, begin, max(most_steps // 2, 5), covariance=False).theta
            fit = minimise(problem, begin, most_steps, covariance=False)
            best = fit if best is None else _better(best, fit, problem)
    assert best is not None
    return minimise(problem, best.theta, 1, covariance=True) if covariance else best


def refit(problem: Problem, theta: Floats, uses: Sequence[NDArray[np.bool_]]) -> list[Refit]:
    """Minima near ``theta`` (p,) of one unit's cost where only some residuals count, one for each of ``uses``
    (N, U'): one Gauss-Newton step each, from one simulation and one Jacobian that all share.
    """
    low, high = to_scale(problem.lower, problem), to_scale(problem.upper, problem)
    z = np.clip(to_scale(theta[None], problem), low, high)
    residual = problem.residual(from_scale(z, problem))
    _, weight = _Weights(problem).cost(residual)
    jacobian = _jacobian(problem, z, residual, high - low)
    out = []
    for use in uses:
        counted = np.where(use, weight, 0.0)
        step, _ = _step(jacobian, residual, counted, 1e-3, z[0], low, high)
        there = from_scale(np.clip(z[0] + step, low, high), problem)
        out.append(Refit(there, _told(problem, jacobian, counted)[0]))
    return out


def _told(problem: Problem, jacobian: Floats, weight: Floats) -> Floats:
    """(U, p) curvature of the cost along each parameter on the fitted scale, every block counted as one sample.

    One over the variance that a parameter would have left, roughly: what it does not move at all tells nothing of it.
    """
    size = np.bincount(problem.block[problem.block >= 0], minlength=problem.allowed_square.size)
    each = weight / np.maximum(size, 1)[np.maximum(problem.block, 0)]
    out = np.zeros((int(problem.unit.max()) + 1 if problem.unit.size else 0, jacobian.shape[0]))
    np.add.at(out, problem.unit, np.einsum("inu,nu->ui", np.square(jacobian), each))
    return out


def _asleep(problem: Problem, residual: Floats, units: int) -> NDArray[np.bool_]:
    """(U,) whether what is fitted does nothing there."""
    if problem.idle is None:
        return np.zeros(units, dtype=bool)
    moved = np.zeros(units)
    np.maximum.at(moved, problem.unit, np.abs(residual - problem.idle).max(axis=0, initial=0.0))
    return moved < SLEEP_RAD


def _blunt(problem: Problem, start: Floats) -> Floats:
    """An allowed spread so wide that the cost is a plain sum of squares, of one size for each unit."""
    residual = problem.residual(start)
    out = problem.allowed_square.copy()
    for unit in np.unique(problem.unit):
        columns = problem.unit == unit
        used = problem.block[:, columns] >= 0
        if used.any():
            names = np.unique(problem.block[:, columns][used])
            size = float(np.mean(np.square(residual[:, columns][used])))
            out[names] = np.maximum(out[names], 30 * size)
    return out


def _better(a: Fit, b: Fit, problem: Problem) -> Fit:
    wins = b.cost < a.cost
    return Fit(
        np.where(wins[:, None], b.theta, a.theta),
        np.where(wins, b.cost, a.cost),
        np.where(wins[problem.unit], b.residual, a.residual),
        np.where(wins[:, None, None], b.covariance, a.covariance),
        np.where(wins[:, None], b.told, a.told),
        a.evaluations + b.evaluations,
    )


def _jacobian(problem: Problem, z: Floats, residual: Floats, span: Floats) -> Floats:
    """(p, N, U') forward differences on the fitted scale, away from a bound."""
    low, high = to_scale(problem.lower, problem), to_scale(problem.upper, problem)
    out = np.empty((z.shape[1], *residual.shape))
    for i in range(z.shape[1]):
        step = np.where(problem.logarithmic[i], 5 * STEP, STEP * span[i])
        sign = np.where(z[:, i] + step > high[i], -1.0, 1.0)
        moved = z.copy()
        moved[:, i] += sign * step
        moved[:, i] = np.clip(moved[:, i], low[i], high[i])
        change = (moved[:, i] - z[:, i])[problem.unit]
        difference = problem.residual(from_scale(moved, problem)) - residual
        out[i] = np.divide(difference, change, out=np.zeros_like(difference), where=change != 0)
    return out


def _step(
    jacobian: Floats, residual: Floats, weight: Floats, damping: float, z: Floats, low: Floats, high: Floats
) -> tuple[Floats, float]:
    """A damped Gauss-Newton step (p,) within half the box, and by how much the cost should fall, inf if unknown."""
    p = jacobian.shape[0]
    weighted = jacobian * weight
    hessian = np.einsum("inu,jnu->ij", weighted, jacobian)
    gradient = np.einsum("inu,nu->i", weighted, residual)
    # a parameter at its bound that wants to go further stays there
    free = ~(((z <= low) & (gradient > 0)) | ((z >= high) & (gradient < 0)))
    free &= np.diag(hessian) > LEAST_CURVATURE
    step = np.zeros(p)
    if free.any():
        h = hessian[np.ix_(free, free)]
        h = h + damping * np.diag(np.diag(h))
        try:
            step[free] = -np.linalg.solve(h, gradient[free])
        except np.linalg.LinAlgError:
            step[free] = -gradient[free] / np.diag(h)
    short = np.clip(step, -0.5 * (high - low), 0.5 * (high - low))
    if np.any(short != step):  # in another direction, for which the parabola is no guide
        return short, math.inf
    return step, float(-(gradient @ step) - 0.5 * step @ hessian @ step)


def _covariance(jacobian: Floats, residual: Floats, weight: Floats, block: Ints) -> Floats:
    """Sandwich estimate: residuals within a block may be as correlated as they like."""
    p = jacobian.shape[0]
    used = block >= 0
    hessian = np.einsum("inu,jnu->ij", jacobian * weight, jacobian)
    flat = block[used]
    names, index = np.unique(flat, return_inverse=True)
    scores = np.stack(
        [
            np.bincount(index, weights=(jacobian[i] * weight * residual)[used], minlength=names.size)
            for i in range(p)
        ]
    )
    usable = np.diag(hessian) > LEAST_CURVATURE
    out = np.full((p, p), np.inf)
    if usable.any() and names.size > p:
        inverse = np.linalg.pinv(hessian[np.ix_(usable, usable)], hermitian=True)
        # scores of neighbouring blocks go together: add lag one (Newey-West)
        inner = np.asarray(scores[usable])
        meat = np.asarray(inner @ inner.T, dtype=np.float64)
        lag = inner[:, 1:] @ inner[:, :-1].T
        meat = meat + 0.5 * (lag + lag.T)
        meat *= names.size / (names.size - p)
        out[np.ix_(usable, usable)] = inverse @ meat @ inverse
    return out
