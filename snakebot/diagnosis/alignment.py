"""Two runs laid side by side by their commands: repeats are one motion, but their logs may begin at other times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SAME_COMMAND = 0.01  # of a command's amplitude, closer than which two set-points are the same
LEAST_ALIKE = 0.8  # share of the samples whose set-points must be the same
LEAST_ALIKE_JOINT = 0.5  # ... of each joint
FAR_OFF = 0.25  # rms of what the commands differ by, over their own, beyond which the motion is another one
LEAST_OVERLAP = 0.5  # of the shorter run
NO_SHIFT = 0.05  # of a sample's interval: a shift that small is the jitter of the ticks
STEPS = 8  # of a fit of the shift


@dataclass(frozen=True, eq=False)
class Alignment:
    """Where one run lies in another.

    Attributes:
        shift_s: what the one run does at ``t``, the other does at ``t + shift_s``, both from their first samples.
        same: (N, k) samples of the one run at which both are told the same.
    """

    shift_s: float
    same: Bools


def align(t_s: Floats, command_rad: Floats, other_t_s: Floats, other_rad: Floats) -> Alignment | None:
    """Find one run's motion in another run; None where the other was told something else.

    Args:
        t_s, other_t_s: (N,), (M,) rising times.
        command_rad, other_rad: (N, k), (M, k) set-points; nan = servo off.
    """
    ta, tb = t_s - t_s[0], other_t_s - other_t_s[0]
    pair = _Pair(ta, command_rad, tb, other_rad)
    found = pair.alignment(pair.refined(0.0))
    if found is None:
        coarse = pair.best_shift_s()
        found = None if coarse is None else pair.alignment(pair.refined(coarse))
    return found


class _Pair:
    """The commands of two runs, times from zero."""

    def __init__(self, ta: Floats, a: Floats, tb: Floats, b: Floats) -> None:
        self.ta, self.a, self.tb, self.b = ta, a, tb, b
        self.period_s = float(max(np.median(np.diff(ta)), np.median(np.diff(tb))))
        known = np.isfinite(a)
        spread, largest = np.zeros(a.shape[1]), np.zeros(a.shape[1])
        for j in range(a.shape[1]):
            if known[:, j].any():
                spread[j], largest[j] = np.std(a[known[:, j], j]), np.max(np.abs(a[known[:, j], j]))
        self.size_rad = spread + 0.05 * largest + 1e-9  # (k,)

    def there(self, shift_s: float) -> Floats:
        """(N, k) commands of the other run at the samples of this one; nan outside it."""
        t = self.ta + shift_s
        inside = (t >= self.tb[0] - 1e-9) & (t <= self.tb[-1] + 1e-9)
        other = np.stack([np.interp(t, self.tb, column) for column in self.b.T], axis=1)
        return np.where(inside[:, None], other, np.nan)

    def mean_square(self, shift_s: float) -> float:
        off = (self.a - self.there(shift_s)) / self.size_rad
        known = np.isfinite(off)
        return float(np.square(off[known]).mean()) if known.any() else np.inf

    def refined(self, shift_s: float) -> float:
        """The shift nearby at which the commands differ least, to a fraction of a sample (Gauss-Newton)."""
        best, square = shift_s, self.mean_square(shift_s)
        for _ in range(STEPS):
            other = self.there(best)
            rate = (self.there(best + 0.5 * self.period_s) - self.there(best - 0.5 * self.period_s)) / (
                self.period_s * self.size_rad
            )
            off = (self.a - other) / self.size_rad
            known = np.isfinite(off) & np.isfinite(rate)
            steep = float(np.square(rate[known]).sum())
            if steep <= 0:
                break
            step = float((off[known] * rate[known]).sum()) / steep
            tried = self.mean_square(best + step)
            if tried >= square:
                break
            best, square = best + step, tried
        return 0.0 if abs(best) < NO_SHIFT * self.period_s else best

    def best_shift_s(self) -> float | None:
        """The shift, to a sample, at which the commands differ least over their overlap; of equal ones the smallest."""
        from scipy.signal import correlate, correlation_lags

        h = self.period_s
        a, known_a = _even(self.ta, self.a / self.size_rad, h)
        b, known_b = _even(self.tb, self.b / self.size_rad, h)
        total = np.zeros(a.shape[0] + b.shape[0] - 1)
        count = np.zeros_like(total)
        for j in range(a.shape[1]):
            x, y, m, n = a[:, j], b[:, j], known_a[:, j], known_b[:, j]
            total += correlate(n * y**2, m, method="fft") - 2 * correlate(y, x, method="fft")
            total += correlate(n, m * x**2, method="fft")
            count += correlate(n, m, method="fft")
        lag = correlation_lags(b.shape[0], a.shape[0])
        enough = count >= LEAST_OVERLAP * min(known_a.sum(), known_b.sum())
        if not enough.any() or not known_a.any() or not known_b.any():
            return None
        square = np.where(enough, np.maximum(total, 0.0) / np.maximum(count, 1.0), np.inf)
        near = np.flatnonzero(square <= 1.5 * square.min() + SAME_COMMAND**2)
        at = int(near[np.argmin(np.abs(lag[near]))])
        while 0 < at < square.size - 1:
            nearby = at - 1 + int(np.argmin(square[at - 1 : at + 2]))
            if nearby == at:
                break
            at = nearby
        return float(lag[at] * h)

    def alignment(self, shift_s: float) -> Alignment | None:
        """The runs at a shift, or None where they are not told the same there."""
        other = self.there(shift_s)
        inside = (self.ta + shift_s >= -1e-9) & (self.ta + shift_s <= self.tb[-1] + 1e-9)
        if inside.sum() * np.median(np.diff(self.ta)) < LEAST_OVERLAP * min(self.ta[-1], self.tb[-1]):
            return None
        told_a, told_b = np.isfinite(self.a), np.isfinite(other)
        # the edge of a step may come half a sample sooner or later
        step = np.abs(np.diff(self.a, axis=0, prepend=self.a[:1]))
        steep = np.fmax(step, np.vstack([step[1:], step[-1:]]))
        room = SAME_COMMAND * self.size_rad + 0.5 * np.nan_to_num(steep)
        off = np.abs(self.a - other)
        same = np.where(told_a & told_b, off <= room, ~told_a & ~told_b) & inside[:, None]
        asked = (told_a | told_b) & inside[:, None]
        if not asked.any():
            return None
        both = told_a & told_b & inside[:, None]
        relative = (off / self.size_rad)[both]
        if relative.size == 0 or float(np.sqrt(np.square(relative).mean())) > FAR_OFF:
            return None
        if (same & asked).sum() < LEAST_ALIKE * asked.sum():
            return None
        for j in range(self.a.shape[1]):
            if (same & asked)[:, j].sum() < LEAST_ALIKE_JOINT * asked[:, j].sum():
                return None
        return Alignment(shift_s, same)


def _even(t_s: Floats, columns: Floats, step_s: float) -> tuple[Floats, Floats]:
    """Columns (N, k) at even times, zero where not known; and (M, k) of ones where known."""
    t = np.arange(0.0, t_s[-1] + 0.5 * step_s, step_s)
    out = np.stack([np.interp(t, t_s, column) for column in columns.T], axis=1)
    known = np.isfinite(out)
    return np.where(known, out, 0.0), known.astype(np.float64)
