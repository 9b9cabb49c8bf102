"""How often a set-point goes out at once, so that what a line loses does not starve the board's watchdog."""

from __future__ import annotations

import math

from firmware_protocol.assembly import groups

_WATCHDOG_S = 0.100  # of the board: longest time without a set-point
# The share of frames that may get lost: on any line, and on one that has just lost something. The latter is a little
# more than 1 % of the bytes damaged and 5 % of the frames dropped.
_ANY_LINE, _BAD_LINE = 0.01, 0.2
_REMEMBERED_S = 2.0  # a line counts as bad for this long after a loss
_CHANCE = 1e-6  # that the watchdog ends the run at a given tick
_MOST = 12
_SHARE_OF_LINE = 0.6  # that set-points may fill


class Copies:
    """How many copies of each set-point of one run are sent.

    A tick is lost when one of its frames is lost in all copies: the board puts it together from frames of any. At 20 Hz
    one lost tick is enough for the watchdog, at 100 Hz it takes nine in a row.

    Args:
        interval_s: between ticks.
        joints: of the robot; three go into a frame, and the latch is one more.
        line_frames_per_s: how many frames the line carries.
    """

    def __init__(self, interval_s: float, joints: int, line_frames_per_s: float) -> None:
        frames = groups(joints) + 1
        afford = max(1, min(_MOST, int(_SHARE_OF_LINE * line_frames_per_s * interval_s / frames)))
        self._usual, self._bad = (
            min(afford, needed(share, frames, ticks_to_trip(interval_s))) for share in (_ANY_LINE, _BAD_LINE)
        )
        self._bad_until_s = -math.inf

    def lost(self, now_s: float) -> None:
        """Something got lost on the line."""
        self._bad_until_s = now_s + _REMEMBERED_S

    def number(self, now_s: float) -> int:
        """Copies of the set-point that is sent now."""
        return self._bad if now_s < self._bad_until_s else self._usual


def ticks_to_trip(interval_s: float) -> int:
    """Ticks that must get lost in a row before the watchdog trips."""
    return max(1, math.ceil(_WATCHDOG_S / interval_s - 1e-9) - 1)


def needed(share: float, frames: int, ticks: int) -> int:
    """Copies of a tick of ``frames`` that make ``ticks`` lost ones in a row rare, if that share of frames is lost."""
    for copies in range(1, _MOST):
        tick_lost = 1 - (1 - share**copies) ** frames
        if tick_lost**ticks < _CHANCE:
            return copies
    return _MOST
