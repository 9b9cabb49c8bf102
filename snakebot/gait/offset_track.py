"""An offset that all joints have in common and that changes while the motion runs: how a gait is steered."""

from __future__ import annotations

import bisect
from typing import NamedTuple

import numpy as np

from snakebot.arrays import Floats

_KEPT = 64  # changes that are remembered; what came before them counts as one that was always there


class _Change(NamedTuple):
    start_s: float
    blend_s: float
    before_rad: float
    after_rad: float


class OffsetTrack:
    """Constant stretches joined by quintic blends; ``change`` appends one. Times are those of the motion.

    One thread changes it; others may read it at the same time: the changes are one tuple, which is replaced whole.
    """

    def __init__(self) -> None:
        self._changes: tuple[_Change, ...] = (_Change(-np.inf, 0.0, 0.0, 0.0),)

    @property
    def target_rad(self) -> float:
        """Where the last change leads."""
        return self._changes[-1].after_rad

    @property
    def settled_s(self) -> float:
        """From when on it stands still; minus infinity where it has never moved."""
        return self._changes[-1].start_s + self._changes[-1].blend_s

    def change(self, t_s: float, offset_rad: float, blend_s: float) -> None:
        """Go over to another offset from ``t_s`` on, within ``blend_s``.

        Raises:
            ValueError: the last change ends only after ``t_s``.
        """
        if t_s < self.settled_s:
            raise ValueError(f"the offset's last change ends only at {self.settled_s:g} s")
        new = _Change(t_s, blend_s, self.target_rad, offset_rad)
        self._changes = (*self._changes[-_KEPT + 1 :], new)

    def at(self, t_s: float) -> float:
        """The offset at one time, rad."""
        changes = self._changes
        number = bisect.bisect_right(changes, t_s, key=lambda change: change.start_s) - 1
        change = changes[max(number, 0)]
        if change.blend_s <= 0:
            return change.after_rad
        s = min(max((t_s - change.start_s) / change.blend_s, 0.0), 1.0)
        share = s * s * s * (10 + s * (-15 + 6 * s))
        return change.before_rad + share * (change.after_rad - change.before_rad)

    def sampled(self, t_s: Floats) -> Floats:
        """As ``at``, (T,)."""
        changes = self._changes
        starts = [change.start_s for change in changes]
        index = np.maximum(np.searchsorted(starts, t_s, side="right") - 1, 0)
        out = np.empty(len(t_s))
        for number, change in enumerate(changes):
            here = index == number
            if change.blend_s <= 0:
                out[here] = change.after_rad
            else:
                s = np.clip((t_s[here] - change.start_s) / change.blend_s, 0.0, 1.0)
                share = s * s * s * (10 + s * (-15 + 6 * s))
                out[here] = change.before_rad + share * (change.after_rad - change.before_rad)
        return out
