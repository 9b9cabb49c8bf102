"""Noise taken out of measured signals before they are differentiated, by a replay or by a difference of positions."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SMOOTH_S = 0.2


def smoothed(t_s: Floats, signal: Floats, span_s: float = SMOOTH_S) -> Floats:
    """Columns of ``signal`` (N, c) with noise taken out by a cubic through every ``span_s`` (Savitzky and Golay 1964).

    Differentiated noise of the readings would shake the simulated body loose from the ground. A signal with gaps is
    returned as it is.
    """
    from scipy.ndimage import convolve1d

    width = 2 * int(0.5 * span_s / float(np.median(np.diff(t_s)))) + 1
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
