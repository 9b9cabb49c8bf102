"""What becomes of a CAN driver's troubles: a bus made of python-can's own exceptions."""

from __future__ import annotations

import errno
from collections.abc import Callable
from typing import Any

import can
import pytest

from firmware_protocol.catalogue import InfoRequest, Setpoint, State, frame_id
from firmware_protocol.frame import Frame
from snakebot.errors import LostBoardError
from snakebot.links import can_link
from snakebot.links.can_link import CanLink, Role
from snakebot.links.port import CanPort


class TroubledBus(can.BusABC):
    """Sends and receives what a test says."""

    def __init__(self) -> None:
        super().__init__(channel="troubled")
        self.on_send: Callable[[can.Message], None] = lambda message: None
        self.arriving: list[can.Message | Exception] = []

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        self.on_send(msg)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self.arriving:
            return None, False
        item = self.arriving.pop(0)
        if isinstance(item, Exception):
            raise item
        return item, True


@pytest.fixture
def bus() -> TroubledBus:
    return TroubledBus()


@pytest.fixture
def link(bus: TroubledBus) -> CanLink:
    return CanLink("can:test/0", bus)


def failing(error: Exception) -> Callable[[can.Message], None]:
    def send(message: can.Message) -> None:
        raise error

    return send


def frame_of(identifier: int, data: bytes = b"", **more: Any) -> can.Message:
    return can.Message(arbitration_id=identifier, data=data, is_extended_id=False, **more)


@pytest.mark.parametrize(
    ("error", "advice"),
    [
        (can.CanOperationError("Failed to transmit", errno.ENETDOWN), "interface is down"),
        (can.CanOperationError("Failed to transmit", errno.ENODEV), "plugged in"),
        (can.CanOperationError("Failed to transmit", errno.ENOBUFS), "nobody acknowledges"),
        (can.CanOperationError("Transmit buffer full"), "nobody acknowledges"),
        (can.CanTimeoutError(), "check adapter"),
        (OSError(errno.EIO, "Input/output error"), "check adapter"),
    ],
)
def test_a_send_that_fails_is_a_lost_board(
    link: CanLink, bus: TroubledBus, error: Exception, advice: str
) -> None:
    bus.on_send = failing(error)
    with pytest.raises(LostBoardError, match=advice) as caught:
        link.send([Frame(16, b"")])
    assert str(caught.value).startswith("can:test/0: ")
    assert "\n" not in str(caught.value)


def test_a_queue_that_is_full_for_a_moment_is_waited_for(link: CanLink, bus: TroubledBus) -> None:
    sent: list[int] = []
    refusals = 3

    def send(message: can.Message) -> None:
        nonlocal refusals
        if refusals:
            refusals -= 1
            raise can.CanOperationError("Failed to transmit", errno.ENOBUFS)
        sent.append(message.arbitration_id)

    bus.on_send = send
    link.send([Frame(16, b""), Frame(17, b"")])
    assert sent == [16, 17]
    assert link.statistics.sent == 2


def test_a_receive_that_fails_is_a_lost_board(link: CanLink, bus: TroubledBus) -> None:
    failed = can.CanOperationError("Failed to receive")
    failed.__cause__ = OSError(errno.ENETDOWN, "Network is down")
    bus.arriving = [failed]
    with pytest.raises(LostBoardError, match="interface is down"):
        link.receive(60.0)


def test_the_bus_goes_off(link: CanLink, bus: TroubledBus) -> None:
    bus.arriving = [can.Message(arbitration_id=0x40, is_error_frame=True)]
    with pytest.raises(LostBoardError, match="bus is off"):
        link.receive(60.0)


def test_packets_that_python_can_cannot_read_are_counted(link: CanLink, bus: TroubledBus) -> None:
    unreadable = can.CanOperationError("could not unpack received message")
    unreadable.__cause__ = KeyError("arbitration_id")
    bus.arriving = [unreadable, ValueError("invalid literal for int()"), frame_of(32, b"good")]
    received = link.receive(1.0) or link.receive(1.0) or link.receive(1.0)
    assert received == [Frame(32, b"good")]
    assert link.statistics.corrupt == 2


def test_other_nodes_frames_are_passed_over(link: CanLink, bus: TroubledBus) -> None:
    bus.arriving = [
        can.Message(arbitration_id=0x20, data=b"extended", is_extended_id=True),
        frame_of(0x20, is_remote_frame=True),
        frame_of(0x20, bytes(12), is_fd=True),
        can.Message(arbitration_id=0x4, is_error_frame=True),
        frame_of(0x20, b"ours"),
    ]
    assert link.receive(1.0) == [Frame(0x20, b"ours")]
    assert link.statistics.received == 1


def test_where_own_frames_come_back_only_the_other_side_is_heard(bus: TroubledBus) -> None:
    link = CanLink("can:test/0", bus, hears=frozenset({32}))
    bus.arriving = [frame_of(16, b"own"), frame_of(32, b"other")]
    assert link.receive(1.0) == [Frame(32, b"other")]


def test_an_onlooker_hears_set_points_of_the_host_where_own_frames_come_back(
    bus: TroubledBus, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(can_link, "_open_multicast", lambda *_: bus)
    own, of_host, of_board = frame_id(InfoRequest), frame_id(Setpoint), frame_id(State)
    port = CanPort("udp_multicast", "239.74.163.2")
    cases: list[tuple[Role, list[int]]] = [("Host", [of_board]), ("Onlooker", [of_host, of_board])]
    for role, heard in cases:
        bus.arriving = [frame_of(each, bytes(8)) for each in (own, of_host, of_board)]
        assert [frame.id for frame in can_link.open_can(port, role).receive(1.0)] == heard
