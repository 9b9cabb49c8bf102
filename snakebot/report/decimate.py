"""Fewer points for the same picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def decimate(
    x: NDArray[np.float64], signals: Sequence[NDArray[np.float64]], points: int
) -> NDArray[np.int64]:
    """Indices (sorted, at most about ``points``) that keep the lowest and highest sample of every signal a
    bucket.

    A gap (``nan``) stays a gap: a bucket that holds one keeps its first sample of it.

    Args:
        x: (N,) common to all signals.
        signals: each (N,).
    """
    size = len(x)
    if size <= points or not signals:
        return np.arange(size)
    per_bucket = 3 * len(signals)
    edges = np.linspace(0, size, max(points // per_bucket, 2) + 1).astype(np.int64)
    starts = edges[:-1]
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
        gaps = np.flatnonzero(~known)
        _, first = np.unique(bucket[gaps], return_index=True)
        keep.append(gaps[first])
    return np.unique(np.concatenate(keep))
