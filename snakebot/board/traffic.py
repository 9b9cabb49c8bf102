"""The last frames both ways: what to look at after a failure."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

from firmware_protocol.catalogue import decode
from firmware_protocol.frame import Frame, ProtocolError

_KEPT = 40  # frames that a failed run prints; chosen, a screen

FrameListener = Callable[[str, float, Frame], None]  # "tx" or "rx", host clock, frame


class Traffic:
    """Remembers frames, and shows each to a listener."""

    def __init__(self) -> None:
        self.on_frame: FrameListener | None = None
        self._passed: deque[tuple[str, float, Sequence[Frame]]] = deque(maxlen=_KEPT)  # none without a frame

    def note(self, direction: str, now_s: float, frames: Sequence[Frame]) -> None:
        """Frames have passed, "tx" or "rx"."""
        if frames:
            self._passed.append((direction, now_s, frames))
        if self.on_frame is not None:
            for frame in frames:
                self.on_frame(direction, now_s, frame)

    def lines(self) -> list[str]:
        """The last frames, decoded, oldest first."""
        lines = []
        passed = [(way, at_s, frame) for way, at_s, frames in self._passed for frame in frames]
        for direction, at_s, frame in passed[-_KEPT:]:
            try:
                text = str(decode(frame))
            except ProtocolError as error:
                text = f"unreadable: {error}"
            lines.append(f"{at_s:12.6f} {direction} {frame} {text}")
        return lines
