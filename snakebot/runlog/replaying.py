"""The set-points of a recorded run as a motion that can be sent again."""

from __future__ import annotations

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.runlog.log import RunLog

MOST_GAP_S = 0.5  # between two set-points: five times what a board's watchdog lets pass in a run
_EARLY = 0.02  # of a tick: rounding of a time on the tick's own instant


def recorded_setpoints(log: RunLog) -> tuple[Floats, Floats]:
    """Set-points of the run: times (N,) from zero, angles (N, k).

    What was wanted before limits is taken: the limits of the robot that it is sent to apply anew. Times are those of
    the ticks for which the set-points were made, not of the (sometimes late) sending.

    Raises:
        BadInputError: fewer than two ticks, servos that were off in between, or a gap: what the joints were to do
            there, nobody knows.
    """
    if log.t_s.size < 2:
        raise BadInputError(f"{log.path}: holds {log.t_s.size} ticks; nothing to replay")
    off = np.flatnonzero(np.isnan(log.setpoint_rad).any(axis=1))
    if off.size:
        raise BadInputError(
            f"{log.path}: servos were off at {log.t_s[off[0]]:.3f} s; such a run cannot be replayed"
        )
    gaps = np.flatnonzero(np.diff(log.t_s) > MOST_GAP_S)
    if gaps.size:
        before_s, after_s = log.t_s[gaps[0] : gaps[0] + 2]
        raise BadInputError(
            f"{log.path}: no set-points between {before_s:.3f} and {after_s:.3f} s ({after_s - before_s:.3g} s; "
            f"at most {MOST_GAP_S:g} s can be bridged): export the log as a table, cut it at the gap, import the parts"
        )
    return _tick_times(log), log.setpoint_rad


def _tick_times(log: RunLog) -> Floats:
    """Times from zero at which the set-points were due: on the grid of the rate, where the log names one."""
    rate_hz = log.number("rate_hz")
    if rate_hz is not None and rate_hz > 0:
        ticks = np.floor(log.t_s * rate_hz + _EARLY)
        if np.all(np.diff(ticks) > 0):
            return np.asarray((ticks - ticks[0]) / rate_hz, dtype=np.float64)
    if not np.all(np.diff(log.t_s) > 0):
        raise BadInputError(f"{log.path}: two ticks at one time; cannot be replayed")
    return np.asarray(log.t_s - log.t_s[0], dtype=np.float64)
