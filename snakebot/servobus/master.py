"""The host's end of a servo bus: one question at a time, and what came back of it.

A lost or damaged answer is nothing special: it is asked for again while there is time, counted, and reported as
missing. Nothing here ends because of one; only a line that is gone raises.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from snakebot.errors import LostBoardError
from snakebot.links.capacity import BITS_OF_A_BYTE
from snakebot.links.stream import Stream
from snakebot.servobus.dynamixel import Dynamixel, fast_pieces, longest_stuffed
from snakebot.servobus.packets import BROADCAST, Dialect, Packet, PacketDecoder

TRIES = 4  # of a question within one tick
PATIENT_TRIES = 6  # of one that has no tick to keep
LATENCY_S = 0.02  # until it is measured: an adapter may hold an answer back for 16 ms
_PLAIN_QUESTIONS = 50  # after a fast sync read that nobody answered
_QUIET_READS = 64  # of bytes that nobody has asked for, before a question


@dataclass(slots=True)
class BusStatistics:
    """Counted since the bus was opened: questions and answers of single servos."""

    asked: int = 0
    answered: int = 0
    retried: int = 0  # asked again within the tick
    lost: int = 0  # never answered
    corrupt: int = 0  # packets that were damaged, or whose beginning came too late to be read
    unasked: int = 0  # sound packets that nobody waited for
    bytes_sent: int = 0
    bytes_received: int = 0

    @property
    def told(self) -> str:
        """One line."""
        return (
            f"{self.asked} questions, {self.retried} of them again, {self.lost} never answered, "
            f"{self.corrupt} answers damaged or too late"
        )


class BusMaster:
    """Questions to the servos on one line.

    Args:
        where: how messages name this bus.
        stream: the bytes.
        dialect: the packet format.
        baud: bit/s of the line; with it goes how long an answer may take.
        now_s: the clock that waits are counted on.
        fast: ask several Dynamixel servos with fast sync read; it is given up where nobody understands it.
    """

    def __init__(
        self,
        where: str,
        stream: Stream,
        dialect: Dialect,
        *,
        baud: int,
        now_s: Callable[[], float],
        fast: bool = True,
    ) -> None:
        self.where = where
        self.dialect = dialect
        self.baud = baud
        self.now_s = now_s
        self.latency_s = LATENCY_S
        self.statistics = BusStatistics()
        self.errors: dict[int, int] = {}  # error byte of the last answer of each servo
        self.asked_s = float("-inf")  # when the last instruction was written
        self._stream = stream
        self._fast = fast and isinstance(dialect, Dynamixel)
        self._plain = 0  # so many questions more are not asked with fast sync read

    def close(self) -> None:
        self._stream.close()

    def continue_on(self, stream: Stream) -> None:
        """Take another line in the place of one that is gone."""
        with contextlib.suppress(OSError):
            self._stream.close()
        self._stream = stream

    # -- one servo ---------------------------------------------------------------------------------------------------

    def ping(self, servo: int, tries: int = TRIES) -> bytes | None:
        """What a servo answers to a ping (Dynamixel: model number and firmware); None: nothing."""
        length = 3 if isinstance(self.dialect, Dynamixel) else 0
        return self._ask(self.dialect.ping(servo), servo, length, tries)

    def read(self, servo: int, address: int, length: int, tries: int = PATIENT_TRIES) -> bytes | None:
        """So many bytes of a servo; None: no answer."""
        return self._ask(self.dialect.read(servo, address, length), servo, length, tries)

    def write(self, servo: int, address: int, data: bytes, tries: int = PATIENT_TRIES) -> bool:
        """Write, and wait for the acknowledgement; ``errors`` has what it said. False: none came."""
        return self._ask(self.dialect.write(servo, address, data), servo, 0, tries) is not None

    def _ask(self, question: bytes, servo: int, length: int, tries: int) -> bytes | None:
        for attempt in range(tries):
            self.statistics.asked += 1
            self.statistics.retried += attempt > 0
            found = self._exchange(question, [servo], length)
            if servo in found:
                return found[servo]
        self.statistics.lost += 1
        return None

    # -- several servos ----------------------------------------------------------------------------------------------

    def sync_write(self, address: int, data: Mapping[int, bytes]) -> None:
        """Write the same registers of several servos at once. Nobody acknowledges it.

        Raises:
            LostBoardError: the line is gone.
        """
        self.say(self.dialect.sync_write(address, data))

    def say(self, packet: bytes) -> None:
        """Write a packet that nobody acknowledges.

        Raises:
            LostBoardError: the line is gone.
        """
        self._write(packet)

    def sync_read(
        self,
        servos: Sequence[int],
        address: int,
        length: int,
        *,
        until_s: float = float("inf"),
        in_turn: bool = False,
        tries: int = TRIES,
        latency_s: float | None = None,
    ) -> dict[int, bytes]:
        """The same bytes of several servos: of those that answered in time.

        Args:
            until_s: nothing is asked again after this time.
            in_turn: ask one after the other: they do not understand a question to several.
            latency_s: how long to wait, in place of what is usual on this line.

        Raises:
            LostBoardError: the line is gone.
        """
        found: dict[int, bytes] = {}
        missing = list(servos)
        for attempt in range(tries):
            if attempt:
                if self.now_s() >= until_s:
                    break
                self.statistics.retried += len(missing)
            self.statistics.asked += len(missing)
            if in_turn:
                for servo in missing:
                    question = self.dialect.read(servo, address, length)
                    found |= self._exchange(question, [servo], length, latency_s)
            else:
                fast = attempt == 0 and self._plain == 0
                question = self._question(missing, address, length, fast=fast)
                heard = self._exchange(question, missing, length, latency_s)
                # one packet for all is lost as one: a bad line, or a silent servo, is asked in the plain way
                self._plain = _PLAIN_QUESTIONS if fast and not heard else max(self._plain - 1, 0)
                found |= heard
            missing = [servo for servo in servos if servo not in found]
            if not missing:
                break
        self.statistics.lost += len(missing)
        return found

    def _question(self, servos: Sequence[int], address: int, length: int, *, fast: bool = True) -> bytes:
        if fast and self._fast and len(servos) > 1:
            assert isinstance(self.dialect, Dynamixel)
            return self.dialect.fast_sync_read(servos, address, length)
        return self.dialect.sync_read(servos, address, length)

    def try_fast(self, servos: Sequence[int], address: int, length: int) -> bool:
        """Whether all answer a fast sync read; where not, the bus is asked in the ordinary way from now on."""
        if self._fast and len(servos) > 1:
            self._fast = any(
                len(self._exchange(self._question(servos, address, length), servos, length)) == len(servos)
                for _ in range(PATIENT_TRIES)
            )
        return self._fast

    def answer_s(self, servos: int, length: int, question_bytes: int = 0) -> float:
        """How long so many answers of ``length`` bytes may take, from the writing of the question on."""
        bytes_ = question_bytes + servos * (self.dialect.answer_bytes(length) + longest_stuffed(length))
        return self.latency_s + bytes_ * BITS_OF_A_BYTE / self.baud

    # -- the wire ----------------------------------------------------------------------------------------------------

    def _exchange(
        self, question: bytes, servos: Sequence[int], length: int, latency_s: float | None = None
    ) -> dict[int, bytes]:
        """One question, and the data of those that answered it."""
        self._drain()
        one = self.dialect.answer_bytes(length) + longest_stuffed(length)
        longest = one * len(servos) if self._fast else one
        decoder = self.dialect.answers(longest)
        self._write(question)
        until_s = self.now_s() + self.answer_s(len(servos), length, len(question))
        if latency_s is not None:
            until_s += latency_s - self.latency_s
        found: dict[int, bytes] = {}
        awaited = set(servos)
        while awaited:
            data = self._read(max(until_s - self.now_s(), 0.0))
            if not data:
                break
            for packet in self._pieces(decoder, data, length):
                if packet.id in awaited and len(packet.parameters) == length:
                    awaited.discard(packet.id)
                    found[packet.id] = packet.parameters
                    self.errors[packet.id] = packet.code
                else:
                    self.statistics.unasked += 1
            if servos[-1] in found and len(servos) > 1:
                break  # they answer in order: who has not spoken by now will not
        self.statistics.answered += len(found)
        self.statistics.corrupt += decoder.corrupt
        return found

    def _pieces(self, decoder: PacketDecoder, data: bytes, length: int) -> Iterable[Packet]:
        for packet in decoder.feed(data):
            pieces = fast_pieces(packet.parameters, length) if packet.id == BROADCAST and self._fast else None
            if pieces is None:
                yield packet
            else:
                # the packet's own first parameter is the first piece's error
                yield from pieces

    def _drain(self) -> None:
        """Throw away what still comes of an earlier question: it would pass for the answer to this one."""
        for _ in range(_QUIET_READS):
            if not self._read(0.0):
                break

    def _write(self, data: bytes) -> None:
        try:
            self._stream.write(data)
        except OSError as error:
            raise self._lost(error) from None
        self.asked_s = self.now_s()
        self.statistics.bytes_sent += len(data)

    def _read(self, timeout_s: float) -> bytes:
        try:
            data = self._stream.read(timeout_s)
        except OSError as error:
            raise self._lost(error) from None
        self.statistics.bytes_received += len(data)
        return data

    def _lost(self, error: OSError) -> LostBoardError:
        reason = error.strerror or str(error)
        return LostBoardError(f"{self.where}: the line was lost: {reason}: check adapter, cable and supply")
