"""What the two packet formats have in common: a packet, and a decoder that cuts packets out of any bytes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar, NamedTuple

BROADCAST = 0xFE  # the id that every servo hears; the same in both protocols


class Packet(NamedTuple):
    """One packet of either direction, as it was before stuffing.

    ``code`` is the instruction of a packet to a servo. In an answer it is the error byte.
    """

    id: int
    code: int
    parameters: bytes


class PacketError(ValueError):
    """A packet that the format cannot carry (a fault of the caller)."""


class PacketDecoder(ABC):
    """Cuts a byte stream into packets. Whatever comes in, it goes on: what is no packet is skipped and counted.

    Args:
        longest: bytes of the longest packet that is looked for; a header that promises more is noise.
    """

    header: ClassVar[bytes]

    def __init__(self, longest: int) -> None:
        self.longest = longest
        self.corrupt = 0  # packets whose check did not agree, or whose length cannot be
        self._pending = bytearray()

    @property
    def pending(self) -> int:
        """Bytes that are kept: at most ``longest`` after a ``feed``."""
        return len(self._pending)

    def reset(self) -> None:
        """Forget the beginning of a packet: a new question has been asked."""
        self._pending.clear()

    def feed(self, data: bytes) -> list[Packet]:
        """All packets that are whole with these bytes."""
        pending = self._pending
        pending += data
        found: list[Packet] = []
        while True:
            start = pending.find(self.header)
            if start < 0:
                del pending[: max(0, len(pending) - len(self.header) + 1)]
                return found
            if start:
                del pending[:start]
            length = self._length()
            if length is None:
                return found
            if length > self.longest or length < 0:
                self._skip()
            elif len(pending) >= length:
                packet = self._packet(bytes(pending[:length]))
                if packet is None:
                    self._skip()
                else:
                    found.append(packet)
                    del pending[:length]
            else:
                return found

    def _skip(self) -> None:
        """This was no packet: look for the next header behind its first byte."""
        self.corrupt += 1
        del self._pending[0]

    @abstractmethod
    def _length(self) -> int | None:
        """Whole length of the packet that begins the buffer; None: not enough bytes yet; -1: it cannot be one."""

    @abstractmethod
    def _packet(self, raw: bytes) -> Packet | None:
        """The packet, or None where the check does not agree."""


class Dialect(ABC):
    """A packet format: instructions as bytes, answers out of bytes. No state, no wire."""

    name: ClassVar[str]

    @abstractmethod
    def ping(self, servo: int) -> bytes:
        """Are you there?"""

    @abstractmethod
    def read(self, servo: int, address: int, length: int) -> bytes:
        """Read so many bytes."""

    @abstractmethod
    def write(self, servo: int, address: int, data: bytes) -> bytes:
        """Write bytes; it is answered unless ``servo`` is ``BROADCAST``."""

    @abstractmethod
    def sync_read(self, servos: Sequence[int], address: int, length: int) -> bytes:
        """Read the same bytes of several servos; each answers with a packet of its own, in this order."""

    @abstractmethod
    def sync_write(self, address: int, data: Mapping[int, bytes]) -> bytes:
        """Write the same registers of several servos; nobody answers.

        Raises:
            PacketError: the pieces differ in length.
        """

    @abstractmethod
    def answer(self, servo: int, error: int, data: bytes) -> bytes:
        """What a servo answers."""

    @abstractmethod
    def answer_bytes(self, length: int) -> int:
        """Bytes of an answer that carries so many, without stuffing."""

    @abstractmethod
    def answers(self, longest: int) -> PacketDecoder:
        """A decoder for the host's side: ``code`` is the error, ``parameters`` the data."""

    @abstractmethod
    def instructions(self) -> PacketDecoder:
        """A decoder for the servo's side: ``code`` is the instruction."""


def same_length(data: Mapping[int, bytes]) -> int:
    """The one length of all pieces.

    Raises:
        PacketError: there is none, or they differ.
    """
    lengths = {len(piece) for piece in data.values()}
    if len(lengths) != 1:
        raise PacketError(f"a sync write of pieces of {sorted(lengths)} bytes")
    return lengths.pop()
