"""One pose as another program says it: a line of JSON with t (s), x, y (m) and heading (rad)."""

from __future__ import annotations

import math
from typing import NamedTuple

import orjson

MOST_BYTES = 2048  # of a datagram; chosen: a line of ours has less than 100
_FARTHEST_M = 1e5  # chosen: what is farther is damaged
_MOST_HEADING_RAD = 1e4  # chosen: headings may be unwrapped, over many turns
_LATEST_S = 1e12  # of the tracker's clock, whatever it counts from; chosen


class SaidPose(NamedTuple):
    """A pose with the time of the clock of whoever says it."""

    t_s: float
    x_m: float
    y_m: float
    heading_rad: float


def parse_pose(line: bytes) -> SaidPose | None:
    """The pose in a line; None where there is none. Keys beside the four are ignored. Never raises."""
    if len(line) > MOST_BYTES:
        return None
    try:
        said = orjson.loads(line)
    except ValueError:
        return None
    if not isinstance(said, dict):
        return None
    limits = {"t": _LATEST_S, "x": _FARTHEST_M, "y": _FARTHEST_M, "heading": _MOST_HEADING_RAD}
    values = []
    for key, limit in limits.items():
        value = said.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= limit:
            return None
        values.append(float(value))
    return SaidPose(*values) if all(map(math.isfinite, values)) else None


class Order:
    """Whether a pose is newer than those before, on the clock of whoever says it.

    A pose that says the same time again is none: whoever repeats his last word sees nothing any more. One that is a
    little older came late. A clock that goes back by more, or that is heard again after a silence, has been restarted.
    """

    RESTART_S = 1.0  # back by more than this is another clock; chosen

    def __init__(self) -> None:
        self._last_s: float | None = None

    def newer(self, t_s: float, *, after_silence: bool = False) -> bool:
        """Take in the time of a pose."""
        last = self._last_s
        good = last is None or t_s > last or (t_s != last and (after_silence or t_s < last - self.RESTART_S))
        if good:
            self._last_s = t_s
        return good
