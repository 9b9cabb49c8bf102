"""Signals with known answers."""

from __future__ import annotations

import numpy as np

from snakebot.arrays import Floats


def times(duration_s: float = 20.0, rate_hz: float = 100.0, jitter_s: float = 0.0, seed: int = 0) -> Floats:
    t = np.arange(0, duration_s, 1 / rate_hz)
    return np.sort(t + np.random.default_rng(seed).uniform(-jitter_s, jitter_s, len(t)))


def rate_limited(t_s: Floats, y: Floats, limit: float) -> Floats:
    """``y`` through a slew rate limit: the output moves toward the input, never faster than ``limit`` a
    second."""
    out = np.empty_like(y)
    out[0] = y[0]
    for i in range(1, len(y)):
        most = limit * (t_s[i] - t_s[i - 1])
        out[i] = out[i - 1] + np.clip(y[i] - out[i - 1], -most, most)
    return out


def with_play(y: Floats, full_width: float) -> Floats:
    """``y`` through mechanical play of this full width."""
    out = np.empty_like(y)
    out[0] = y[0]
    for i in range(1, len(y)):
        out[i] = np.clip(out[i - 1], y[i] - full_width / 2, y[i] + full_width / 2)
    return out
