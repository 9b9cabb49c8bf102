"""The board's end of a CAN bus that a host reaches through an slcan adapter on a pseudo-terminal."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.frame import Frame
from snakebot.links.slcan_adapter import SlcanAdapter
from snakebot.softboard.ends import PtyEnd

BITRATE = 1_000_000  # bit/s of the CAN bus that it plays: slcan S8


class SlcanEnd(PtyEnd):
    """A USB-CAN adapter that is not there, with this board on its bus; ``path`` is the adapter's device.

    Raises:
        NoBoardError: the system has no pseudo-terminal left.
    """

    def __init__(self) -> None:
        super().__init__()
        self.port = f"can:slcan/{self.path}?bitrate={BITRATE}"
        self.adapter = SlcanAdapter()

    def _pack(self, frames: Sequence[Frame]) -> bytes:
        return self.adapter.pack(frames)

    def _unpack(self, data: bytes) -> list[Frame]:
        frames = self.adapter.feed(data)
        self.statistics.corrupt = self.adapter.corrupt
        answer = self.adapter.answer()
        if answer:
            self._write(answer)
        return frames
