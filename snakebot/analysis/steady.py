"""Which part of a run is steady: chosen from the data, by a rule that can be shown beside the result.

One cycle wide windows, half a cycle apart, are each described by the sines of every joint (command and
measured) and by the distance the body covered. The steady state is the longest unbroken stretch of windows
that agree with one of them; it is cut to whole cycles, counted from its end, because ramps and transients
lie at the start.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np

from snakebot.analysis.sine import fit_sine
from snakebot.arrays import Bools, Floats
from snakebot.robust import MAD_TO_STD

TOLERANCE = 0.01  # of the joint's amplitude, or of the distance a cycle
MIN_SETTLED_CYCLES = 2  # whole cycles of the gait that must be alike; fewer show no trend
SAMPLES_A_CYCLE = 3  # fewer show no wave
MIN_SETTLED_SHARE = 0.2  # of all cycles: a drift, too, has a piece where it is slow


@dataclass(frozen=True)
class SteadyState:
    """A window [``start_s``, ``end_s``] and how it was come by.

    ``settled`` is false where no part of the run deserves the name; ``reason`` says what was done in its
    place. ``cycles`` is 0 for a motion that is not periodic.
    """

    start_s: float
    end_s: float
    cycles: int
    settled: bool
    reason: str

    def mask(self, t_s: Floats) -> Bools:
        """Samples (N,) inside: the end is left out, so that whole cycles are not counted one sample twice."""
        inside = (t_s >= self.start_s - 1e-9) & (t_s < self.end_s - 1e-9)
        return inside if inside.any() else np.isfinite(t_s)

    @property
    def duration_s(self) -> float:
        return self.end_s - self.start_s


def find_steady_state(
    t_s: Floats,
    command_rad: Floats,
    measured_rad: Floats,
    omega_rad_s: float | None,
    position_m: Floats | None = None,
) -> SteadyState:
    """Choose the steady part of a run.

    Args:
        t_s: times (N,), rising.
        command_rad, measured_rad: joint angles (N, k), ``nan`` = servo off or sample lost.
        omega_rad_s: the gait's frequency, ``None`` for a motion that is not periodic.
        position_m: centre of mass (N, 2) where the pose is known.
    """
    start, end = _commanded_span(t_s, command_rad)
    if omega_rad_s is None:
        return SteadyState(start, end, 0, False, "not a periodic motion: all of the commanded span is used")
    period = 2 * math.pi / omega_rad_s
    if period < SAMPLES_A_CYCLE * (t_s[-1] - t_s[0]) / max(len(t_s) - 1, 1):
        return SteadyState(
            start,
            end,
            0,
            False,
            f"{omega_rad_s:g} rad/s is too fast for the samples: all of the span is used",
        )
    count = math.floor((end - start) / period * (1 + 1e-9) + 0.02)
    if count < 3:
        return SteadyState(
            start,
            end,
            max(count, 0),
            False,
            f"only {(end - start) / period:.1f} cycles: all of them are used",
        )
    first = np.arange(start, end - period * 0.98, period / 2)
    features = np.stack(
        [_describe(t_s, command_rad, measured_rad, position_m, t0, period, omega_rad_s) for t0 in first]
    )
    stretch = _longest_steady_stretch(features)
    if stretch is not None:
        low, high = stretch
        cycles = (high - low) // 2 + 1
        if cycles >= max(MIN_SETTLED_CYCLES, MIN_SETTLED_SHARE * count):
            window_end = min(float(first[high]) + period, end)
            left_out = count - cycles
            return SteadyState(
                window_end - cycles * period,
                window_end,
                int(cycles),
                True,
                f"{cycles} whole cycles agree within {100 * TOLERANCE:.0f} % or the run's own scatter"
                + (f"; {left_out} of {count} cycles left out" if left_out else ""),
            )
    cycles = max(1, count // 2)
    return SteadyState(
        end - cycles * period,
        end,
        cycles,
        False,
        f"no stretch is steady: the last {cycles} of {count} cycles are used",
    )


def _commanded_span(t_s: Floats, command_rad: Floats) -> tuple[float, float]:
    """From the first to the last sample at which any servo had a command that is part of a motion."""
    known = np.isfinite(command_rad).any(axis=1)
    moving = np.zeros(len(t_s), dtype=bool)
    moving[1:] = (np.abs(np.diff(command_rad, axis=0)) > 1e-9).any(axis=1)
    used = np.flatnonzero(moving if moving.sum() > 2 else known)
    if len(used) == 0:
        return float(t_s[0]), float(t_s[-1])
    return float(t_s[max(used[0] - 1, 0)]), float(t_s[used[-1]])


def _describe(
    t_s: Floats,
    command: Floats,
    measured: Floats,
    position: Floats | None,
    start: float,
    period: float,
    omega: float,
) -> Floats:
    """Features of one window: real and imaginary part and offset of each joint's sine; distance covered."""
    window = (t_s >= start) & (t_s < start + period)
    features: list[float] = []
    for signals in (command, measured):
        for signal in signals.T:
            fit = fit_sine(t_s[window], signal[window], omega)
            if fit is None:
                features += [math.nan] * 3
            else:
                features += [
                    fit.amplitude * math.cos(fit.phase_rad),
                    fit.amplitude * math.sin(fit.phase_rad),
                    fit.offset,
                ]
    if position is not None:
        ends = [np.interp([start, start + period], *_known(t_s, axis)) for axis in position.T]
        features.append(math.hypot(*(axis[1] - axis[0] for axis in ends)))
    return np.array(features)


