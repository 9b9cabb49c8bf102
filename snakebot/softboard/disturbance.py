"""A bad wire: bits flip, packets are lost, doubled, late, out of order and cut short, at set rates and from a seed.

``BadStream`` disturbs the bytes of a serial line (``InProcessLink`` takes it as ``to_board`` and ``to_host``, and
``tools/bad_wire.py`` stands between two real ports with it); ``BadBus`` disturbs CAN frames. Neither looks at what the
packets mean. ``BadPackets`` is for lines without delimiters.
"""

from __future__ import annotations

import heapq
import itertools
import random
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Generic, TypeVar

from firmware_protocol.frame import Frame
from snakebot.errors import BadInputError

Item = TypeVar("Item")
_ID_BITS = 11  # of a CAN identifier
_MAX_PACKET = 64  # bytes without a delimiter that are passed on as they are: this is no line of ours


@dataclass(frozen=True, slots=True)
class Rates:
    """How bad the wire is: probabilities, one draw a byte for ``flip`` and one a packet (or frame) for the others.

    Raises:
        BadInputError: a probability outside 0 to 1, or a delay that is negative or not a number.
    """

    flip: float = 0.0  # of a byte: one of its bits is turned over
    drop: float = 0.0
    duplicate: float = 0.0
    delay: float = 0.0  # held back by up to ``delay_s``
    reorder: float = 0.0  # changes places with the packet behind it
    truncate: float = 0.0  # loses its end, delimiter included
    delay_s: float = 0.02

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "delay_s" and not 0.0 <= value <= 1.0:
                raise BadInputError(f"{field.name} {value}: a probability is 0 to 1")
        if not 0.0 <= self.delay_s <= 60.0:
            raise BadInputError(f"delay_s {self.delay_s}: must be 0 to 60 s")


@dataclass(slots=True)
class Done:
    """What was done to the traffic so far: packets (``flipped``: bytes)."""

    passed: int = 0
    flipped: int = 0
    dropped: int = 0
    duplicated: int = 0
    delayed: int = 0
    reordered: int = 0
    truncated: int = 0


class _Late(Generic[Item]):
    """Items that are held back, given out when they are due."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, Item]] = []
        self._count = itertools.count()

    @property
    def due_s(self) -> float | None:
        return self._heap[0][0] if self._heap else None

    def keep(self, due_s: float, item: Item) -> None:
        heapq.heappush(self._heap, (due_s, next(self._count), item))

    def due(self, now_s: float) -> list[Item]:
        ready = []
        while self._heap and self._heap[0][0] <= now_s:
            ready.append(heapq.heappop(self._heap)[2])
        return ready


class _Disturbance(ABC, Generic[Item]):
    """What stream and bus have in common. A subclass says how an item is damaged."""

    def __init__(self, rates: Rates, seed: int, now_s: Callable[[], float]) -> None:
        self.rates = rates
        self.done = Done()
        self._random = random.Random(seed)
        self._now_s = now_s
        self._late: _Late[Item] = _Late()

    @property
    def due_s(self) -> float | None:
        """When the next late item is due, in the clock's time; None while nothing is held back."""
        return self._late.due_s

    @abstractmethod
    def _flip(self, item: Item) -> Item | None:
        """The item after the line's noise; None when nothing of it arrives."""

    @abstractmethod
    def _truncate(self, item: Item) -> Item | None:
        """The item without its end; None when nothing of it arrives."""

    def _hit(self, probability: float) -> bool:
        return probability > 0.0 and self._random.random() < probability

    def _disturb(self, items: Iterable[Item]) -> list[Item]:
        now_s = self._now_s()
        rates, done = self.rates, self.done
        out = self._late.due(now_s)
        for item in items:
            if self._hit(rates.drop):
                done.dropped += 1
                continue
            copies = 1
            if self._hit(rates.duplicate):
                done.duplicated += 1
                copies = 2
            for _ in range(copies):
                damaged = self._flip(item) if rates.flip > 0.0 else item
                if damaged is not None and self._hit(rates.truncate):
                    done.truncated += 1
                    damaged = self._truncate(damaged)
                if damaged is None:
                    continue
                if self._hit(rates.delay):
                    done.delayed += 1
                    self._late.keep(now_s + self._random.uniform(0.0, rates.delay_s), damaged)
                    continue
                out.append(damaged)
                if len(out) > 1 and self._hit(rates.reorder):
                    done.reordered += 1
                    out[-1], out[-2] = out[-2], out[-1]
        done.passed += len(out)
        return out

    def _damaged(self, data: bytes) -> bytes:
        """Each byte has one bit turned over with probability ``flip``."""
        flip = self.rates.flip
        draw = self._random.random
        hit = [index for index in range(len(data)) if draw() < flip]
        if not hit:
            return data
        self.done.flipped += len(hit)
        damaged = bytearray(data)
        for index in hit:
            damaged[index] ^= 1 << self._random.randrange(8)
        return bytes(damaged)


