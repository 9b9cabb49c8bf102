"""The algebra of one step of a fit: weights of blocks, slopes of residuals, a damped Gauss-Newton step, a covariance.

Parameters are fitted on a scale of their own (logarithmic where they span decades), within bounds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.sizes import NO_PERCENT, ROUNDING

# Of a parameter's range, that a finite difference takes; of the curvature, that damps a first step; of the cost, that
# ends a fit where a residual takes a body: a third of a standard error of a parameter, for samples that are alike for a
# second, and a thirtieth of the score that counts as none; chosen.
A_THOUSANDTH = 1e-3


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
        stride: (p,) change over which a slope is taken where a small one shows nothing at all; 0 or None: none.
        idle: residual where what is fitted does nothing: a search that starts there stays there.
        touches: (p, U') which columns a parameter can change at all; None: any of its unit. Parameters that share no
            column are perturbed together (Curtis, Powell and Reid 1974).
        some: the same as ``residual`` of the columns (U',) asked for; the others are zero. None: all are made, whatever
            is asked for.
        secant: one residual costs much: slopes are carried along from step to step, and worked out anew where a step
            fails or the search would end.
        near: makes of parameters (U, p) a problem that has about the same slopes there at less cost, for those of the
            parameters that are ``near_for`` (p,); None: there is none.
    """

    residual: Callable[[Floats], Floats]
    unit: Ints
    block: Ints
    allowed_square: Floats
    lower: Floats
    upper: Floats
    logarithmic: Bools
    stride: Floats | None = None
    idle: Floats | None = None
    touches: Bools | None = None
    some: Callable[[Floats, Bools], Floats] | None = None
    secant: bool = False
    near: Callable[[Floats], Problem] | None = None
    near_for: Bools | None = None

    @property
    def is_costly(self) -> bool:
        """Whether one residual takes a body."""
        return self.secant or self.near is not None

    def cheaper(self, theta: Floats) -> tuple[Problem | None, Bools]:
        """A problem whose residual takes no body and is about the same near ``theta`` (U, p), None where there is none;
        and for which parameters (p,) that holds.
        """
        every = np.ones(theta.shape[1], dtype=bool)
        if not self.is_costly:
            return self, every
        if self.near is None:
            return None, ~every
        return self.near(theta), every if self.near_for is None else self.near_for

    def about(self, theta: Floats, there: Floats | None = None) -> Problem:
        """The ``near`` problem at ``theta`` (U, p), which is to leave there what this one leaves: ``there`` (N, U'),
        where that is known.

        Raises:
            TypeError: there is none.
        """
        if self.near is None:
            raise TypeError("a problem without another near it")
        if there is None:  # first: the other problem takes its torques from this motion
            there = self.residual(theta)
        near = self.near(theta)
        off = there - near.residual(theta)
        return replace(
            near,
            residual=lambda theta: near.residual(theta) + off,
            some=lambda theta, columns: near.residual_of(columns, theta) + np.where(columns, off, 0.0),
        )

    @cached_property
    def low(self) -> Floats:
        """(p,) lower bounds on the fitted scale."""
        return to_scale(self.lower, self)

    @cached_property
    def high(self) -> Floats:
        """(p,) upper bounds on the fitted scale."""
        return to_scale(self.upper, self)

    def residual_of(self, columns: Bools, theta: Floats) -> Floats:
        """(N, U') residuals of some ``columns`` (U',) at ``theta`` (U, p); whatever is cheapest in the others."""
        return self.residual(theta) if self.some is None or columns.all() else self.some(theta, columns)

    def apart(self) -> Problem:
        """The same problem of one unit where columns that share no parameter are units of their own."""
        if self.touches is None:
            return self
        units, some = replace(self, unit=sharing(self.touches)), self.some

        def together(theta: Floats) -> Floats:
            return self.for_each(units.of_all(theta))

        return replace(
            units,
            residual=lambda theta: self.residual(together(theta)),
            some=None if some is None else lambda theta, columns: some(together(theta), columns),
        )

    def of_all(self, rows: Floats) -> Floats:
        """(p,) of (U, p), or (p, p) of (U, p, p): each parameter as the unit has it whose columns it touches.

        Parameters of different units have nothing to do with each other.
        """
        count = rows.shape[-1]
        if self.touches is None:
            return np.asarray(rows[0])
        owner = (
            self.unit[np.argmax(self.touches, axis=1)] if self.unit.size else np.zeros(count, dtype=np.int64)
        )
        if rows.ndim == 2:
            return np.asarray(rows[owner, np.arange(count)])
        return np.where(owner[:, None] == owner, rows[owner, np.arange(count)], 0.0)

    def for_each(self, row: Floats) -> Floats:
        """(U, p) of (p,): the same for every unit."""
        return np.tile(row, (int(self.unit.max()) + 1, 1))


