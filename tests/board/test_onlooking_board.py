"""A host that only listens hears what the other one asks for, where the line carries it."""

from __future__ import annotations

import pytest
from board_hands import OTHER, ROBOT, Hands

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import HostHeartbeat, encode
from snakebot.board import Reading
from snakebot.board.onlooker import Onlooker

ASKED = [0.1, -0.2, 0.3, 0.0, 0.05]


def looking_on() -> tuple[Hands, Onlooker]:
    """A board that somebody drives, and one who hears both."""
    hands = Hands()
    board = Onlooker(hands.line, hands.clock)
    board.connect()
    hands.board.connect()
    hands.board.arm()
    return hands, board


def test_a_set_point_is_known_by_the_number_that_the_board_answers() -> None:
    hands, board = looking_on()
    assert hands.board.info is not None
    made = hands.board.make_setpoint(ASKED, 0.01)
    assert board.setpoint_rad(made.sequence) is None
    hands.board.send_made(made)
    hands.line.extra += made.frames  # as on a CAN bus
    readings = [item for item in board.listen(0.02) if isinstance(item, Reading)]
    assert readings[-1].sequence == made.sequence
    assert board.setpoint_rad(made.sequence) == pytest.approx(ASKED, abs=1e-4)
    assert board.setpoint_rad(made.sequence + 1) is None


def test_half_a_set_point_is_none_and_others_go_on() -> None:
    hands, board = looking_on()
    first = [encode(message) for message in setpoint_messages(7, ASKED, 0.01)]
    second = [encode(message) for message in setpoint_messages(8, ASKED, 0.01)]
    hands.line.extra += first[1:] + second
    board.listen(0.01)
    assert board.setpoint_rad(7) is None
    assert board.setpoint_rad(8) is not None
    hands.line.extra.append(encode(HostHeartbeat(OTHER, 1)))
    board.listen(0.01)


def test_no_more_are_kept_than_a_board_may_still_answer() -> None:
    hands, board = looking_on()
    for number in range(200):
        hands.line.extra += [encode(m) for m in setpoint_messages(number, [0.0] * ROBOT.joints, 0.01)]
        board.listen(0.001)
    kept = [number for number in range(200) if board.setpoint_rad(number) is not None]
    assert kept == list(range(200 - len(kept), 200))
    assert 10 < len(kept) < 100
