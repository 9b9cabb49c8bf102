"""The limits that a board reports once it is armed are the ones asked for, or nothing moves."""

from __future__ import annotations

import pytest
from board_hands import OTHER, Hands

from firmware_protocol.catalogue import (
    JointLimits,
    Latch,
    LimitKind,
    LimitRequest,
    Message,
    Mode,
    ModeRequest,
    encode,
)
from snakebot.errors import BoardFaultError
from snakebot.robot import Robot, robot_from_mapping

TIGHT: Robot = robot_from_mapping(
    {
        "joints": 5,
        "encoder_counts_per_rev": 8192,
        "limits": {"angle_deg": 40, "speed_rad_s": [1, 2, 2.0031, 2, 2], "acceleration_rad_s2": 20},
    },
    "tight",
)


@pytest.mark.parametrize(
    ("kind", "value", "words"),
    [
        (LimitKind.SPEED, 8.0, r"joint 2: the speed limit in force is 8 rad/s, 2 rad/s was asked for"),
        (LimitKind.ANGLE, 1.2, r"joint 2: the angle limit in force is 1.2 rad, 0.698 rad was asked for"),
        (
            LimitKind.ACCELERATION,
            19.0,
            r"joint 2: the acceleration limit in force is 19 rad/s2, 20 rad/s2 was",
        ),
    ],
)
def test_limits_that_another_host_has_changed_before_arming_end_it(
    kind: LimitKind, value: float, words: str
) -> None:
    hands = Hands()
    hands.board.connect()
    hands.board.set_limits(TIGHT)
    latches: list[Message] = []

    def change_them(message: Message) -> Message:
        """Another host comes in between: after our limits, before we arm."""
        if isinstance(message, ModeRequest) and hands.sim.mode is Mode.DISARMED:
            request = LimitRequest(1, 2, kind, value, OTHER)
            hands.sim.receive(encode(request), hands.clock.now_s())
        if isinstance(message, Latch):
            latches.append(message)
        return message

    hands.line.on_send = change_them
    with pytest.raises(BoardFaultError, match=words):
        hands.board.arm()
    assert hands.sim.mode is Mode.DISARMED
    assert not latches
    assert not hands.board.claimed


def test_limits_that_are_the_ones_asked_for_are_no_hindrance() -> None:
    hands = Hands()
    hands.board.connect()
    hands.board.set_limits(TIGHT)
    hands.board.arm()
    assert hands.sim.mode is Mode.ARMED


def test_reports_that_get_lost_are_asked_for_again() -> None:
    hands = Hands()
    hands.board.connect()
    hands.board.set_limits(TIGHT)
    lost: set[int] = set()

    def lose_each_once(message: Message) -> Message | None:
        if isinstance(message, JointLimits) and message.joint not in lost:
            lost.add(message.joint)
            return None
        return message

    hands.line.change = lose_each_once
    began_s = hands.clock.now_s()
    hands.board.arm()
    assert lost == {1, 2, 3, 4, 5}
    assert hands.clock.now_s() - began_s < 0.05, "the watchdog runs meanwhile"


def test_limits_that_are_not_reported_end_it() -> None:
    hands = Hands()
    hands.board.connect()
    hands.board.set_limits(TIGHT)
    hands.line.change = lambda m: None if isinstance(m, JointLimits) and m.joint == 3 else m
    with pytest.raises(BoardFaultError, match="does not report the limits of joint 3: nothing was moved"):
        hands.board.arm()
    assert hands.sim.mode is Mode.DISARMED


def test_a_report_from_before_arming_does_not_count() -> None:
    """An answer to somebody's InfoRequest that was true then."""
    hands = Hands()
    hands.board.connect()
    hands.board.set_limits(TIGHT)

    def change_them(message: Message) -> Message:
        if isinstance(message, ModeRequest) and hands.sim.mode is Mode.DISARMED:
            for joint, speed in enumerate(TIGHT.speed_limit_rad_s, start=1):
                said = JointLimits(joint, 0.698, int(speed / 0.002) * 0.002, 20.0)
                hands.line.extra.append(encode(said))
            hands.sim.receive(encode(LimitRequest(1, 2, LimitKind.SPEED, 8.0, OTHER)), hands.clock.now_s())
        return message

    hands.line.on_send = change_them
    hands.line.change = lambda m: None if isinstance(m, JointLimits) and m.joint == 2 else m
    with pytest.raises(BoardFaultError, match="joint 2"):
        hands.board.arm()
