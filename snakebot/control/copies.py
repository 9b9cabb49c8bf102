"""How often a set-point goes out at once, so that what a line loses does not starve the board's watchdog."""

from __future__ import annotations

import math

from firmware_protocol.assembly import groups
from snakebot.control.rate import MIN_RATE_HZ
from snakebot.errors import BadInputError

# The share of frames that may get lost: on any line, and on one that has just lost something. The latter is a little
# more than 1 % of the bytes damaged and 5 % of the frames dropped.
_ANY_LINE, _BAD_LINE = 0.01, 0.2
_REMEMBERED_S = 2.0  # a line counts as bad for this long after a loss
_CHANCE = 1e-6  # that the watchdog ends the run at a given tick
_MOST = 12  # of one set-point; chosen: at half loss one in 4,096 is then lost
# Of what the line carries, that set-points may fill: on a bus the board's answers, longer than a set-point, need the
# rest, and on a serial line it is the room to catch up after a disturbance.
SHARE_OF_LINE = 0.5


class Copies:
    """How many copies of each set-point of one run are sent.

    A tick is lost when one of its frames is lost in all copies: the board puts it together from frames of any. At 20 Hz
    one lost tick is enough for the watchdog, at 100 Hz it takes nine in a row. Whatever is wished for, no more is sent
    than the set-points' share of the line.

    Args:
        interval_s: between ticks.
        joints: of the robot; three go into a frame, and the latch is one more.
        line_frames_per_s: how many frames the line carries; infinity for one that limits nothing.
        watchdog_s: of the board: longest time without a set-point.
        where: how an error names the line.

    Attributes:
        wanted_on_a_bad_line: copies that a line would need that loses a fifth of its frames.
        most: copies that fit into the set-points' share of the line.

    Raises:
        BadInputError: not even what is sent on any line fits.
    """

    def __init__(
        self,
        interval_s: float,
        joints: int,
        line_frames_per_s: float,
        watchdog_s: float,
        where: str = "the line",
    ) -> None:
        frames = groups(joints) + 1
        ticks = ticks_to_trip(interval_s, watchdog_s)
        fitting = SHARE_OF_LINE * line_frames_per_s * interval_s / frames
        self.most = int(min(fitting + 1e-9, _MOST))
        self._usual = needed(_ANY_LINE, frames, ticks)
        if self._usual > self.most:
            sent = self._usual * frames / interval_s
            raise BadInputError(
                f"--rate {1 / interval_s:g}: set-points of {joints} joints take {sent:.0f} frames/s"
                f"{f' ({self._usual} copies of each)' if self._usual > 1 else ''}, and {where} carries "
                f"{line_frames_per_s:.0f}, of which they may have half: "
                + _advice(joints, line_frames_per_s, watchdog_s)
            )
        self.wanted_on_a_bad_line = needed(_BAD_LINE, frames, ticks)
        self._bad = min(self.most, self.wanted_on_a_bad_line)
        self._bad_until_s = -math.inf

    def lost(self, now_s: float) -> None:
        """Something got lost on the line."""
        self._bad_until_s = now_s + _REMEMBERED_S

    def number(self, now_s: float) -> int:
        """Copies of the set-point that is sent now."""
        return self._bad if now_s < self._bad_until_s else self._usual


def ticks_to_trip(interval_s: float, watchdog_s: float) -> int:
    """Ticks that must get lost in a row before the watchdog trips."""
    return max(1, math.ceil(watchdog_s / interval_s - 1e-9) - 1)


def needed(share: float, frames: int, ticks: int) -> int:
    """Copies of a tick of ``frames`` that make ``ticks`` lost ones in a row rare, if that share of frames is lost."""
    for copies in range(1, _MOST):
        tick_lost = 1 - (1 - share**copies) ** frames
        if tick_lost**ticks < _CHANCE:
            return copies
    return _MOST


def _advice(joints: int, line_frames_per_s: float, watchdog_s: float) -> str:
    """The highest rate that fits. A lower rate sends fewer ticks, and may need more copies of each."""
    frames = groups(joints) + 1
    for rate_hz in range(
        math.floor(SHARE_OF_LINE * line_frames_per_s / frames), math.ceil(MIN_RATE_HZ) - 1, -1
    ):
        copies = needed(_ANY_LINE, frames, ticks_to_trip(1 / rate_hz, watchdog_s))
        if copies * frames * rate_hz <= SHARE_OF_LINE * line_frames_per_s:
            return f"give {rate_hz} Hz or less, or a faster line"
    return "it needs a faster line"
