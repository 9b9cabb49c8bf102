"""Frames on a serial line: COBS with a zero delimiter around id, payload and CRC-16/CCITT-FALSE.

A packet is ``id`` (u16, little-endian), 0 to 8 payload bytes and the CRC (u16, little-endian) over both, COBS encoded
and ended by one zero byte. Noise of any kind costs at most the packets it touches: the next zero resynchronises.
"""

from __future__ import annotations

import binascii
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import overload

from cobs import cobs

from firmware_protocol.frame import Frame, ProtocolError

MAX_PAYLOAD = 8
MAX_ID = 0x7FF
_MIN_PACKET = 2 + 2
_MAX_PACKET = 2 + MAX_PAYLOAD + 2
MAX_ENCODED = _MAX_PACKET + 1  # COBS adds one byte up to 254; the delimiter comes on top


def crc16(data: bytes) -> int:
    """CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF, no reflection; "123456789" gives 0x29B1."""
    return binascii.crc_hqx(data, 0xFFFF)


def pack(frame: Frame) -> bytes:
    """A frame as the bytes of one packet, delimiter included.

    Raises:
        ProtocolError: the identifier has more than 11 bits or the payload more than 8 bytes.
    """
    if not 0 <= frame.id <= MAX_ID or len(frame.data) > MAX_PAYLOAD:
        raise ProtocolError(f"no frame of this protocol: id {frame.id:#x}, {len(frame.data)} bytes")
    body = frame.id.to_bytes(2, "little") + frame.data
    packet: bytes = cobs.encode(body + crc16(body).to_bytes(2, "little"))
    return packet + b"\0"


def pack_all(frames: Iterable[Frame]) -> bytes:
    """Several frames for one write. A leading zero closes whatever noise stands on the line before them."""
    if isinstance(frames, Packed):
        return frames.data if frames.data[:1] == b"\0" else b"\0" + frames.data
    return b"\0" + b"".join(map(pack, frames))


def unpack(packet: bytes) -> Frame:
    """The frame in one packet (without its delimiter).

    Raises:
        ProtocolError: not COBS, of an impossible length, or with a wrong CRC.
    """
    try:
        body = cobs.decode(packet)
    except cobs.DecodeError as error:
        raise ProtocolError(f"not COBS: {error}") from None
    if not _MIN_PACKET <= len(body) <= _MAX_PACKET:
        raise ProtocolError(f"{len(body)} bytes are no packet")
    if binascii.crc_hqx(body[:-2], 0xFFFF) != body[-2] | body[-1] << 8:
        raise ProtocolError("CRC does not agree")
    identifier = body[0] | body[1] << 8
    if identifier > MAX_ID:
        raise ProtocolError(f"identifier {identifier:#x} has more than 11 bits")
    return Frame(identifier, body[2:-2])


class Packed(Sequence[Frame]):
    """Frames as a serial line carries them; they are unpacked when somebody looks at them.

    Args:
        data: whole packets, none of them damaged.
        count: how many.
    """

    __slots__ = ("_count", "_frames", "data")

    def __init__(self, data: bytes, count: int) -> None:
        self.data = data
        self._count = count
        self._frames: list[Frame] | None = None

    def _unpacked(self) -> list[Frame]:
        if self._frames is None:
            self._frames = [unpack(packet) for packet in self.data.split(b"\0") if packet]
        return self._frames

    def __len__(self) -> int:
        return self._count

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and self._unpacked() == list(other)

    __hash__ = None  # type: ignore[assignment]  # as a list

    def __iter__(self) -> Iterator[Frame]:
        return iter(self._unpacked())

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | Sequence[Frame]:
        return self._unpacked()[index]


class StreamDecoder:
    """Cuts a byte stream into frames. Corrupt packets are counted and dropped; memory stays bounded."""

    def __init__(self) -> None:
        self.corrupt = 0
        self._pending = bytearray()
        self._overlong = False  # inside a run of bytes too long to be a packet: skip to its zero
        self._count: Callable[[bytes], int] | None = None

    def quicken(self) -> StreamDecoder:
        """From now on undamaged packets that come in one piece are looked over by compiled code. Returns itself."""
        # Brings the compiler in: only those who run a tick need it.
        from firmware_protocol.tick_kernels import count

        self._count = count
        return self

    def feed(self, data: bytes) -> Sequence[Frame]:
        """All frames that ``data`` completes, in order."""
        if self._count is not None and not (self._pending or self._overlong):
            whole = self._count(data)
            if whole > 0:
                return Packed(data, whole)
        frames: list[Frame] = []
        *complete, rest = data.split(b"\0")
        if complete and (self._pending or self._overlong):
            self._append(complete[0])
            complete[0] = bytes(self._pending)
            if self._overlong:
                self.corrupt += 1
            self._pending.clear()
            self._overlong = False
        for packet in complete:
            if not packet:
                continue
            try:
                frames.append(unpack(packet))
            except ProtocolError:
                self.corrupt += 1
        if rest:
            self._append(rest)
        return frames

    def _append(self, part: bytes) -> None:
        if self._overlong or len(self._pending) + len(part) > MAX_ENCODED:
            self._overlong = True
            self._pending.clear()
        else:
            self._pending += part