class BadStream(_Disturbance[bytes]):
    """One direction of a byte stream whose packets end with a delimiter (0 for COBS, carriage return for slcan).

    Args:
        rates: how bad it is.
        seed: the same traffic is disturbed in the same way each time.
        now_s: the clock that delays are counted on.
        delimiter: what ends a packet.
    """

    def __init__(self, rates: Rates, seed: int, now_s: Callable[[], float], delimiter: bytes = b"\0") -> None:
        super().__init__(rates, seed, now_s)
        self._delimiter = delimiter
        self._pending = b""

    def __call__(self, data: bytes) -> bytes:
        """What comes out of the far end now; call it with no bytes to collect what has been late."""
        *whole, self._pending = (self._pending + data).split(self._delimiter)
        packets = [packet + self._delimiter for packet in whole]
        if len(self._pending) > _MAX_PACKET:
            packets.append(self._pending)
            self._pending = b""
        return b"".join(self._disturb(packets))

    def _flip(self, item: bytes) -> bytes:
        return self._damaged(item)

    def _truncate(self, item: bytes) -> bytes:
        return item[: self._random.randrange(len(item))] if item else item


class BadPackets(_Disturbance[bytes]):
    """One direction of a line whose writer says where a packet ends, as on a servo bus. Arguments as ``BadStream``."""

    def __call__(self, packets: Sequence[bytes]) -> bytes:
        """What comes out of the far end now."""
        return b"".join(self._disturb(packets))

    def _flip(self, item: bytes) -> bytes:
        return self._damaged(item)

    def _truncate(self, item: bytes) -> bytes:
        return item[: self._random.randrange(len(item))] if item else item


class BadBus(_Disturbance[Frame]):
    """One direction of a CAN bus. A frame that was damaged is lost: the receiving controller's CRC-15 refuses it.

    Args:
        rates, seed, now_s: as for ``BadStream``.
        checked: False passes damaged frames on, as a gateway with a fault of its own would.
    """

    def __init__(self, rates: Rates, seed: int, now_s: Callable[[], float], *, checked: bool = True) -> None:
        super().__init__(rates, seed, now_s)
        self._checked = checked

    def __call__(self, frames: Sequence[Frame]) -> list[Frame]:
        """What comes out of the far end now."""
        return self._disturb(frames)

    def _flip(self, item: Frame) -> Frame | None:
        identifier = item.id
        if self._hit(self.rates.flip):
            self.done.flipped += 1
            identifier ^= 1 << self._random.randrange(_ID_BITS)
        damaged = Frame(identifier, self._damaged(item.data))
        return damaged if damaged == item or not self._checked else None

    def _truncate(self, item: Frame) -> Frame | None:
        if self._checked or not item.data:
            return None
        return Frame(item.id, item.data[: self._random.randrange(len(item.data))])
