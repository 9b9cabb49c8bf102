"""The set-points of a recorded run as a motion that can be sent again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from snakebot.errors import BadInputError
from snakebot.runlog.log import RunLog

Floats = NDArray[np.float64]

STEP_S = (
    0.001  # of the resampled set-points: finer than any tick, so that straight lines between them do not jerk
)
_EARLY = 0.02  # of a tick: rounding of a time on the tick's own instant


def recorded_setpoints(log: RunLog) -> tuple[Floats, Floats]:
    """Smooth set-points of the run: times (T,) from zero, angles (T, k), a cubic through the recorded ones.

    What was wanted before limits is taken: the limits of the robot that it is sent to apply anew. Times are those of
    the ticks for which the set-points were made, not of the (sometimes late) sending.

    Raises:
        BadInputError: fewer than two ticks, or servos that were off in between.
    """
    if log.t_s.size < 2:
        raise BadInputError(f"{log.path}: holds {log.t_s.size} ticks; nothing to replay")
    off = np.flatnonzero(np.isnan(log.setpoint_rad).any(axis=1))
    if off.size:
        raise BadInputError(
            f"{log.path}: servos were off at {log.t_s[off[0]]:.3f} s; such a run cannot be replayed"
        )
    t_s = _tick_times(log)
    spline = CubicSpline(t_s, log.setpoint_rad, axis=0)
    fine = np.append(np.arange(0.0, t_s[-1], STEP_S), t_s[-1])
    return fine, np.asarray(spline(fine), dtype=np.float64)


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
