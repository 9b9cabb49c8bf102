"""Set-points between the rows of a log: held from row to row, unless they are known to have come faster."""

from __future__ import annotations

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.data import PreparedRun
from snakebot.diagnosis.sizes import LITTLE


def is_bridged(span_s: Floats, usual_s: float) -> Bools:
    """Whether set-points between two rows lie on a curve through them: not over a hole beside which the usual interval
    is little. Longer ones than ``repeats.MOST_BRIDGED``, which is for readings: set-points lie on a smooth curve.
    """
    return np.asarray(LITTLE * span_s < usual_s)


def row_s(run: PreparedRun) -> float:
    """Mean interval of the rows of a run's log, holes apart."""
    span = np.diff(run.t_s)
    return float(span[is_bridged(span, run.period_s)].mean())


def is_slow(run: PreparedRun) -> bool:
    """Whether there were set-points between the rows of this run's log, as far as is known."""
    return run.tick_s is not None and round(row_s(run) / run.tick_s) > 1


def set_points(run: PreparedRun) -> tuple[Floats, Floats]:
    """Times (M,) and set-points (M, k) of a run: those of its rows, and in a slow log those of a curve through them."""
    if run.tick_s is None or not is_slow(run):
        return run.t_s, run.command_rad
    span = np.diff(run.t_s)
    parts = np.where(is_bridged(span, row_s(run)), np.maximum(np.round(span / run.tick_s), 1), 1).astype(int)
    row = np.repeat(np.arange(span.size), parts)
    share = (np.arange(row.size) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[row]
    t_s = np.append(run.t_s[row] + share * span[row], run.t_s[-1])
    made = np.stack([_curve(run.t_s, column, t_s) for column in run.command_rad.T], axis=1)
    held = run.command_rad[np.append(row, span.size)]
    return t_s, np.where(np.isfinite(made) & np.isfinite(held), made, held)


def _curve(t_s: Floats, told: Floats, at_s: Floats) -> Floats:
    """A column (N,) at other times (M,), on a curve that keeps straight lines straight and does not overshoot steps
    (Akima 1970); nan beside rows without a command.
    """
    from scipy.interpolate import Akima1DInterpolator

    out = np.full(at_s.size, np.nan)
    known = np.isfinite(told).astype(int)
    edges = np.flatnonzero(np.diff(known, prepend=0, append=0))
    for first, end in zip(edges[::2], edges[1::2], strict=True):
        inside = (at_s >= t_s[first]) & (at_s <= t_s[end - 1])
        if end - first < 2:
            out[inside] = told[first]
        else:
            out[inside] = Akima1DInterpolator(t_s[first:end], told[first:end])(at_s[inside])
    return out
