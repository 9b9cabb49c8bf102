"""The client of a board: handshake, requests on a bad line, and what a user is told when something is wrong."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import pytest

from firmware_protocol.catalogue import (
    Acknowledge,
    BoardHeartbeat,
    InfoProtocol,
    JointLimits,
    JointMode,
    Message,
    Mode,
    ModeRequest,
    catalogue_hash,
    decode,
    encode,
)
from firmware_protocol.frame import Frame
from snakebot.board import Board, Reading
from snakebot.clock import VirtualClock
from snakebot.control import RunLoop
from snakebot.errors import BadInputError, BoardFaultError, LostBoardError, NoBoardError
from snakebot.gait import Gait, GaitMotion
from snakebot.links.base import Link
from snakebot.robot import load_robot, robot_from_mapping
from snakebot.softboard import InProcessLink, SoftBoard

ROBOT = load_robot("penn_state")


class Silent(Link):
    """A wire at whose other end is nobody."""

    def __init__(self, clock: VirtualClock) -> None:
        super().__init__("serial:/dev/null", math.inf)
        self.clock = clock

    def send(self, frames: Sequence[Frame]) -> None:
        pass

    def receive(self, timeout_s: float) -> list[Frame]:
        self.clock.sleep_until(self.clock.now_s() + max(timeout_s, 1e-4))
        return []

    def close(self) -> None:
        pass


class Rig:
    """A board client on a simulated board whose messages can be changed or lost on the way to the host."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.sim = SoftBoard(ROBOT)
        self.link = InProcessLink(self.sim, self.clock)
        self.board = Board(self.link, self.clock, host=0xC0FFEE)
        self.change: Callable[[Message], Message | None] = lambda message: message
        real = self.link.receive

        def receive(timeout_s: float) -> list[Frame]:
            kept = (self.change(decode(frame)) for frame in real(timeout_s))
            return [encode(message) for message in kept if message is not None]

        self.link.receive = receive  # type: ignore[method-assign]


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_the_handshake_tells_what_the_board_is(rig: Rig) -> None:
    info = rig.board.connect()
    assert (info.joints, info.counts_per_rev, info.watchdog_ms, info.simulated) == (5, 8192, 100, True)
    assert info.catalogue_hash == catalogue_hash()
    assert rig.board.mode is Mode.DISARMED
    assert isinstance(rig.board.last_reading, Reading)


def test_nobody_there_is_said_within_the_time_given() -> None:
    clock = VirtualClock()
    with pytest.raises(NoBoardError, match=r"serial:/dev/null: no board answered within 2 s"):
        Board(Silent(clock), clock).connect()
    assert clock.now_s() == pytest.approx(2.0, abs=0.2)


def other(message: Message, **changes: int) -> Message:
    from dataclasses import replace

    return replace(message, **changes) if isinstance(message, InfoProtocol) else message


@pytest.mark.parametrize("changes", [{"protocol_major": 9}, {"catalogue_hash": 0x12345678}])
def test_ends_that_do_not_agree_are_both_printed(rig: Rig, changes: dict[str, int]) -> None:
    rig.change = lambda message: other(message, **changes)
    with pytest.raises(NoBoardError, match="do not agree") as caught:
        rig.board.connect()
    text = str(caught.value)
    assert f"catalogue {catalogue_hash():08x}" in text
    assert ("protocol 9." in text) or ("catalogue 12345678" in text)


def test_a_request_is_repeated_until_it_is_acknowledged(rig: Rig) -> None:
    rig.board.connect()
    lost: list[int] = []

    def lose_two(message: Message) -> Message | None:
        if isinstance(message, Acknowledge) and len(lost) < 2:
            lost.append(message.token)
            return None
        return message

    rig.change = lose_two
    rig.board.arm()
    assert rig.sim.mode is Mode.ARMED
    assert len(set(lost)) == 1  # the same token each time


def test_a_request_that_is_never_acknowledged_is_a_lost_board(rig: Rig) -> None:
    rig.board.connect()
    rig.change = lambda message: None if isinstance(message, Acknowledge) else message
    before = rig.clock.now_s()
    with pytest.raises(LostBoardError, match="did not acknowledge the request to hold"):
        rig.board.hold()
    assert 1.2 <= rig.clock.now_s() - before <= 1.4


def test_a_board_that_another_host_holds_says_who(rig: Rig) -> None:
    rig.board.connect()
    for mode in (Mode.ARMED, Mode.HOLDING):
        rig.sim.receive(encode(ModeRequest(1, mode, 0xBEEF)), rig.clock.now_s())
    with pytest.raises(BoardFaultError, match="another host holds it"):
        rig.board.arm()
    for _ in range(10):
        rig.board.poll(0.02)
    with pytest.raises(BoardFaultError, match="host 0000beef holds it"):
        rig.board.arm()


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        (lambda board: board.set_joint_mode(6, JointMode.FREE), "joints 1 to 5"),
        (lambda board: board.set_joint_mode(1, JointMode.RIGID, 3.0), "outside what this board can do"),
        (lambda board: board.hold(), "not while it is disarmed"),
    ],
)
def test_a_refusal_says_why(rig: Rig, request_: Callable[[Board], None], words: str) -> None:
    rig.board.connect()
    with pytest.raises(BoardFaultError, match=words):
        request_(rig.board)


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        (
            {"acceleration_rad_s2": [60, 262.2, 60, 60, 60]},
            ("joint 2 ", "acceleration limit 262.2", "to 262.142 rad/s2"),
        ),
        ({"acceleration_rad_s2": 1e9}, ("joint 1 ", "acceleration limit 1e+09", "to 262.142 rad/s2")),
        ({"speed_rad_s": 1000}, ("joint 1 ", "speed limit 1000 rad/s", "to 262.142 rad/s")),
        ({"speed_rad_s": 0.0019}, ("joint 1 ", "speed limit 0.0019 rad/s", "0.002 to")),
    ],
)
def test_a_limit_that_the_wire_cannot_carry_is_bad_input_before_anything_is_sent(
    rig: Rig, limits: dict[str, object], words: tuple[str, ...]
) -> None:
    robot = robot_from_mapping({"joints": 5, "limits": limits}, "test")
    rig.board.connect()
    traffic = rig.board.recent_traffic()
    with pytest.raises(BadInputError) as caught:
        rig.board.set_limits(robot)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    with pytest.raises(BadInputError, match="limit"):
        RunLoop(
            rig.board,
            robot,
            lambda start: GaitMotion(Gait(0, 0, 0), 5, 1, 0),
            rate_hz=100,
            clock=rig.clock,
            amplitude_rad=1.0,
        )
    assert rig.board.recent_traffic() == traffic


