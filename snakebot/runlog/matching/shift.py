"""The shift in time between two recordings of one motion, to a fraction of a sample: least squares over all shifts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats

MIN_OVERLAP = 0.3  # share of the shorter recording that two recordings must have in common; chosen
EQUALLY_GOOD = 0.01  # misfits that differ by less belong to a motion that repeats; chosen
DEEP = 0.1  # misfit above the least one, up to which a valley between two samples may turn out the deepest; chosen
# Sample intervals, across which a signal is not interpolated; chosen: up to four are bridged, as by
# ``diagnosis.evidence.repeats``, and the half keeps the jitter of the ticks from deciding about four.
WIDEST_GAP = 4.5


@dataclass(frozen=True)
class Shift:
    """``b`` trails ``a`` by ``shift_s``: ``a(t)`` belongs to ``b(t + shift_s)``.

    ``shift_samples`` counts in samples of ``a``; ``misfit`` is the rms difference left over the rms of ``a``.
    """

    shift_s: float
    shift_samples: float
    misfit: float
    overlap_s: float


def find_shift(
    a_t_s: Floats,
    a: Floats,
    b_t_s: Floats,
    b: Floats,
    *,
    most_s: float | None = None,
    least_s: float | None = None,
    offsets: bool = True,
    min_overlap: float = MIN_OVERLAP,
) -> Shift | None:
    """Find the shift in time that brings two sets of signals closest, in the least-squares sense.

    Args:
        a_t_s, b_t_s: times (N,) and (M,); each recording may have its own beat. a, b: signals (N, k) and
            (M, k), ``nan`` where not known. most_s, least_s: largest and smallest shift looked at
            (``-most_s`` if only that is given); by default all that leave an overlap of ``min_overlap`` of the
            shorter recording. offsets: a constant offset of a signal is a finding, not a shift: it is taken out first.

    Returns:
        ``None`` where no signal is known in both or nothing moves. Of shifts that do equally well (a motion
        that is periodic throughout) the smallest is taken.
    """
    step = float(max(np.median(np.diff(a_t_s)), 1e-6)) if len(a_t_s) > 2 else math.nan
    shared = [i for i in range(min(a.shape[1], b.shape[1])) if _moves(a[:, i]) and _moves(b[:, i])]
    if not math.isfinite(step) or len(b_t_s) < 3 or not shared:
        return None
    a_even = [_Signal(a_t_s, a[:, i]) for i in shared]
    b_even = [_Signal(b_t_s, b[:, i]) for i in shared]
    shorter = min(a_t_s[-1] - a_t_s[0], b_t_s[-1] - b_t_s[0])
    low = b_t_s[0] - a_t_s[-1] + min_overlap * shorter
    high = b_t_s[-1] - a_t_s[0] - min_overlap * shorter
    if most_s is not None:
        low, high = max(low, -most_s if least_s is None else least_s), min(high, most_s)
    shifts, costs = _coarse(a_even, b_even, (a_t_s[0], a_t_s[-1]), (b_t_s[0], b_t_s[-1]), step, offsets)
    wanted = (shifts >= low - step) & (shifts <= high + step) & np.isfinite(costs)
    if not wanted.any():
        return None
    shifts, costs = shifts[wanted], costs[wanted]

    def misfit_at(shift_s: float) -> float:
        return _misfit(a_t_s, a_even, b_even, b_t_s, shift_s, offsets)

    candidates = []
    for start in _valleys(shifts, costs):
        near = float(shifts[start])
        found = _least(misfit_at, max(near - 1.5 * step, low), min(near + 1.5 * step, high))
        misfit = misfit_at(found)
        if math.isfinite(misfit):
            candidates.append((misfit, found))
    if not candidates:  # so few samples are known in both that there is nothing to compare
        return None
    least = min(misfit for misfit, _ in candidates)
    misfit, shift = min((c for c in candidates if c[0] <= least + EQUALLY_GOOD), key=lambda c: abs(c[1]))
    overlap = min(a_t_s[-1], b_t_s[-1] - shift) - max(a_t_s[0], b_t_s[0] - shift)
    return Shift(
        shift_s=shift,
        shift_samples=shift / step,
        misfit=misfit,
        overlap_s=float(overlap),
    )


def shifted(t_s: Floats, b_t_s: Floats, b: Floats, shift_s: float) -> Floats:
    """Signals ``b`` (M, k) seen at times ``t_s`` (N,) of the other recording: (N, k), ``nan`` outside and
    in gaps."""
    return np.stack([_Signal(b_t_s, column).at(t_s + shift_s) for column in b.T], axis=1)


class _Signal:
    """Linear interpolation that gives ``nan`` outside, and across gaps wider than a few samples."""

    def __init__(self, t_s: Floats, y: Floats) -> None:
        good = np.isfinite(y)
        self.t, self.y = t_s[good], y[good]
        self.gap = WIDEST_GAP * float(np.median(np.diff(t_s))) if len(t_s) > 1 else 0.0

    def at(self, t_s: Floats) -> Floats:
        if len(self.t) < 2:
            return np.full(len(t_s), np.nan)
        out = np.interp(t_s, self.t, self.y, left=np.nan, right=np.nan)
        index = np.clip(np.searchsorted(self.t, t_s, side="right"), 1, len(self.t) - 1)
        out[(self.t[index] - self.t[index - 1]) > self.gap] = np.nan
        return np.asarray(out, dtype=np.float64)


def _moves(y: Floats) -> bool:
    good = y[np.isfinite(y)]
    return len(good) > 3 and float(np.std(good)) > 1e-9


def _misfit(
    t_s: Floats, a: list[_Signal], b: list[_Signal], b_t_s: Floats, shift: float, offsets: bool
) -> float:
    inside = (t_s + shift >= b_t_s[0]) & (t_s + shift <= b_t_s[-1])
    t = t_s[inside]
    if len(t) < 4:
        return math.nan
    left = total = 0.0
    for signal_a, signal_b in zip(a, b, strict=True):
        ya, yb = signal_a.at(t), signal_b.at(t + shift)
        known = np.isfinite(ya) & np.isfinite(yb)
        if known.sum() < 4:
            continue
        ya, yb = ya[known], yb[known]
        if offsets:
            ya, yb = ya - ya.mean(), yb - yb.mean()
        left += float(np.mean((ya - yb) ** 2))
        total += float(np.mean(ya**2) + np.mean(yb**2)) / 2
    return math.sqrt(left / total) if total > 0 else math.nan


def _coarse(
    a: list[_Signal],
    b: list[_Signal],
    a_span: tuple[float, float],
    b_span: tuple[float, float],
    step: float,
    offsets: bool,
) -> tuple[Floats, Floats]:
    """Misfit at every whole-sample shift at once, by correlation of the signals and of their masks."""
    a_t = np.arange(a_span[0], a_span[1] + step / 2, step)
    b_t = np.arange(b_span[0], b_span[1] + step / 2, step)
    size = 1 << (len(a_t) + len(b_t) - 1).bit_length()
    left, total = np.zeros(size), np.zeros(size)

    def correlate(x: Floats, y: Floats) -> Floats:
        return np.fft.irfft(np.conj(np.fft.rfft(x, size)) * np.fft.rfft(y, size), size)

    for signal_a, signal_b in zip(a, b, strict=True):
        ya, yb = signal_a.at(a_t), signal_b.at(b_t)
        ma, mb = np.isfinite(ya).astype(np.float64), np.isfinite(yb).astype(np.float64)
        if offsets:
            ya, yb = ya - np.nanmean(ya), yb - np.nanmean(yb)
        ya, yb = np.nan_to_num(ya), np.nan_to_num(yb)
        both = np.maximum(correlate(ma, mb), 0.5)
        power_a, power_b = correlate(ya**2, mb) / both, correlate(ma, yb**2) / both
        left += np.maximum(power_a + power_b - 2 * correlate(ya, yb) / both, 0)
        total += (power_a + power_b) / 2
    lags = np.arange(-(len(a_t) - 1), len(b_t))
    left, total = left[lags], total[lags]
    with np.errstate(all="ignore"):
        cost = np.where(total > 1e-12, np.sqrt(left / total), np.nan)
    return np.asarray((b_span[0] - a_span[0]) + lags * step), np.asarray(cost)


def _valleys(shifts: Floats, costs: Floats, most: int = 6) -> list[int]:
    """The deepest valley and those nearly as deep that lie nearest to no shift at all."""
    padded = np.concatenate([[np.inf], costs, [np.inf]])
    bottoms = np.flatnonzero((padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:]))
    deep = bottoms[
        costs[bottoms] <= costs.min() + DEEP
    ]  # a valley between two samples looks shallower than it is
    nearest = deep[np.argsort(np.abs(shifts[deep]), kind="stable")][:most]
    return sorted({int(np.argmin(costs)), *(int(i) for i in nearest)})


def _least(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import minimize_scalar

    return float(minimize_scalar(function, bounds=(low, high), method="bounded", options={"xatol": 1e-7}).x)