def sharing(touches: Bools) -> Ints:
    """(c,) unit of each column: columns that a parameter touches both, directly or by way of others, are of one unit.

    ``touches``: (p, c).
    """
    unit = np.arange(touches.shape[1])
    for columns in touches:
        together = np.unique(unit[columns])
        unit[np.isin(unit, together[1:])] = together[0] if together.size else 0
    return np.asarray(np.unique(unit, return_inverse=True)[1])


class Weights:
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


class OnScale(Protocol):
    """What says which of its parameters are fitted on a logarithmic scale: a problem, or bounds."""

    @property
    def logarithmic(self) -> Bools: ...


def to_scale(theta: Floats, of: OnScale) -> Floats:
    return np.where(of.logarithmic, np.log(np.maximum(theta, 1e-300)), theta)


def from_scale(z: Floats, of: OnScale) -> Floats:
    return np.where(of.logarithmic, np.exp(np.where(of.logarithmic, z, 0.0)), z)


def jacobian_at(problem: Problem, z: Floats, residual: Floats, active: Bools | None = None) -> Floats:
    """(p, N, U') forward differences on the fitted scale, away from a bound; of ``active`` units (U,), all if None."""
    if problem.near is None:
        return _differences(problem, z, residual, active)
    theta = from_scale(z, problem)
    near = problem.near(theta)
    out = _differences(near, z, near.residual(theta), active, problem.near_for)
    if problem.near_for is not None and not problem.near_for.all():
        out += _differences(problem, z, residual, active, ~problem.near_for)
    return out


def _differences(
    problem: Problem, z: Floats, residual: Floats, active: Bools | None, only: Bools | None = None
) -> Floats:
    """``jacobian_at`` by the problem itself; zeros for parameters (p,) other than ``only``, all if None."""
    wanted = (np.ones(z.shape[0], dtype=bool) if active is None else active)[problem.unit]
    chosen = np.ones(z.shape[1], dtype=bool) if only is None else only
    small = np.where(problem.logarithmic, NO_PERCENT, A_THOUSANDTH * (problem.high - problem.low))
    out = _slopes_over(problem, z, residual, small, wanted, np.flatnonzero(chosen).tolist())
    if problem.stride is not None:
        flat = (chosen & (problem.stride > 0))[:, None] & wanted & ~out.any(axis=1)
        if problem.touches is not None:
            flat &= problem.touches
        longer, columns = np.flatnonzero(flat.any(axis=1)).tolist(), np.asarray(flat.any(axis=0))
        far = _slopes_over(problem, z, residual, problem.stride, columns, longer)
        out = np.where(flat[:, None, :], far, out)
    return out


def _slopes_over(
    problem: Problem, z: Floats, residual: Floats, step: Floats, wanted: Bools, parameters: Sequence[int]
) -> Floats:
    """(p, N, U') differences over a ``step`` (p,) of some parameters in ``wanted`` columns (U',), zeros elsewhere."""
    low, high = problem.low, problem.high
    there = np.clip(z + np.where(z + step > high, -step, step), low, high)
    out = np.zeros((z.shape[1], *residual.shape))
    groups = _apart(problem, parameters, wanted)

    def perturbed(together: list[int]) -> Floats:
        moved = z.copy()
        moved[:, together] = there[:, together]
        asked = wanted if problem.touches is None else wanted & problem.touches[together].any(axis=0)
        return problem.residual_of(asked, from_scale(moved, problem)) - residual

    for together, difference in zip(groups, in_parallel(perturbed, groups), strict=True):
        for i in together:
            change = (there[:, i] - z[:, i])[problem.unit]
            seen = (change != 0) & wanted
            if problem.touches is not None:
                seen &= problem.touches[i]
            out[i][:, seen] = difference[:, seen] / change[seen]
    return out


def carry_slopes(problem: Problem, jacobian: Floats, step: Floats, change: Floats, units: Bools) -> None:
    """Slopes (p, N, U') of some ``units`` (U,) that a ``step`` (U, p) changed the residuals by ``change`` (N, U') tells
    of, in place: the least change of them that agrees with it (Broyden 1965).
    """
    for u in np.flatnonzero(units).tolist():
        mine, columns = _of_unit(problem, u, jacobian.shape[0])
        along = step[u, mine]
        length = float(along @ along)
        if length == 0:
            continue
        at = np.ix_(mine, np.arange(jacobian.shape[1]), columns)
        slopes = jacobian[at]
        missed = change[:, columns] - np.tensordot(along, slopes, axes=1)
        jacobian[at] = slopes + np.multiply.outer(along / length, missed)


def _apart(problem: Problem, parameters: Sequence[int], wanted: Bools) -> list[list[int]]:
    """``parameters`` in groups, no two of a group touching the same column; those of columns ``wanted`` (U',) only."""
    if problem.touches is None:
        return [[i] for i in parameters]
    groups: list[list[int]] = []
    taken: list[Bools] = []
    for i in parameters:
        mine = problem.touches[i] & wanted
        if not mine.any():
            continue
        free = next((g for g, columns in enumerate(taken) if not (columns & mine).any()), None)
        if free is None:
            groups.append([i])
            taken.append(mine.copy())
        else:
            groups[free].append(i)
            taken[free] |= mine
    return groups


