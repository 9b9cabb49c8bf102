"""How well the link and the host's clock did: delay, jitter, loss, late ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Bools, Floats


@dataclass(frozen=True)
class LinkQuality:
    """Timing of one run. Delays are ``nan``, and late ticks ``None``, where the run did not record them.

    ``latency_*``: from a set-point sent to its encoder reading back. ``delay_to_board_s``: by how much the
    set-points that the board executed trail those commanded, from the two signals alone. ``jitter_*``:
    departure of the ticks from an even beat of ``period_s``. ``lost``: share of encoder samples that never
    came.
    """

    ticks: int
    period_s: float
    jitter_std_s: float
    jitter_p99_s: float
    lost: float
    late_ticks: int | None
    latency_median_s: float
    latency_p99_s: float
    latency_max_s: float
    delay_to_board_s: float


def link_quality(
    t_s: Floats,
    measured_rad: Floats,
    command_rad: Floats | None = None,
    applied_rad: Floats | None = None,
    latency_s: Floats | None = None,
    late: Bools | Floats | None = None,
) -> LinkQuality:
    """Timing of a run of N ticks; angles are (N, k), the rest (N,), ``nan`` where unknown."""
    steps = np.diff(t_s)
    period = float(np.median(steps)) if len(steps) else math.nan
    # A missing tick is a loss, not jitter: only whole beats are compared.
    beats = np.maximum(np.round(steps / period), 1) if len(steps) and period > 0 else np.zeros(0)
    departure = np.abs(steps - beats * period)
    known = latency_s[np.isfinite(latency_s)] if latency_s is not None else np.zeros(0)
    return LinkQuality(
        ticks=len(t_s),
        period_s=period,
        jitter_std_s=float(np.sqrt(np.mean(departure**2))) if len(departure) else math.nan,
        jitter_p99_s=float(np.percentile(departure, 99)) if len(departure) else math.nan,
        lost=float(np.mean(~np.isfinite(measured_rad))) if measured_rad.size else math.nan,
        late_ticks=int(np.nansum(np.asarray(late, dtype=np.float64) > 0)) if late is not None else None,
        latency_median_s=float(np.median(known)) if len(known) else math.nan,
        latency_p99_s=float(np.percentile(known, 99)) if len(known) else math.nan,
        latency_max_s=float(np.max(known)) if len(known) else math.nan,
        delay_to_board_s=_delay(t_s, command_rad, applied_rad),
    )


def _delay(t_s: Floats, command_rad: Floats | None, applied_rad: Floats | None) -> float:
    if command_rad is None or applied_rad is None:
        return math.nan
    from snakebot.runlog.matching.shift import (
        find_shift,  # here, because most runs have no applied set-points
    )

    found = find_shift(t_s, command_rad, t_s, applied_rad, most_s=0.5)
    return found.shift_s if found is not None else math.nan
