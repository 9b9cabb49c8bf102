"""Forward speed of the body from its recorded pose."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from snakebot.arrays import Floats


@dataclass(frozen=True)
class Speed:
    """Steady speed of the centre of mass along its mean heading, or, where no heading is known, along its way.

    ``scatter_m_s`` is the standard deviation from cycle to cycle, ``nan`` with fewer than two cycles;
    ``turn_rad_s`` is how fast the mean heading turns. Both ``lateral_m_s`` and that are ``nan`` without a heading.
    """

    forward_m_s: float
    lateral_m_s: float
    scatter_m_s: float
    turn_rad_s: float


def forward_speed(
    t_s: Floats, pose: Floats, start_s: float, end_s: float, period_s: float | None = None
) -> Speed | None:
    """Speed between two times, cycle by cycle where the motion has a period, so that the body's sway cancels.

    Args:
        t_s: times (N,).
        pose: x in m, y in m, heading in rad (N, 3), ``nan`` where not known.
        period_s: of the gait; ``None`` takes the window as one piece.

    Returns:
        ``None`` where fewer than two poses are known in the window.
    """
    headed = bool(np.isfinite(pose).all(axis=1).any())
    known = np.isfinite(pose if headed else pose[:, :2]).all(axis=1)
    if int((known & (t_s >= start_s - 1e-9) & (t_s <= end_s + 1e-9)).sum()) < 2:
        return None
    t = t_s[known]
    x, y = pose[known, 0], pose[known, 1]
    heading = np.unwrap(pose[known, 2]) if headed else np.full(t.size, np.nan)
    start, end = max(start_s, float(t[0])), min(end_s, float(t[-1]))
    pieces = max(1, round((end - start) / period_s)) if period_s else 1
    edges = np.linspace(start, end, pieces + 1)
    forward, lateral, headings = [], [], []
    for low, high in pairwise(edges):
        if not high > low:
            return None
        dx, dy = (float(np.diff(np.interp([low, high], t, axis))[0]) for axis in (x, y))
        if not headed:
            forward.append(math.hypot(dx, dy) / (high - low))
            continue
        mean = _mean_over(t, heading, low, high)
        forward.append((dx * math.cos(mean) + dy * math.sin(mean)) / (high - low))
        lateral.append((dy * math.cos(mean) - dx * math.sin(mean)) / (high - low))
        headings.append(mean)
    turn = (headings[-1] - headings[0]) / (edges[-2] - edges[0]) if pieces > 1 and headed else math.nan
    return Speed(
        forward_m_s=float(np.mean(forward)),
        lateral_m_s=float(np.mean(lateral)) if headed else math.nan,
        scatter_m_s=float(np.std(forward, ddof=1)) if pieces > 1 else math.nan,
        turn_rad_s=float(turn),
    )


def speed_error_percent(measured_m_s: float, predicted_m_s: float) -> float:
    """``100 (v_expt - v_pred) / v_pred`` (36); ``nan`` where nothing is predicted to move."""
    return 100 * (measured_m_s - predicted_m_s) / predicted_m_s if predicted_m_s else math.nan


def _mean_over(t_s: Floats, y: Floats, low: float, high: float) -> float:
    inside = (t_s > low) & (t_s < high)
    t = np.concatenate([[low], t_s[inside], [high]])
    return float(np.trapezoid(np.interp(t, t_s, y), t) / (high - low))
