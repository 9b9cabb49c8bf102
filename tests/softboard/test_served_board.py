"""A board on a real wire, and hosts that come and go."""

from __future__ import annotations

import math
import os
import select
import socket
import termios
import threading
import time
import tty
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import pytest
from board_rig import HOST, OTHER, M, StillPlant, bench

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import (
    Acknowledge,
    BoardHeartbeat,
    ClearRequest,
    Counters,
    EmergencyStop,
    Fault,
    FaultEvent,
    Latch,
    Message,
    Mode,
    ModeRequest,
    Ping,
    Pong,
    Result,
    Setpoint,
    State,
    decode,
    encode,
)
from firmware_protocol.frame import Frame
from firmware_protocol.framing import StreamDecoder, pack_all
from snakebot.clock import MonotonicClock
from snakebot.errors import LostBoardError, NoBoardError
from snakebot.links.base import Link
from snakebot.softboard import PtyEnd, SoftBoard, TcpEnd, serve

PATIENCE_S = 20.0


@contextmanager
def served(end: Link) -> Iterator[SoftBoard]:
    board = SoftBoard(bench(), plant=StillPlant(5))
    stop = threading.Event()
    thread = threading.Thread(target=serve, args=(board, end, MonotonicClock(), stop))
    thread.start()
    try:
        yield board
    finally:
        stop.set()
        thread.join(PATIENCE_S)
        assert not thread.is_alive()
        end.close()
        end.close()


class Host:
    """A host's end of the wire, by hand."""

    def __init__(self, end: Link) -> None:
        self._socket: socket.socket | None = None
        if isinstance(end, PtyEnd):
            self.fd = os.open(end.path, os.O_RDWR | os.O_NOCTTY)
            tty.setraw(self.fd)
            termios.tcflush(self.fd, termios.TCIOFLUSH)
        else:
            assert isinstance(end, TcpEnd)
            self._socket = socket.create_connection(end.address)
            self.fd = self._socket.fileno()
        self._decoder = StreamDecoder()
        self.heard: list[Message] = []

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
        else:
            os.close(self.fd)

    def say(self, *messages: Message) -> None:
        os.write(self.fd, pack_all([encode(message) for message in messages]))

    def wait(self, kind: type[M], **values: object) -> M:
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            select.select([self.fd], [], [], PATIENCE_S)
            data = os.read(self.fd, 65536)
            assert data, "the board has hung up"
            said = [decode(frame) for frame in self._decoder.feed(data)]
            self.heard += said
            for message in said:
                if isinstance(message, kind) and all(getattr(message, k) == v for k, v in values.items()):
                    return message
        raise AssertionError(f"no {kind.__name__} {values}; heard {self.heard[-10:]}")


@pytest.fixture(params=[PtyEnd, TcpEnd])
def end(request: pytest.FixtureRequest) -> Link:
    made = request.param()
    assert isinstance(made, Link)
    return made


def test_a_host_speaks_with_the_board(end: Link) -> None:
    with served(end) as board:
        host = Host(end)
        host.say(Ping(9))
        host.wait(Pong, nonce=9)
        host.say(ModeRequest(4, Mode.ARMED, HOST))
        host.wait(Acknowledge, token=4, result=Result.OK)
        host.say(*setpoint_messages(77, [0.0] * 5, 0.01))
        host.wait(State, sequence=77)
        host.wait(FaultEvent)  # nothing more comes: the watchdog
        assert board.mode is Mode.FAULT
        host.close()


def test_hosts_come_and_go(end: Link) -> None:
    with served(end):
        for turn in range(5):
            host = Host(end)
            host.say(Ping(turn))
            host.wait(Pong, nonce=turn)
            os.write(host.fd, b"\x07half a pack")  # it dies in mid-word
            host.close()


def test_a_dead_host_leaves_the_board_to_its_watchdog_and_the_next_one_finds_it(end: Link) -> None:
    with served(end) as board:
        host = Host(end)
        host.say(ModeRequest(1, Mode.ARMED, HOST))
        host.wait(Acknowledge, result=Result.OK)
        host.close()
        host = Host(end)
        event = host.wait(FaultEvent, code=Fault.WATCHDOG)
        host.say(ClearRequest(2, event.number, OTHER))
        host.wait(Acknowledge, token=2, result=Result.OK)
        host.say(ModeRequest(3, Mode.ARMED, OTHER))
        host.wait(Acknowledge, token=3, result=Result.OK)
        host.say(EmergencyStop())
        host.wait(BoardHeartbeat, mode=Mode.STOPPED)
        host.close()
        assert board.mode is Mode.STOPPED


def test_what_nobody_reads_is_thrown_away() -> None:
    """A host that comes late hears of now, not of a minute ago, and the board has never waited."""
    end = PtyEnd()
    for _ in range(3):
        for _ in range(200):
            end.send([Frame(81, b"longago!")] * 7)
        time.sleep(0.3)
    end.send([Frame(81, b"just now")])
    fd = os.open(end.path, os.O_RDWR | os.O_NOCTTY)
    data = os.read(fd, 65536)
    frames = StreamDecoder().feed(data)
    assert frames == [Frame(81, b"just now")]
    os.close(fd)
    end.close()


