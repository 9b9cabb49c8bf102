"""Derived curves for figures: rates, spectra, one cycle laid over the next."""

from __future__ import annotations

import math

import numpy as np

from snakebot.arrays import Floats


def smooth_rate(t_s: Floats, y: Floats, base_s: float) -> Floats:
    """Slope of ``y`` (N,) over a base of +-``base_s``: a rate that encoder steps do not drown. ``nan`` at
    gaps."""
    good = np.isfinite(y)
    if good.sum() < 3 or base_s <= 0:
        return np.full(len(t_s), np.nan)
    ahead = np.interp(t_s + base_s, t_s[good], y[good], right=np.nan)
    behind = np.interp(t_s - base_s, t_s[good], y[good], left=np.nan)
    slope = (ahead - behind) / (2 * base_s)
    slope[~good] = np.nan
    return np.asarray(slope)


def amplitude_spectrum(t_s: Floats, y: Floats, points: int = 4096) -> tuple[Floats, Floats]:
    """Frequencies in rad/s and amplitudes in the unit of ``y``, through a Hann window; gaps are interpolated.

    A sine of amplitude A stands as a peak of height A. Empty where fewer than 16 samples are known.
    """
    good = np.isfinite(y)
    if good.sum() < 16:
        return np.zeros(0), np.zeros(0)
    step = max(float(np.median(np.diff(t_s))), (t_s[-1] - t_s[0]) / points)
    even = np.arange(t_s[0], t_s[-1] + step / 2, step)
    values = np.interp(even, t_s[good], y[good])
    window = np.hanning(len(even))
    padded = 2 * len(even)
    amplitude = 2 * np.abs(np.fft.rfft((values - values.mean()) * window, padded)) / window.sum()
    return 2 * math.pi * np.arange(len(amplitude)) / (padded * step), np.asarray(amplitude)
