"""Dynamixel protocol 2.0: FF FF FD 00, id, 16-bit length, instruction, parameters, CRC-16 (polynomial 0x8005).

Inside a packet FF FF FD is followed by one more FD (stuffing), so a header never occurs there. An answer has the
instruction 0x55 and an error byte in front of its data; its top bit (alert) says that register 70 has more to say.

The answers to a fast sync read are one packet: each servo adds its piece, and a CRC over all that came before it. It is
not stuffed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from snakebot.servobus.packets import BROADCAST, Dialect, Packet, PacketDecoder, PacketError, same_length

# Instructions, and below the numbers of errors: ROBOTIS e-Manual, Protocol 2.0.
PING = 0x01
READ = 0x02
WRITE = 0x03
REBOOT = 0x08
STATUS = 0x55
SYNC_READ = 0x82
SYNC_WRITE = 0x83
FAST_SYNC_READ = 0x8A

ALERT = 0x80  # of the error byte: the servo's hardware error register is not zero
ERROR_RANGE, ERROR_LIMIT, ERROR_ACCESS = 4, 6, 7  # the other seven bits

HEADER = b"\xff\xff\xfd\x00"
LONGEST = 1024  # bytes of a packet; the vendor's own limit
_BEFORE_LENGTH = 7  # header, id, length
_SHORTEST = 3  # of the length: instruction and CRC
_STUFFED = b"\xff\xff\xfd"


def _crc_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ (0x8005 if crc & 0x8000 else 0)
        table.append(crc & 0xFFFF)
    return tuple(table)


_CRC_TABLE = _crc_table()


def crc16(data: bytes, crc: int = 0) -> int:
    """CRC-16/UMTS (polynomial 0x8005, start 0, not reflected), going on from ``crc``."""
    table = _CRC_TABLE
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ table[crc >> 8 ^ byte]
    return crc


def stuff(body: bytes) -> bytes:
    """Instruction and parameters with one FD more behind each FF FF FD."""
    return body.replace(_STUFFED, _STUFFED + b"\xfd") if _STUFFED in body else body


def unstuff(body: bytes) -> bytes:
    """The inverse of ``stuff``; what no packet can hold is left as it is."""
    return body.replace(_STUFFED + b"\xfd", _STUFFED) if _STUFFED in body else body


def pack(servo: int, instruction: int, parameters: bytes = b"") -> bytes:
    """One packet of either direction.

    Raises:
        PacketError: it is too long, or the id is none.
    """
    return _closed(servo, stuff(bytes((instruction,)) + parameters))


def _closed(servo: int, body: bytes) -> bytes:
    if not 0 <= servo <= BROADCAST or len(body) + 9 > LONGEST:
        raise PacketError(f"id {servo} with {len(body)} bytes")
    raw = HEADER + bytes((servo,)) + (len(body) + 2).to_bytes(2, "little") + body
    return raw + crc16(raw).to_bytes(2, "little")


def fast_answer(pieces: Sequence[tuple[int, int, bytes]]) -> bytes:
    """What several servos answer to one fast sync read: (id, error, data) of each."""
    length = 1 + sum(len(data) + 4 for _, _, data in pieces)
    raw = HEADER + bytes((BROADCAST,)) + length.to_bytes(2, "little") + bytes((STATUS,))
    for servo, error, data in pieces:
        raw += bytes((error, servo)) + data
        raw += crc16(raw).to_bytes(2, "little")
    return raw


def fast_pieces(parameters: bytes, length: int) -> list[Packet] | None:
    """The answers in the one packet of a fast sync read, each with ``length`` bytes of data; None: it is not that.

    Args:
        parameters: all between instruction and the last CRC.
    """
    size = length + 4  # error, id, data, CRC; the last CRC is the packet's own
    count, rest = divmod(len(parameters) + 2, size)
    if rest or not count:
        return None
    starts = range(0, count * size, size)
    return [Packet(parameters[at + 1], parameters[at], parameters[at + 2 : at + 2 + length]) for at in starts]


class DynamixelDecoder(PacketDecoder):
    """Packets of either direction; ``code`` is the instruction, an error stands first in the parameters."""

    header = HEADER

    def _length(self) -> int | None:
        pending = self._pending
        if len(pending) < _BEFORE_LENGTH:
            return None
        length = pending[5] | pending[6] << 8
        if length < _SHORTEST:
            return -1
        whole = length + _BEFORE_LENGTH
        if len(pending) < whole and not self._fast() and pending.find(HEADER, 1) > 0:
            return -1  # another packet begins where this one should go on: its length is damaged
        return whole

    def _fast(self) -> bool:
        """The pending packet answers a fast sync read: nothing in it is stuffed, so it may hold a header."""
        pending = self._pending
        return pending[4] == BROADCAST and (len(pending) <= _BEFORE_LENGTH or pending[7] == STATUS)

    def _packet(self, raw: bytes) -> Packet | None:
        if crc16(raw[:-2]) != int.from_bytes(raw[-2:], "little"):
            return None
        body = raw[_BEFORE_LENGTH:-2]
        if not (raw[4] == BROADCAST and body[0] == STATUS):
            body = unstuff(body)
        return Packet(raw[4], body[0], body[1:])


class DynamixelAnswers(DynamixelDecoder):
    """Answers only: ``code`` is the error, ``parameters`` the data.

    The packet of a fast sync read comes out as one with the id ``BROADCAST``; ``fast_pieces`` cuts it.
    """

    def _packet(self, raw: bytes) -> Packet | None:
        packet = super()._packet(raw)
        if packet is None or packet.code != STATUS or not packet.parameters:
            return None
        if packet.id == BROADCAST:
            return packet
        return Packet(packet.id, packet.parameters[0], packet.parameters[1:])


class Dynamixel(Dialect):
    """See the module."""

    name = "dynamixel"

    def ping(self, servo: int) -> bytes:
        return pack(servo, PING)

    def read(self, servo: int, address: int, length: int) -> bytes:
        return pack(servo, READ, _words(address, length))

    def write(self, servo: int, address: int, data: bytes) -> bytes:
        return pack(servo, WRITE, _words(address) + data)

    def sync_read(self, servos: Sequence[int], address: int, length: int) -> bytes:
        return pack(BROADCAST, SYNC_READ, _words(address, length) + bytes(servos))

    def fast_sync_read(self, servos: Sequence[int], address: int, length: int) -> bytes:
        """As ``sync_read``; all answer in one packet, which takes 7 bytes a servo less."""
        return pack(BROADCAST, FAST_SYNC_READ, _words(address, length) + bytes(servos))

    def sync_write(self, address: int, data: Mapping[int, bytes]) -> bytes:
        pieces = b"".join(bytes((servo,)) + piece for servo, piece in data.items())
        return pack(BROADCAST, SYNC_WRITE, _words(address, same_length(data)) + pieces)

    def reboot(self, servo: int) -> bytes:
        """Start again: the only way out of a hardware error."""
        return pack(servo, REBOOT)

    def answer(self, servo: int, error: int, data: bytes) -> bytes:
        return pack(servo, STATUS, bytes((error,)) + data)

    def answer_bytes(self, length: int) -> int:
        return 11 + length

    def answers(self, longest: int) -> PacketDecoder:
        return DynamixelAnswers(min(longest, LONGEST))

    def instructions(self) -> PacketDecoder:
        return DynamixelDecoder(LONGEST)


def _words(*values: int) -> bytes:
    return b"".join(value.to_bytes(2, "little") for value in values)


def longest_stuffed(length: int) -> int:
    """By how many bytes stuffing can lengthen so many."""
    return length // 3
