"""What the nominal numbers may be off by is no gap, and no noise either: it is fitted, within bounds, beside every
cause.

A simulation knows the lag of its servos to some per cent, the wire's latency to a millisecond, friction and mass to a
few per cent. To widen the noise by all that would hide small causes behind it. So each explanation, the nominal one
too, may first shift each joint in time, and change friction and mass, by no more than the tolerance; what is left over
counts. Explanations that set such a number themselves get no tolerance there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LAG_TOLERANCE = 0.06  # relative error of the nominal time constant that is taken for granted
LATENCY_TOLERANCE_S = 1e-3  # of the wire and of the two clocks
FRICTION_TOLERANCE = 0.05  # relative error of friction coefficients
MASS_TOLERANCE = 0.03
SHARE_SPREAD = 0.5  # of a tolerance that is made use of, before anything was measured


def shift_limit_s(time_constant_s: float) -> float:
    """How far a joint may be shifted in time."""
    return LAG_TOLERANCE * time_constant_s + LATENCY_TOLERANCE_S


def rate_of(reading_rad: Floats, t_s: Floats) -> Floats:
    """Time derivative (N, k) of predicted readings, by central differences."""
    out = np.empty_like(reading_rad)
    out[1:-1] = (reading_rad[2:] - reading_rad[:-2]) / (t_s[2:] - t_s[:-2])[:, None]
    out[0] = (reading_rad[1] - reading_rad[0]) / (t_s[1] - t_s[0])
    out[-1] = (reading_rad[-1] - reading_rad[-2]) / (t_s[-1] - t_s[-2])
    return out


def shifts_s(residual: Floats, rate: Floats, block: Ints, allowed_square: Floats, limit_s: Floats) -> Floats:
    """(k,) advance of each joint, within its limit, that takes most off its residual.

    Args:
        residual, rate: (N, k) of all runs, one below the other.
        block: (N, k) block of each sample, -1 where unused.
        allowed_square: (B,). Blocks that stand out weigh less, as they do in the score.
        limit_s: (k,).
    """
    used = block >= 0
    flat = block[used]
    r, v = residual[used], rate[used]
    size = np.maximum(np.bincount(flat, minlength=allowed_square.size), 1)
    square = np.bincount(flat, weights=r * r, minlength=allowed_square.size) / size
    weight = 1.0 / (allowed_square + square)[flat]
    joint = np.broadcast_to(np.arange(block.shape[1]), block.shape)[used]
    k = block.shape[1]
    gained = np.bincount(joint, weights=weight * r * v, minlength=k)
    power = np.bincount(joint, weights=weight * v * v, minlength=k)
    shift = np.divide(gained, power, out=np.zeros(k), where=power > 0)
    return np.asarray(np.clip(shift, -limit_s, limit_s))


def stacked_rates(readings: Sequence[Floats], times_s: Sequence[Floats]) -> Floats:
    """(N, k) rates of all runs, one below the other."""
    return np.concatenate([rate_of(r, t) for r, t in zip(readings, times_s, strict=True)])


def bounded_share(residual: Floats, marks: Floats, least: Floats, allowed_square: Floats) -> Floats:
    """(m,) shares, ``least`` (m,) to 1, of the ``marks`` (F, m) of full tolerances that take most off a residual (F,).

    Features that stand out weigh less, as they do in the score. Shares that make no odds stay near zero.
    """
    from scipy.optimize import lsq_linear

    usable = np.isfinite(residual)
    if marks.shape[1] == 0 or usable.sum() <= marks.shape[1]:
        return np.zeros(marks.shape[1])
    weight = 1.0 / np.sqrt(allowed_square + np.square(residual))[usable]
    count = marks.shape[1]
    matrix = np.vstack([marks[usable] * weight[:, None], np.eye(count) / SHARE_SPREAD])
    wanted = np.concatenate([residual[usable] * weight, np.zeros(count)])
    return np.asarray(lsq_linear(matrix, wanted, (least, 1.0), method="bvls").x)