def _known(t_s: Floats, values: Floats) -> tuple[Floats, Floats]:
    good = np.isfinite(values)
    return (t_s[good], values[good]) if good.any() else (t_s[:1], np.zeros(1))


def _scatter(features: Floats) -> Floats:
    """Three standard deviations from cycle to cycle, from second differences: noise is in them, a drift is
    not."""
    if len(features) < 6:
        return np.zeros(features.shape[1])
    second = features[4:] - 2 * features[2:-2] + features[:-4]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.nan_to_num(3 * MAD_TO_STD * np.nanmedian(np.abs(second), axis=0) / math.sqrt(6))


def _longest_steady_stretch(features: Floats) -> tuple[int, int] | None:
    """First and last window of the longest stretch in which all agree with one of them; of equals the latest."""
    known = np.isfinite(features)
    if len(features) < 3 or not known.any(axis=1).all():
        return None
    tolerance = _tolerance(features)
    best: tuple[int, int] | None = None
    for centre in range(len(features)):
        with np.errstate(invalid="ignore"):
            agrees = np.all(
                (np.abs(features - features[centre]) <= tolerance) | ~known | ~known[centre], axis=1
            )
        breaks = np.flatnonzero(~agrees)
        low = int(breaks[breaks < centre].max(initial=-1)) + 1
        high = int(breaks[breaks > centre].min(initial=len(features))) - 1
        if best is None or high - low >= best[1] - best[0]:
            best = (low, high)
    return best


def _tolerance(features: Floats) -> Floats:
    """How far each feature may be from that of another window."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a joint that is never known has no median
        middle = np.nanmedian(features, axis=0)
    joints = features.shape[1] // 6
    amplitude = np.nan_to_num(np.hypot(middle[0::3][: 2 * joints], middle[1::3][: 2 * joints]))
    largest = max(float(amplitude.max(initial=0.0)), 1e-12)
    scale = np.repeat(np.maximum(amplitude, 0.2 * largest), 3)
    if features.shape[1] > 6 * joints:
        # A body that hardly moves has no relative accuracy to speak of: twice the tolerance, and never below 1 mm.
        scale = np.append(scale, max(2 * abs(float(middle[-1])), 1e-3 / TOLERANCE))
    return np.asarray(np.maximum(TOLERANCE * scale, _scatter(features)))