def test_the_largest_limit_of_the_wire_reaches_the_board(rig: Rig) -> None:
    robot = robot_from_mapping(
        {"joints": 5, "limits": {"acceleration_rad_s2": 262.142, "speed_rad_s": 8}}, "test"
    )
    rig.board = Board(InProcessLink(SoftBoard(robot), rig.clock), rig.clock)
    rig.board.connect()
    rig.board.set_limits(robot)


@pytest.mark.parametrize("held", [True, False])
def test_a_host_that_stood_still_listens_again_before_it_calls_the_board_lost(rig: Rig, held: bool) -> None:
    """What it heard last is older than half a second; what the board has said since waits in the line."""
    rig.board.connect()
    rig.board.arm()
    rig.board.heard()
    rig.board.poll()
    if held:  # frames from before the standstill, not taken in yet
        rig.board.ping()
        rig.board.await_answer(0.05)
        rig.clock.sleep_until(rig.clock.now_s() + 1.5)
    else:  # it stands still after it has found nothing
        real = rig.link.receive

        def receive(timeout_s: float) -> list[Frame]:
            rig.link.receive = real  # type: ignore[method-assign]
            rig.clock.sleep_until(rig.clock.now_s() + 1.5)
            return []

        rig.link.receive = receive  # type: ignore[method-assign]
    with pytest.raises(BoardFaultError, match="watchdog stopped the joints"):
        for _ in range(3):
            rig.board.poll()


def test_a_silent_board_is_lost_after_half_a_second(rig: Rig) -> None:
    rig.board.connect()
    rig.change = lambda message: None
    began = rig.clock.now_s()
    with pytest.raises(LostBoardError, match="silent"):
        while rig.clock.now_s() < began + 5:
            rig.board.poll(0.01)
    assert rig.clock.now_s() - began == pytest.approx(0.5, abs=0.15)


def test_a_changed_boot_id_is_a_fault(rig: Rig) -> None:
    from dataclasses import replace

    rig.board.connect()
    rig.board.arm()
    rig.change = lambda message: (
        replace(message, boot_id=message.boot_id ^ 1) if isinstance(message, BoardHeartbeat) else message
    )
    with pytest.raises(BoardFaultError, match="rebooted"):
        for _ in range(50):
            rig.board.send_setpoints([0.0] * 5, 0.01)
            rig.board.poll(0.01)


def test_frames_that_are_no_message_are_counted_and_dropped(rig: Rig) -> None:
    rig.board.connect()
    real = rig.link.receive
    rig.link.receive = lambda timeout_s: [Frame(0x7FF, b"?"), Frame(0x20, b"short"), *real(timeout_s)]  # type: ignore[method-assign]
    rig.board.poll(0.1)
    assert rig.board.unreadable == 2


def test_a_robot_that_is_not_this_boards_is_refused(rig: Rig) -> None:
    rig.board.connect()
    rig.board.check_robot(ROBOT)
    with pytest.raises(BadInputError, match=r"5 joints, robot 'bench' has 1"):
        rig.board.check_robot(robot_from_mapping({"name": "bench", "joints": 1}, "here"))


def test_the_last_traffic_can_be_read(rig: Rig) -> None:
    rig.board.connect()
    lines = rig.board.recent_traffic()
    assert any("tx" in line and "Ping" in line for line in lines)
    assert any("rx" in line and "State" in line for line in lines)


def test_the_watchdog_in_a_message_is_that_of_this_board(rig: Rig) -> None:
    """A board says how long it waits for a set-point; another one waits 100 ms."""
    info = rig.board.connect()
    rig.board.info = dataclasses.replace(info, watchdog_ms=150)
    rig.board.arm()
    with pytest.raises(BoardFaultError, match="no set-point reached it for 150 ms"):
        for _ in range(100):
            rig.board.poll(0.05)


@pytest.mark.parametrize("watchdog_ms", [40, 100])
def test_limits_are_waited_for_only_while_the_watchdog_of_this_board_has_time(
    rig: Rig, watchdog_ms: int
) -> None:
    rig.board.info = dataclasses.replace(rig.board.connect(), watchdog_ms=watchdog_ms)
    rig.board.set_limits(ROBOT)
    rig.change = lambda message: None if isinstance(message, JointLimits) else message
    begun_s = rig.clock.now_s()
    with pytest.raises(BoardFaultError, match="does not report the limits"):
        rig.board.arm()
    assert rig.clock.now_s() - begun_s <= 0.65 * watchdog_ms * 1e-3
    assert rig.sim.mode is Mode.DISARMED
