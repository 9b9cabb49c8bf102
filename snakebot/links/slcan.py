"""CAN frames as text on a serial line (slcan, LAWICEL): both ends' lines.

A frame is ``tIIIL`` and the payload in hexadecimal, ended by a carriage return. The adapter answers commands with a
carriage return, frames with ``z`` and one, and what it refuses with BEL.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from firmware_protocol.frame import Frame

END = b"\r"
REFUSED = b"\a"
_LONGEST = 142  # a CAN FD frame of 64 bytes with a 29-bit identifier
_LINE = re.compile(rb"[\r\a]")
_STANDARD = re.compile(rb"t([0-7][0-9A-Fa-f]{2})([0-8])((?:[0-9A-Fa-f]{2})*)")
_TIMESTAMP = 4  # digits that an adapter may add after the payload


def format_frame(frame: Frame) -> bytes:
    """A frame as one line."""
    return b"t%03X%d%s\r" % (frame.id, len(frame.data), frame.data.hex().upper().encode())


def format_all(frames: Iterable[Frame]) -> bytes:
    """Several frames for one write."""
    return b"".join(map(format_frame, frames))


def parse_frame(line: bytes) -> Frame | None:
    """The frame in a line that begins with ``t`` (without its end), or None when it is none."""
    match = _STANDARD.fullmatch(line)
    if match is None:
        return None
    length, digits = int(match[2]), match[3]
    if len(digits) not in (2 * length, 2 * length + _TIMESTAMP):
        return None
    return Frame(int(match[1], 16), bytes.fromhex(digits[: 2 * length].decode()))


class LineCutter:
    """Cuts a byte stream into lines, each with the byte that ended it. Memory stays bounded."""

    def __init__(self) -> None:
        self.overlong = 0
        self._pending = bytearray()

    def feed(self, data: bytes) -> list[tuple[bytes, bytes]]:
        """(line, end) of every line that ``data`` completes."""
        lines = []
        start = 0
        for end in _LINE.finditer(data):
            self._pending += data[start : end.start()]
            start = end.end()
            if len(self._pending) > _LONGEST:
                self.overlong += 1
            else:
                lines.append((bytes(self._pending), end[0]))
            self._pending.clear()
        self._pending += data[start:]
        if len(self._pending) > _LONGEST + 1:
            del self._pending[_LONGEST + 1 :]  # it stays overlong until its end comes
        return lines


class SlcanDecoder:
    """The host's side: frames out of what an adapter says.

    Remote, extended and CAN FD frames are other nodes' business and passed over. Refusals and broken lines are counted
    as corrupt.
    """

    def __init__(self) -> None:
        self.corrupt = 0
        self._cutter = LineCutter()

    def feed(self, data: bytes) -> list[Frame]:
        """All frames that ``data`` completes, in order."""
        frames = []
        overlong = self._cutter.overlong
        for line, end in self._cutter.feed(data):
            if end == REFUSED:
                self.corrupt += 1
            elif line.startswith(b"t"):
                frame = parse_frame(line)
                if frame is None:
                    self.corrupt += 1
                else:
                    frames.append(frame)
        self.corrupt += self._cutter.overlong - overlong
        return frames
