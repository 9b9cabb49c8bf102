"""Noise taken out of measured signals before they are differentiated, by a replay or by a difference of positions."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from snakebot.arrays import Floats

SMOOTH_S = 0.2  # span of the cubics through joint angles and poses, s; chosen
# Longest over usual step in time, above which a filter that counts samples would bend the signal; chosen.
UNEVEN = 1.5


def smoothed(t_s: Floats, signal: Floats) -> Floats:
    """Columns of ``signal`` (N, c) with noise taken out by a cubic through every ``SMOOTH_S`` (Savitzky, Golay 1964).

    Differentiated noise of the readings would shake the simulated body loose from the ground. A signal with gaps is
    returned as it is; where rows are missing, the cubics go through what lies between.
    """
    steps = np.diff(t_s)
    usual = float(np.median(steps))
    if float(steps.max()) > UNEVEN * usual and np.isfinite(signal).all():
        even = np.linspace(t_s[0], t_s[-1], max(2, round((t_s[-1] - t_s[0]) / usual) + 1))
        smooth = _evenly_smoothed(usual, _at(even, t_s, signal))
        return _at(t_s, even, smooth)
    return _evenly_smoothed(usual, signal)


def _at(where_s: Floats, t_s: Floats, signal: Floats) -> Floats:
    """Columns of ``signal`` (N, c), sampled at ``t_s``, at other times."""
    return np.stack([np.interp(where_s, t_s, column) for column in signal.T], axis=1)


def _evenly_smoothed(period_s: float, signal: Floats) -> Floats:
    from scipy.ndimage import convolve1d

    width = 2 * int(0.5 * SMOOTH_S / period_s) + 1
    width = min(width, signal.shape[0] - 1 + signal.shape[0] % 2)
    if width < 5 or not np.isfinite(signal).all():
        return signal
    middle, ends = _weights(width)
    out = np.asarray(convolve1d(signal, middle, axis=0, mode="nearest"))
    half = width // 2  # towards the ends, the cubic through the last span
    out[:half] = ends[:half] @ signal[:width]
    out[-half:] = ends[-half:] @ signal[-width:]
    return out


@lru_cache(maxsize=8)
def _weights(width: int) -> tuple[Floats, Floats]:
    """Weights (width,) of the cubic's middle value, and (width, width) of all its values."""
    x = np.linspace(-1, 1, width)
    powers = np.vander(x, 4)
    values = powers @ np.linalg.pinv(powers)
    return values[width // 2][::-1], values
