"""The cheapest gait for each speed (29), between the gaits of a sweep, and how sharp that optimum is.

A front picked from a grid jumps from gait to gait, as neighbours hardly differ in power. Here each (alpha, beta) is a
curve of power over speed; at a given speed the least power is found over all curves, and a quadratic through the
neighbours finds the place between them. The gaits that cost at most 2 % more say how far an optimum read off a figure
may lie from another one: the paper's error bars.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats

SLACK = 0.02  # of the power: what counts as just as good
_SHIFTS = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])


@dataclass(frozen=True)
class SweptOptimum:
    """The cheapest gait at one speed; ranges are those of the grid's gaits that cost at most 2 % more."""

    speed_m_s: float
    alpha_deg: float
    beta_deg: float
    omega_rad_s: float
    power_w: float
    alpha_range_deg: tuple[float, float]
    beta_range_deg: tuple[float, float]


def cheapest(
    gaits: Floats, speed_m_s: Floats, power_w: Floats, speeds: Sequence[float]
) -> list[SweptOptimum]:
    """Optima at the speeds that lie inside the sweep; speeds whose optimum is at its edge are left out.

    Args:
        gaits: (G, 3) or more: alpha and beta in rad, omega in rad/s; a full grid.
        speed_m_s, power_w: (G,).
    """
    axes = [np.unique(np.round(gaits[:, axis], 12)) for axis in range(3)]
    shape = tuple(len(axis) for axis in axes)
    order = np.lexsort((gaits[:, 2], gaits[:, 1], gaits[:, 0]))
    v, p = speed_m_s[order].reshape(shape), power_w[order].reshape(shape)
    curves = {}
    for at in np.ndindex(shape[:2]):
        usable = (v[at] > 0) & (p[at] > 0)
        stuck = np.flatnonzero(~usable[1:] | ~usable[:-1] | (np.diff(v[at]) <= 0))
        first = int(stuck[-1]) + 1 if stuck.size else 0  # slow gaits may slip instead of moving on
        if first < shape[2] - 1:
            curves[at] = (np.log(v[at][first:]), np.log(p[at][first:]), np.log(axes[2][first:]))
    found = []
    for speed in speeds:
        cost, omega = np.full(shape[:2], np.inf), np.full(shape[:2], np.nan)
        for at, (log_v, log_p, log_omega) in curves.items():
            if log_v[0] <= np.log(speed) <= log_v[-1]:
                cost[at] = np.interp(np.log(speed), log_v, log_p)
                omega[at] = np.interp(np.log(speed), log_v, log_omega)
        optimum = _between(axes, cost, omega, float(speed))
        if optimum is not None:
            found.append(optimum)
    return found


def _between(axes: list[Floats], cost: Floats, log_omega: Floats, speed: float) -> SweptOptimum | None:
    i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
    if not (0 < i < cost.shape[0] - 1 and 0 < j < cost.shape[1] - 1):
        return None
    cells = (i + _SHIFTS[:, 0], j + _SHIFTS[:, 1])
    if not np.isfinite(cost[cells]).all():
        return None
    x, y = _SHIFTS.T.astype(float)
    terms = np.column_stack([np.ones(9), x, y, x * x, x * y, y * y])
    c, *_ = np.linalg.lstsq(terms, cost[cells], rcond=None)
    w, *_ = np.linalg.lstsq(terms, log_omega[cells], rcond=None)
    curvature = np.array([[2 * c[3], c[4]], [c[4], 2 * c[5]]])
    place = np.zeros(2)
    if np.linalg.eigvalsh(curvature)[0] > 0:
        place = np.clip(-np.linalg.solve(curvature, c[1:3]), -1, 1)
    a, b = place
    at = np.array([1.0, a, b, a * a, a * b, b * b])
    alpha, beta = np.degrees(axes[0]), np.degrees(axes[1])
    near_alpha, near_beta = np.nonzero(cost <= cost[i, j] + np.log1p(SLACK))
    return SweptOptimum(
        speed_m_s=speed,
        alpha_deg=float(np.interp(i + a, np.arange(len(alpha)), alpha)),
        beta_deg=float(np.interp(j + b, np.arange(len(beta)), beta)),
        omega_rad_s=float(np.exp(at @ w)),
        power_w=float(np.exp(at @ c)),
        alpha_range_deg=(float(alpha[near_alpha.min()]), float(alpha[near_alpha.max()])),
        beta_range_deg=(float(beta[near_beta.min()]), float(beta[near_beta.max()])),
    )


def omega_over_speed(optima: Sequence[SweptOptimum]) -> tuple[float, float]:
    """Least-squares line omega = slope v + intercept (Figs. 7, 10, 17, 20): rad/m, rad/s; NaN for fewer than two."""
    if len(optima) < 2:
        return float("nan"), float("nan")
    slope, intercept = np.polyfit([o.speed_m_s for o in optima], [o.omega_rad_s for o in optima], 1)
    return float(slope), float(intercept)


def slope_through_origin(optima: Sequence[SweptOptimum]) -> float:
    """Least-squares omega = slope v, rad/m."""
    v, omega = np.array([(o.speed_m_s, o.omega_rad_s) for o in optima]).T
    return float(v @ omega / (v @ v))
