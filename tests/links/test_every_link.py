"""The contract of links, on every carrier but udp_multicast, which needs a network of its own."""

from __future__ import annotations

import math
import os
import socket
import threading
import uuid
from collections.abc import Iterator, Sequence

import pytest
import serial
from link_contract import LinkContract, Wire, send_often
from serial.rfc2217 import PortManager

from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack
from snakebot.clock import MonotonicClock
from snakebot.errors import LostBoardError
from snakebot.links import Link, open_link, parse_port
from snakebot.links.can_link import open_can
from snakebot.links.port import CanPort
from snakebot.softboard import InProcessLink, PtyEnd, TcpEnd
from snakebot.softboard.slcan_end import SlcanEnd


class FarSide:
    """Stands where the in-process link expects a simulated board, and lets a test see and say frames."""

    next_event_s = math.inf

    def __init__(self) -> None:
        self.inbox: list[Frame] = []
        self.outbox: list[Frame] = []

    def take(self, frames: Sequence[Frame], now_s: float) -> None:
        self.inbox += frames

    def advance(self, now_s: float) -> list[Frame]:
        said, self.outbox = self.outbox, []
        return said

    def integrate(self, now_s: float) -> None: ...

    def note_corrupt(self, packets: int) -> None:
        assert packets == 0


class FarLink(Link):
    """The far side as a link."""

    def __init__(self, side: FarSide) -> None:
        super().__init__("far", math.inf)
        self._side = side

    def send(self, frames: Sequence[Frame]) -> None:
        self._side.outbox += frames

    def receive(self, timeout_s: float) -> list[Frame]:
        taken, self._side.inbox = self._side.inbox, []
        return taken

    def close(self) -> None: ...


class TestInProcess(LinkContract):
    @pytest.fixture
    def wire(self) -> Wire:
        side = FarSide()
        link = InProcessLink(side, MonotonicClock())  # type: ignore[arg-type]
        return Wire(link, FarLink(side), link.unplug)

    def test_a_wire_cut_in_mid_wait_ends_the_wait(self, wire: Wire) -> None:
        pytest.skip("one thread has both ends: nobody can cut it in mid-wait")


class TestPty(LinkContract):
    exclusive = True

    @pytest.fixture
    def wire(self) -> Iterator[Wire]:
        board = PtyEnd()
        host = open_link(board.port)
        yield Wire(host, board, board.close)
        host.close()
        board.close()


class TestTcp(LinkContract):
    @pytest.fixture
    def wire(self) -> Iterator[Wire]:
        board = TcpEnd()
        host = open_link(board.port)
        board.receive(1.0)  # lets it in
        yield Wire(host, board, board.close)
        host.close()
        board.close()


class TestSlcan(LinkContract):
    exclusive = True

    @pytest.fixture
    def wire(self) -> Iterator[Wire]:
        board = SlcanEnd()
        host = open_link(board.port)
        while not board.adapter.open:
            board.receive(1.0)  # takes the host's opening commands
        yield Wire(host, board, board.close)
        host.close()
        board.close()


class TestVirtualCan(LinkContract):
    @pytest.fixture
    def wire(self) -> Iterator[Wire]:
        name = f"can:virtual/{uuid.uuid4().hex}"
        port = parse_port(name)
        assert isinstance(port, CanPort)
        board, host = open_can(port, role="Board"), open_link(name)
        yield Wire(host, board)
        host.close()
        board.close()


@pytest.mark.filterwarnings("ignore:set.*is deprecated:DeprecationWarning")
class TestRfc2217(LinkContract):
    """A pyserial URL without a descriptor of its own: read by a thread. The server is pyserial's."""

    @pytest.fixture
    def wire(self) -> Iterator[Wire]:
        board = PtyEnd()
        server = Rfc2217Server(board.path)
        host = open_link(f"serial:rfc2217://127.0.0.1:{server.port}")
        yield Wire(host, board, server.close)
        host.close()
        server.close()
        board.close()


class Rfc2217Server:
    """One serial device on one telnet connection, with the option handling of ``serial.rfc2217.PortManager``."""

    def __init__(self, device: str) -> None:
        self._serial = serial.Serial(device, 115200, timeout=0.01)
        self._door = socket.create_server(("127.0.0.1", 0))
        self.port = self._door.getsockname()[1]
        self._open = True
        self._connection: socket.socket | None = None
        self._threads = [threading.Thread(target=self._serve, daemon=True)]
        self._threads[0].start()

    def _serve(self) -> None:
        self._connection, _ = self._door.accept()
        lock = threading.Lock()
        connection = self._connection

        class Socket:
            def write(self, data: bytes) -> None:
                with lock:
                    connection.sendall(data)

        # A pty has no modem lines to report.
        manager = PortManager(_NoModem(self._serial), Socket())

        def to_host() -> None:
            while self._open:
                data = self._serial.read(4096)
                if data:
                    try:
                        Socket().write(b"".join(manager.escape(data)))
                    except OSError:
                        return

        sender = threading.Thread(target=to_host, daemon=True)
        self._threads.append(sender)
        sender.start()
        while self._open:
            try:
                data = connection.recv(4096)
            except OSError:
                return
            if not data:
                return
            self._serial.write(b"".join(manager.filter(data)))

    def close(self) -> None:
        if not self._open:
            return
        self._open = False
        if self._connection is not None:
            self._connection.shutdown(socket.SHUT_RDWR)
            self._connection.close()
        self._door.close()
        for thread in self._threads:
            thread.join(5.0)
        self._serial.close()


class _NoModem:
    def __init__(self, device: object) -> None:
        object.__setattr__(self, "_device", device)

    def __getattr__(self, name: str) -> object:
        if name in ("cts", "dsr", "ri", "cd"):
            return False
        return getattr(self._device, name)

    def __setattr__(self, name: str, value: object) -> None:
        if name not in ("dtr", "rts"):
            setattr(self._device, name, value)


def test_a_loop_url_hears_itself() -> None:
    with open_link("loop://") as link:
        frames = [Frame(16, bytes(range(8))), Frame(17, b"")]
        link.send(frames)
        assert [*link.receive(5.0), *link.receive(0.1)] == frames


def test_noise_on_a_serial_line_is_counted_and_dropped() -> None:
    board = PtyEnd()
    with open_link(board.port) as host:
        os.write(board._master, b"\x05garbage\0more garbage without an end")
        board.send([Frame(32, b"good")])
        assert host.receive(5.0) == [Frame(32, b"good")]
        assert host.statistics.corrupt == 2
    board.close()


def test_half_a_packet_waits_for_its_other_half() -> None:
    board = PtyEnd()
    packet = pack(Frame(32, b"12345678"))
    with open_link(board.port) as host:
        os.write(board._master, packet[:5])
        assert host.receive(0.05) == []
        os.write(board._master, packet[5:])
        assert host.receive(5.0) == [Frame(32, b"12345678")]
    board.close()


def test_a_line_that_takes_no_more_is_lost_not_waited_for() -> None:
    """Nobody reads the far end: a buffer fills, and a control loop must not stand still behind it."""
    board = PtyEnd()
    frames = [Frame(16, bytes(8))] * 100
    with open_link(board.port) as host, pytest.raises(LostBoardError, match="taken no byte"):
        send_often(host, frames)
    board.close()
