"""The far end of an slcan line: a USB-CAN adapter that is not there, with a board on its bus."""

from __future__ import annotations

import re
from collections.abc import Iterable

from firmware_protocol.frame import Frame
from snakebot.links.slcan import END, REFUSED, LineCutter, format_all, parse_frame

_SETTINGS = re.compile(rb"S[0-9]|s[0-9A-Fa-f]{4}|Y[0-9]|M[0-9A-Fa-f]{8}|m[0-9A-Fa-f]{8}|W[0-9]|[XUQ][0-9]|")
_OTHER_FRAMES = re.compile(
    rb"r[0-7][0-9A-Fa-f]{2}[0-8]|R[0-9A-Fa-f]{8}[0-8]|T[0-9A-Fa-f]{8}[0-8](?:[0-9A-Fa-f]{2})*"
    rb"|[dDbB][0-9A-Fa-f]+"
)


class SlcanAdapter:
    """Takes what a host writes, gives what the adapter answers; no I/O.

    It speaks the LAWICEL command set as python-can, slcand and terminal users use it. Any bit rate is taken for the
    board's. A host that listens only (``L``) cannot send.
    """

    def __init__(self) -> None:
        self.corrupt = 0  # lines that are no command
        self._cutter = LineCutter()
        self._answer = bytearray()
        self._open = False
        self._listen_only = False

    @property
    def open(self) -> bool:
        """Whether the channel is open: frames pass."""
        return self._open

    def feed(self, data: bytes) -> list[Frame]:
        """Frames that the host puts on the bus; what it is answered comes out of ``answer``."""
        frames: list[Frame] = []
        overlong = self._cutter.overlong
        for line, end in self._cutter.feed(data):
            if end == END:
                self._obey(line.lstrip(b"\n"), frames)
        refused = self._cutter.overlong - overlong
        self.corrupt += refused
        self._answer += REFUSED * refused
        return frames

    def answer(self) -> bytes:
        """What the adapter has answered since the last call."""
        data = bytes(self._answer)
        self._answer.clear()
        return data

    def pack(self, frames: Iterable[Frame]) -> bytes:
        """Frames from the bus for the host: nothing while the channel is closed."""
        return format_all(frames) if self._open else b""

    def _obey(self, line: bytes, frames: list[Frame]) -> None:
        match line[:1]:
            case b"t":
                frame = parse_frame(line)
                if self._may_send(frame is not None, b"z") and frame is not None:
                    frames.append(frame)
            case b"r" | b"R" | b"T" | b"d" | b"D" | b"b" | b"B":  # on the bus, but not for the board
                self._may_send(_OTHER_FRAMES.fullmatch(line) is not None, b"Z" if line[0] in b"TR" else b"z")
            case b"O" | b"L" if len(line) == 1:
                self._open, self._listen_only = True, line == b"L"
                self._answer += END
            case b"C" if len(line) == 1:
                self._open = False
                self._answer += END
            case b"V" if len(line) == 1:
                self._answer += b"V1013\r"
            case b"N" if len(line) == 1:
                self._answer += b"NSIM1\r"
            case b"F" if len(line) == 1:
                self._answer += b"F00\r"
            case b"Z" if line in (b"Z0", b"Z1"):
                self._answer += END if line == b"Z0" else REFUSED  # no time stamps here
            case _ if _SETTINGS.fullmatch(line):
                self._answer += END
            case _:
                self.corrupt += 1
                self._answer += REFUSED

    def _may_send(self, valid: bool, sent: bytes) -> bool:
        if not valid:
            self.corrupt += 1
        accepted = valid and self._open and not self._listen_only
        self._answer += sent + END if accepted else REFUSED
        return accepted
