"""A servo with a little of everything, fitted joint by joint: the plain fit that a diagnosis must not lose to.

A set-point arrives after a delay, the servo follows with a first-order lag, the gear has play, the reading a gain and
an offset. No cause is named and nothing is weighed. Nelder-Mead looks for delay, lag and play first, with gain and
offset solved for, and in the end for all five.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# Where Nelder-Mead starts: every pairing of these. Smart servos answer after 5 to 100 ms, their gears have .1 to 2 deg.
DELAYS_S = (0.002, 0.03)
LAGS_S = (0.01, 0.06)
PLAYS_RAD = (0.003, 0.03)
SCALE = np.array([0.01, 0.01, 0.01, 0.05, 0.01])  # first steps of the search: s, s, rad, -, rad
COARSE, FINE = (
    1e-2,
    1e-4,
)  # how close, in these steps, a search comes before it ends: from each start, from the best
LEAST_GAIN = 0.05  # below it a reading says nothing of where the gear stands
SLOWEST_S = 10.0  # longest delay and lag; a run lasts longer


@dataclass(frozen=True, eq=False)
class JointRun:
    """One joint in one run: set-points (M,) at their own times, samples (N,), and which of them count.

    ``measured_rad`` has no gaps; ``off`` (M,) tells where no set-point was sent.
    """

    set_s: Floats
    set_rad: Floats
    off: Bools
    t_s: Floats
    measured_rad: Floats
    use: Bools


@dataclass(frozen=True)
class Composite:
    """Five numbers of one joint. ``play_rad`` is the whole width of the gap."""

    delay_s: float
    lag_s: float
    gain: float
    offset_rad: float
    play_rad: float


def predicted(run: JointRun, servo: Composite) -> Floats:
    """The readings (N,) of a run."""
    gain = servo.gain if abs(servo.gain) > LEAST_GAIN else 1.0
    known = (run.measured_rad - servo.offset_rad) / gain
    moved = _followed(run, known, servo.delay_s, servo.lag_s, servo.play_rad)
    return np.asarray(servo.gain * moved + servo.offset_rad)


def fit(runs: Sequence[JointRun]) -> Composite | None:
    """The least mean square over all samples that count; None where there are none."""
    from scipy.optimize import minimize

    if not any(run.use.any() for run in runs):
        return None

    def searched(square: Callable[[Floats], float], start: Floats, step: float) -> Any:
        options = {"xatol": step, "fatol": np.inf, "maxfev": 600}
        return minimize(square, start, method="Nelder-Mead", options=options)

    def of_three(x: Floats) -> float:
        return _solved(runs, x)[0]

    def of_five(x: Floats) -> float:
        total, count = mean_square(runs, _composite(x))
        return total / count

    starts = [np.array([d, lag, w]) / SCALE[:3] for d in DELAYS_S for lag in LAGS_S for w in PLAYS_RAD]
    best = min((searched(of_three, start, COARSE) for start in starts), key=lambda found: float(found.fun))
    _, gain, offset_rad = _solved(runs, best.x)
    whole = np.append(best.x, [(gain - 1) / SCALE[3], offset_rad / SCALE[4]])
    return _composite(searched(of_five, whole, FINE).x)


def mean_square(runs: Sequence[JointRun], servo: Composite) -> tuple[float, int]:
    """Sum of squared residuals over the samples that count, and how many they are."""
    total, count = 0.0, 0
    for run in runs:
        residual = (predicted(run, servo) - run.measured_rad)[run.use]
        total, count = total + float(residual @ residual), count + residual.size
    return total, count


def _inside(x: Floats) -> tuple[float, float, float]:
    """Delay, lag and play of a point of the search, which may wander below zero and is reflected there."""
    delay_s, lag_s, play_rad = (float(v) for v in np.abs(x) * SCALE[:3])
    return min(delay_s, SLOWEST_S), min(lag_s, SLOWEST_S), play_rad


def _composite(x: Floats) -> Composite:
    delay_s, lag_s, play_rad = _inside(x[:3])
    return Composite(delay_s, lag_s, 1 + float(x[3] * SCALE[3]), float(x[4] * SCALE[4]), play_rad)


def _solved(runs: Sequence[JointRun], x: Floats) -> tuple[float, float, float]:
    """Mean square at the best gain and offset for these delay, lag and play; and both. The gear starts as read."""
    n = 0
    sx = sy = sxx = sxy = syy = 0.0
    for run in runs:
        moved, measured = _followed(run, run.measured_rad, *_inside(x))[run.use], run.measured_rad[run.use]
        n += moved.size
        sx, sy = sx + float(moved.sum()), sy + float(measured.sum())
        sxx, syy = sxx + float(moved @ moved), syy + float(measured @ measured)
        sxy += float(moved @ measured)
    spread = sxx - sx * sx / n
    gain = (sxy - sx * sy / n) / spread if spread > 1e-12 * n else 1.0
    offset = (sy - gain * sx) / n
    left = syy - 2 * gain * sxy - 2 * offset * sy + gain**2 * sxx + 2 * gain * offset * sx + n * offset**2
    return max(left / n, 0.0), gain, offset


def _followed(run: JointRun, known_rad: Floats, delay_s: float, lag_s: float, play_rad: float) -> Floats:
    made: Floats = _follow(
        run.set_s, run.set_rad, run.off, run.t_s, known_rad, delay_s, max(lag_s, 1e-6), 0.5 * play_rad
    )
    return made


@njit(cache=True)
def _follow(
    set_s: Any, set_rad: Any, off: Any, t_s: Any, known: Any, delay: float, lag: float, half: float
) -> Any:
    """Held set-points through delay, lag (exact between the steps) and play; without set-points, where it is known."""
    out = np.empty(t_s.size)
    motor = gear = known[0]
    now, follows, target, driven = t_s[0], 0, 0.0, False
    for i in range(t_s.size):
        while True:
            arrives = set_s[follows] + delay if follows < set_s.size else np.inf
            until = min(arrives, t_s[i])
            if driven and until > now:
                motor = target + (motor - target) * np.exp(-(until - now) / lag)
                gear = min(max(gear, motor - half), motor + half)
            now = max(now, until)
            if arrives > t_s[i]:
                break
            driven = not off[follows]
            target = set_rad[follows]
            follows += 1
        if not driven:
            motor = gear = known[i]
        out[i] = gear
    return out
