"""What must hold of every link, whatever carries its frames. Each test class that inherits this names one carrier."""

from __future__ import annotations

import random
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest

from firmware_protocol.catalogue import database
from firmware_protocol.frame import Frame
from snakebot.errors import LostBoardError, NoBoardError
from snakebot.links import Link, open_link, parse_port

# On a bus that hands back one's own frames a side takes only what the other side sends.
FROM_HOST = sorted(message.frame_id for message in database().messages if "Host" in message.senders)
FROM_BOARD = sorted(message.frame_id for message in database().messages if "Board" in message.senders)
LONG_S = 60.0  # a wait that must not last: the time limit of the suite would end it
PATIENCE_S = 5.0
TICKS = 150


@dataclass
class Wire:
    """A link under test, its far end, and a way to cut what is between them (None: such a wire has no end)."""

    host: Link
    board: Link
    cut: Callable[[], None] | None = None


def frames_of(ids: list[int], count: int, seed: int = 1) -> list[Frame]:
    """Frames of every length, with zeros and all other bytes."""
    noise = random.Random(seed)
    return [Frame(noise.choice(ids), noise.randbytes(k % 9)) for k in range(count - 1)] + [
        Frame(ids[0], bytes(8))
    ]


def collect(link: Link, count: int) -> list[Frame]:
    """At least ``count`` frames, or what has come when none comes any more."""
    received: list[Frame] = []
    while len(received) < count:
        more = link.receive(PATIENCE_S)
        if not more:
            break
        received += more
    return received


def send_often(link: Link, frames: list[Frame]) -> None:
    """Send a thousand times."""
    for _ in range(1000):
        link.send(frames)


class LinkContract(ABC):
    """Inherit, and give a fixture ``wire``. ``exclusive`` where a port can be had by one program alone."""

    exclusive = False

    @pytest.fixture
    @abstractmethod
    def wire(self) -> Iterator[Wire]:
        """A wire of this carrier, taken down at the end."""

    def test_frames_arrive_as_they_were_sent_each_way(self, wire: Wire) -> None:
        out, back = frames_of(FROM_HOST, 18), frames_of(FROM_BOARD, 18, seed=2)
        wire.host.send(out)
        assert collect(wire.board, len(out)) == out
        wire.board.send(back)
        assert collect(wire.host, len(back)) == back

    def test_ticks_of_frames_none_lost_none_doubled(self, wire: Wire) -> None:
        for tick in range(TICKS):
            out, back = frames_of(FROM_HOST, 7, tick), frames_of(FROM_BOARD, 13, tick)
            wire.host.send(out)
            assert collect(wire.board, len(out)) == out
            wire.board.send(back)
            assert collect(wire.host, len(back)) == back
        assert wire.host.statistics.sent == TICKS * 7
        assert wire.host.statistics.received == TICKS * 13
        assert wire.host.statistics.corrupt == 0
        assert wire.host.statistics.bytes_sent > TICKS * 7
        assert wire.host.statistics.bytes_received > TICKS * 13

    def test_nothing_comes_of_nothing(self, wire: Wire) -> None:
        assert wire.host.receive(0.0) == []
        assert wire.host.receive(0.02) == []
        assert wire.host.receive(-1.0) == []
        wire.host.send([])
        assert wire.board.receive(0.02) == []
        assert wire.host.statistics.sent == wire.host.statistics.received == 0

    def test_own_frames_do_not_come_back(self, wire: Wire) -> None:
        wire.host.send(frames_of(FROM_HOST, 5))
        assert wire.host.receive(0.05) == []

    def test_a_wait_ends_with_the_first_frame(self, wire: Wire) -> None:
        wire.board.send([Frame(FROM_BOARD[0], b"now")])
        assert wire.host.receive(LONG_S) == [Frame(FROM_BOARD[0], b"now")]

    def test_what_waits_comes_in_one_go(self, wire: Wire) -> None:
        back = frames_of(FROM_BOARD, 9)
        wire.board.send(back[:4])
        wire.board.send(back[4:])
        received = [*wire.host.receive(LONG_S)]
        if len(received) < len(back):  # still on its way
            received += collect(wire.host, len(back) - len(received))
        assert received == back

    def test_a_closed_link_says_so_and_closes_twice(self, wire: Wire) -> None:
        wire.host.close()
        wire.host.close()
        with pytest.raises(LostBoardError) as caught:
            wire.host.receive(LONG_S)
        assert str(caught.value).startswith(wire.host.port)
        with pytest.raises(LostBoardError):
            wire.host.send([Frame(FROM_HOST[0], b"")])

    def test_it_closes_at_the_end_of_a_with(self, wire: Wire) -> None:
        with wire.host as link:
            assert link is wire.host
        with pytest.raises(LostBoardError):
            wire.host.receive(0.0)

    def test_a_cut_wire_ends_a_wait_and_a_send(self, wire: Wire) -> None:
        if wire.cut is None:
            wire.board.close()
            wire.host.send([Frame(FROM_HOST[0], b"")])
            assert wire.host.receive(0.02) == []  # a bus has no end: who has gone is silent
            return
        wire.cut()
        with pytest.raises(LostBoardError) as caught:
            wire.host.receive(LONG_S)
        assert "\n" not in str(caught.value)
        assert str(caught.value).startswith(wire.host.port)
        with pytest.raises(LostBoardError):
            send_often(wire.host, [Frame(FROM_HOST[0], b"")])  # TCP notices with the second
        wire.host.close()

    def test_a_wire_cut_in_mid_wait_ends_the_wait(self, wire: Wire) -> None:
        if wire.cut is None:
            pytest.skip("a bus has no end")
        cutter = threading.Timer(0.05, wire.cut)
        cutter.start()
        with pytest.raises(LostBoardError):
            wire.host.receive(LONG_S)
        cutter.join()

    def test_its_port_is_in_the_grammar(self, wire: Wire) -> None:
        assert str(parse_port(wire.host.port)) == wire.host.port

    def test_a_port_that_is_taken_says_so(self, wire: Wire) -> None:
        if not self.exclusive:
            pytest.skip("may be opened more than once")
        with pytest.raises(NoBoardError, match="in use"):
            open_link(wire.host.port)
        wire.host.send([Frame(FROM_HOST[0], b"still")])  # and who has it is not disturbed
        assert collect(wire.board, 1) == [Frame(FROM_HOST[0], b"still")]
        wire.host.close()
        open_link(wire.host.port).close()
