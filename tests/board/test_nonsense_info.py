"""A board that says of itself what cannot be is refused in one line, and nothing is computed with it."""

from __future__ import annotations

import pytest
from board_hands import Hands

from firmware_protocol.catalogue import InfoFirmware, InfoProtocol, JointSupply, Message, encode, frame_id
from firmware_protocol.checks import out_of_range, said_by_boards
from firmware_protocol.frame import Frame
from snakebot.errors import NoBoardError


@pytest.mark.parametrize(
    ("message", "at", "raw", "words"),
    [
        (InfoFirmware, 4, b"\0\0", "counts_per_rev 0, outside 16 to 65535"),
        (InfoFirmware, 4, b"\x0f\0", "counts_per_rev 15, outside 16 to 65535"),
        (InfoFirmware, 3, b"\0", "watchdog_ms 0, outside 1 to 255"),
        (InfoProtocol, 2, b"\0", "joints 0, outside 1 to 16"),
        (InfoProtocol, 2, b"\x11", "joints 17, outside 1 to 16"),
        (InfoProtocol, 2, b"\xff", "joints 255, outside 1 to 16"),
    ],
)
def test_a_value_out_of_its_range_is_named(message: type[Message], at: int, raw: bytes, words: str) -> None:
    hands = Hands()

    def spoil(frame: Frame) -> Frame:
        if frame.id != frame_id(message):
            return frame
        return Frame(frame.id, frame.data[:at] + raw + frame.data[at + len(raw) :])

    hands.line.change_frame = spoil
    with pytest.raises(NoBoardError, match=words) as refused:
        hands.board.connect()
    assert "\n" not in str(refused.value)


def test_a_supply_of_a_joint_that_cannot_be_is_dropped() -> None:
    hands = Hands()
    hands.board.connect()
    hands.board.heard()
    good = encode(JointSupply(1, 0.5, 20.0))
    hands.line.extra += [Frame(good.id, b"\0" + good.data[1:]), Frame(good.id, b"\x11" + good.data[1:]), good]
    heard = [item for item in hands.board.poll(0.001) if isinstance(item, JointSupply)]
    assert [item.joint for item in heard] == [1]
    assert hands.board.unreadable == 2


def test_who_says_what_is_as_in_the_dbc() -> None:
    names = {cls.__name__ for cls in said_by_boards()}
    assert {"State", "BoardHeartbeat", "Acknowledge", "Pong", "JointLimits", "FaultEvent"} <= names
    assert not names & {"HostHeartbeat", "Ping", "ModeRequest", "EmergencyStop", "Setpoint", "Latch"}
    assert out_of_range(JointSupply(16, 0.0, 0.0)) is None
