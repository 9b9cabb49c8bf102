"""Play and rate limit as operators on a sampled motion, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit


@njit(cache=True)
def play(x: Any, half_width: float) -> Any:
    """Output of a play of this half width that starts in its middle."""
    out = np.empty_like(x)
    y = x[0]
    for i in range(x.size):
        y = min(max(y, x[i] - half_width), x[i] + half_width)
        out[i] = y
    return out


@njit(cache=True)
def limited(t: Any, x: Any, rate: float) -> Any:
    """``x`` followed at no more than ``rate``."""
    out = np.empty_like(x)
    y = x[0]
    out[0] = y
    for i in range(1, x.size):
        most = rate * (t[i] - t[i - 1])
        y += min(max(x[i] - y, -most), most)
        out[i] = y
    return out