def _of_unit(problem: Problem, unit: int, count: int) -> tuple[Ints, Ints]:
    """Which of ``count`` parameters can change a unit, and its columns."""
    columns = np.flatnonzero(problem.unit == unit)
    if problem.touches is None:
        return np.arange(count), columns
    return np.flatnonzero(problem.touches[:, columns].any(axis=1)), columns


def _flat(matrix: Floats, columns: Ints) -> Floats:
    """(..., N, U') to (..., n): some columns, one behind the other."""
    return np.ascontiguousarray(matrix[..., columns]).reshape(
        *matrix.shape[:-2], matrix.shape[-2] * columns.size
    )


class Quadratic(NamedTuple):
    """The cost of a unit about some parameters as far as its slope (p,) and its curvature (p, p) tell; both are zero
    for parameters that do not change it.
    """

    slope: Floats
    curvature: Floats


def quadratic(problem: Problem, unit: int, jacobian: Floats, residual: Floats, weight: Floats) -> Quadratic:
    """The cost of a unit, the residuals (N, U') being straight lines; column by column: few parameters change each."""
    p = jacobian.shape[0]
    slope, curvature = np.zeros(p), np.zeros((p, p))
    for column in np.flatnonzero(problem.unit == unit).tolist():
        slopes = jacobian[:, :, column]
        mine = slopes.any(axis=1) if problem.touches is None else problem.touches[:, column]
        steep = slopes[mine]
        weighted = steep * weight[:, column]
        curvature[np.ix_(mine, mine)] += weighted @ steep.T
        slope[mine] += weighted @ residual[:, column]
    return Quadratic(slope, curvature)


def damped_step(problem: Problem, model: Quadratic, damping: float, z: Floats) -> tuple[Floats, float]:
    """A damped Gauss-Newton step (p,) of a unit within half the box, and by how much its cost should fall, inf if
    unknown.
    """
    low, high = problem.low, problem.high
    gradient, hessian = model
    # a parameter at its bound that wants to go further stays there
    free = ~(((z <= low) & (gradient > 0)) | ((z >= high) & (gradient < 0)))
    free &= np.diag(hessian) > ROUNDING
    step = np.zeros(z.size)
    if free.any():
        h = hessian[np.ix_(free, free)]
        h = h + damping * np.diag(np.diag(h))
        try:
            step[free] = -np.linalg.solve(h, gradient[free])
        except np.linalg.LinAlgError:
            step[free] = -gradient[free] / np.diag(h)
    short = np.clip(step, -0.5 * (high - low), 0.5 * (high - low))
    if np.any(short != step):  # in another direction, for which the quadratic model predicts nothing
        return short, math.inf
    return step, float(-(gradient @ step) - 0.5 * step @ hessian @ step)


def sandwich(problem: Problem, unit: int, jacobian: Floats, residual: Floats, weight: Floats) -> Floats:
    """Sandwich estimate (p, p) of a unit: residuals within a block may be correlated in any way."""
    p = jacobian.shape[0]
    mine, columns = _of_unit(problem, unit, p)
    block = problem.block[:, columns].ravel()
    used = block >= 0
    steep = _flat(jacobian[mine], columns)
    weighted = steep * _flat(weight, columns)
    hessian = np.zeros((p, p))
    hessian[np.ix_(mine, mine)] = weighted @ steep.T
    names, index = np.unique(block[used], return_inverse=True)
    pulls = (weighted * _flat(residual, columns))[:, used]
    scores = np.zeros((p, names.size))
    for i, pull in zip(mine, pulls, strict=True):
        scores[i] = np.bincount(index, weights=pull, minlength=names.size)
    usable = np.diag(hessian) > ROUNDING
    out = np.full((p, p), np.inf)
    if usable.any() and names.size > mine.size:
        inverse = np.linalg.pinv(hessian[np.ix_(usable, usable)], hermitian=True)
        # scores of neighbouring blocks go together: add lag one (Newey-West)
        inner = np.asarray(scores[usable])
        meat = np.asarray(inner @ inner.T, dtype=np.float64)
        lag = inner[:, 1:] @ inner[:, :-1].T
        meat = meat + 0.5 * (lag + lag.T)
        meat *= names.size / (names.size - mine.size)
        out[np.ix_(usable, usable)] = inverse @ meat @ inverse
    return out


def information_on(problem: Problem, jacobian: Floats, weight: Floats) -> Floats:
    """(U, p) Fisher information on each parameter: curvature of the cost on the fitted scale, a block as one sample.

    About one over the variance that a parameter would have left: residuals that it does not change say nothing of it.
    """
    size = np.bincount(problem.block[problem.block >= 0], minlength=problem.allowed_square.size)
    each = weight / np.maximum(size, 1)[np.maximum(problem.block, 0)]
    out = np.zeros((int(problem.unit.max()) + 1 if problem.unit.size else 0, jacobian.shape[0]))
    np.add.at(out, problem.unit, np.einsum("inu,nu->ui", np.square(jacobian), each))
    return out
