"""The blend of all ramps and changes, the quintic 10 s^3 - 15 s^4 + 6 s^5, and its integral.

Position, velocity and acceleration are continuous at both ends.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from snakebot.arrays import Floats

# Largest slope and curvature of the quintic over the unit interval.
BLEND_PEAK_SLOPE = 15 / 8
BLEND_PEAK_CURVATURE = 10 / math.sqrt(3)  # of s^3 (10 - 15 s + 6 s^2) on 0..1, at s = 1/2 -+ 1/sqrt(12)


def blend(s: float) -> float:
    """The quintic step from 0 to 1; constant outside."""
    return float(_step(min(max(s, 0.0), 1.0)))


def blends(s: Floats) -> Floats:
    """``blend`` of each."""
    found: Floats = _step(np.clip(s, 0.0, 1.0))
    return found


def blend_integral(s: float) -> float:
    """Integral of ``blend`` from 0 to s."""
    return float(_area(min(max(s, 0.0), 1.0))) + max(s - 1.0, 0.0)


def blend_integrals(s: Floats) -> Floats:
    """``blend_integral`` of each."""
    found: Floats = _area(np.clip(s, 0.0, 1.0)) + np.maximum(s - 1.0, 0.0)
    return found


def _step(c: Any) -> Any:
    """The quintic over the unit interval, of a number or an array."""
    return c * c * c * (10 + c * (-15 + 6 * c))


def _area(c: Any) -> Any:
    """Its integral from 0, of a number or an array."""
    return c**4 * (2.5 + c * (-3 + c))