def test_a_slow_reader_of_a_pty_loses_nothing_that_fits() -> None:
    end = PtyEnd()
    fd = os.open(end.path, os.O_RDWR | os.O_NOCTTY)
    decoder = StreamDecoder()
    frames: list[Frame] = []
    for number in range(300):
        end.send([Frame(81, number.to_bytes(8, "little"))])
        if number % 10 == 9:
            time.sleep(0.002)
            frames += decoder.feed(os.read(fd, 65536))
    while len(frames) < 300 and select.select([fd], [], [], 5.0)[0]:  # a busy kernel hands bytes on late
        frames += decoder.feed(os.read(fd, 65536))
    assert [int.from_bytes(frame.data, "little") for frame in frames] == list(range(300))
    os.close(fd)
    end.close()


def test_several_hosts_on_one_tcp_port() -> None:
    """One runs the robot, another stops it."""
    end = TcpEnd()
    with served(end):
        runner, stopper = Host(end), Host(end)
        runner.say(ModeRequest(1, Mode.ARMED, HOST))
        runner.wait(Acknowledge, token=1)
        stopper.wait(BoardHeartbeat, holder=HOST)
        stopper.say(EmergencyStop())
        runner.wait(FaultEvent)
        stopper.close()
        runner.say(Ping(2))
        runner.wait(Pong, nonce=2)
        runner.close()


def test_set_points_are_heard_by_the_other_hosts_on_a_tcp_port_and_nothing_else_is() -> None:
    end = TcpEnd()
    with served(end):
        runs, looks_on = Host(end), Host(end)
        looks_on.say(Ping(1))
        looks_on.wait(Pong, nonce=1)
        runs.say(ModeRequest(4, Mode.ARMED, HOST))
        runs.wait(Acknowledge, token=4, result=Result.OK)
        said = setpoint_messages(77, [0.1] * 5, 0.01)
        runs.say(*said)
        looks_on.wait(State, sequence=77)
        runs.wait(State, sequence=77)
        assert [m for m in looks_on.heard if isinstance(m, Setpoint | Latch)] == [
            decode(encode(message)) for message in said
        ]
        assert not [m for m in looks_on.heard if isinstance(m, ModeRequest)]
        assert not [m for m in runs.heard if isinstance(m, Setpoint | Latch)], "one does not hear oneself"
        runs.close()
        looks_on.close()


def test_a_crowd_on_the_tcp_port_does_not_shut_the_first_one_out() -> None:
    end = TcpEnd()
    with served(end):
        first = Host(end)
        first.say(Ping(0))
        first.wait(Pong, nonce=0)
        crowd = [socket.create_connection(end.address) for _ in range(40)]
        first.say(Ping(1))
        first.wait(Pong, nonce=1)
        left = set(crowd)  # the newest are heard out; the first that said nothing have made room for them
        deadline = time.monotonic() + PATIENCE_S
        while len(left) > 15 and time.monotonic() < deadline:
            for visitor in select.select(list(left), [], [], 0.1)[0]:
                if not visitor.recv(65536):
                    left.remove(visitor)
        assert left == set(crowd[-15:])
        for visitor in crowd:  # only now: a place that is given up is given to the next
            visitor.close()
        first.close()


def test_noise_on_the_wire_is_reported_in_the_boards_counters(end: Link) -> None:
    with served(end):
        host = Host(end)
        os.write(host.fd, b"\0" + b"\x03no" * 40 + b"\0" + b"\x05abcd\0")
        counters = host.wait(Counters)
        assert isinstance(counters, Counters)
        assert counters.corrupt == 2
        host.close()


def test_an_address_that_cannot_be_had_is_named() -> None:
    taken = TcpEnd()
    with pytest.raises(NoBoardError, match=str(taken.address[1])):
        TcpEnd(*taken.address)
    with pytest.raises(NoBoardError, match="99999"):
        TcpEnd("127.0.0.1", 99999)
    taken.close()


class FailingWire(Link):
    """A bus that is down for a while."""

    def __init__(self) -> None:
        super().__init__("can:failing", math.inf)
        self.uses = 0
        self.said: list[Frame] = []
        self.up = threading.Event()

    def send(self, frames: Sequence[Frame]) -> None:
        self.uses += 1
        if not self.up.is_set():
            raise LostBoardError("down")
        self.said += frames

    def receive(self, timeout_s: float) -> list[Frame]:
        self.uses += 1
        if not self.up.is_set():
            raise LostBoardError("down")
        time.sleep(timeout_s)
        return []

    def close(self) -> None:
        pass


def test_a_wire_that_fails_is_tried_again() -> None:
    wire = FailingWire()
    with served(wire):
        while wire.uses < 5:
            time.sleep(0.01)
        assert not wire.said
        wire.up.set()
        while len(wire.said) < 10:
            time.sleep(0.01)
