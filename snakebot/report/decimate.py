"""Fewer points for the same picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Floats, Ints


def decimate(x: Floats, signals: Sequence[Floats], points: int) -> Ints:
    """Indices (sorted, at most about ``points``) that keep the lowest and highest sample of every signal a
    bucket.

    A gap (``nan``) that fills a whole bucket stays a gap.

    Args:
        x: (N,) common to all signals.
        signals: each (N,).
    """
    size = len(x)
    starts = bucket_starts(size, len(signals), points)
    if len(starts) >= size:
        return np.arange(size)
    edges = np.append(starts, size)
    keep = [np.array([0, size - 1])]
    bucket = np.repeat(np.arange(len(starts)), np.diff(edges))
    for signal in signals:
        known = np.isfinite(signal)
        for fill, ufunc in ((np.inf, np.minimum), (-np.inf, np.maximum)):
            filled = np.where(known, signal, fill)
            extreme = ufunc.reduceat(filled, starts)
            hits = np.flatnonzero((filled == extreme[bucket]) & known)
            _, first = np.unique(bucket[hits], return_index=True)
            keep.append(hits[first])
        keep.append(starts[np.add.reduceat(known, starts) == 0])
    return np.unique(np.concatenate(keep))


def bucket_starts(size: int, signals: int, points: int) -> Ints:
    """First sample of every bucket; one sample a bucket where nothing needs thinning."""
    if size <= points or signals == 0:
        return np.arange(size)
    return np.linspace(0, size, max(points // (2 * signals), 2) + 1).astype(np.int64)[:-1]


def bridge_short_gaps(y: Floats, longest: int) -> Floats:
    """``y`` with gaps of up to ``longest`` samples bridged: a thinned picture does not show them."""
    known = np.flatnonzero(np.isfinite(y))
    if longest < 1 or len(known) in (0, len(y)):
        return y
    out = y.copy()
    gap = np.diff(known)
    for start, length in zip(known[:-1][gap > 1], gap[gap > 1], strict=True):
        if length - 1 <= longest:
            out[start : start + length + 1] = np.linspace(y[start], y[start + length], length + 1)
    return out
