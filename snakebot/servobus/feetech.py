"""Feetech's packets (SCS, STS, SMS servos): FF FF, id, length, instruction or error, parameters, inverted sum.

The check is one byte: a single damaged byte is always found, two pass once in 256. Whoever reads must know which id
and which length he waits for, and doubt a value that cannot be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from snakebot.servobus.packets import BROADCAST, Dialect, Packet, PacketDecoder, PacketError, same_length

# Instructions: Feetech's protocol manual.
PING = 0x01
READ = 0x02
WRITE = 0x03
SYNC_READ = 0x82
SYNC_WRITE = 0x83

HEADER = b"\xff\xff"
OVERHEAD = 6  # header, id, length, instruction or error, check
LONGEST = 0xFF + 4  # bytes of a packet: its length byte counts what comes behind it
_MOST_PARAMETERS = 0xFF - 2  # bytes: the length counts instruction and check, too


def pack(servo: int, code: int, parameters: bytes = b"") -> bytes:
    """One packet of either direction.

    Raises:
        PacketError: it is too long, or the id is none.
    """
    if len(parameters) > _MOST_PARAMETERS or not 0 <= servo <= BROADCAST:
        raise PacketError(f"id {servo} with {len(parameters)} bytes of parameters")
    body = bytes((servo, len(parameters) + 2, code)) + parameters
    return HEADER + body + bytes((~sum(body) & 0xFF,))


class FeetechDecoder(PacketDecoder):
    """Packets of either direction: the format does not tell them apart."""

    header = HEADER

    def _length(self) -> int | None:
        pending = self._pending
        if len(pending) < 4:
            # a third FF is a header that begins one byte later: no servo has that id
            return -1 if len(pending) > 2 and pending[2] == 0xFF else None
        if pending[2] == 0xFF or pending[3] < 2:
            return -1
        return pending[3] + 4

    def _packet(self, raw: bytes) -> Packet | None:
        if raw[-1] != ~sum(raw[2:-1]) & 0xFF:
            return None
        return Packet(raw[2], raw[4], raw[5:-1])


class Feetech(Dialect):
    """See the module."""

    name = "feetech"

    def ping(self, servo: int) -> bytes:
        return pack(servo, PING)

    def read(self, servo: int, address: int, length: int) -> bytes:
        return pack(servo, READ, bytes((address, length)))

    def write(self, servo: int, address: int, data: bytes) -> bytes:
        return pack(servo, WRITE, bytes((address,)) + data)

    def sync_read(self, servos: Sequence[int], address: int, length: int) -> bytes:
        return pack(BROADCAST, SYNC_READ, bytes((address, length, *servos)))

    def sync_write(self, address: int, data: Mapping[int, bytes]) -> bytes:
        pieces = b"".join(bytes((servo,)) + piece for servo, piece in data.items())
        return pack(BROADCAST, SYNC_WRITE, bytes((address, same_length(data))) + pieces)

    def answer(self, servo: int, error: int, data: bytes) -> bytes:
        return pack(servo, error, data)

    def answer_bytes(self, length: int) -> int:
        return OVERHEAD + length

    def answers(self, longest: int) -> PacketDecoder:
        return FeetechDecoder(min(longest, LONGEST))

    def instructions(self) -> PacketDecoder:
        return FeetechDecoder(LONGEST)
