"""More than one host and one board on a line: who is heard, who is answered, and what is told."""

from __future__ import annotations

from dataclasses import replace

import pytest
from board_hands import OTHER, ROBOT, Hands

from firmware_protocol.catalogue import (
    Acknowledge,
    BoardHeartbeat,
    HostHeartbeat,
    InfoFirmware,
    InfoProtocol,
    InfoSerial,
    JointMode,
    JointModeRequest,
    Message,
    Mode,
    ModeRequest,
    Ping,
    Result,
    encode,
)
from snakebot.board import OtherHost
from snakebot.errors import BoardFaultError, LostBoardError, NoBoardError
from snakebot.softboard.hardware import HardwareFault


def stream(hands: Hands, seconds: float) -> list[object]:
    """Set-points that ask for no motion; what was heard."""
    heard: list[object] = []
    for _ in range(round(seconds / 0.01)):
        hands.board.send_setpoints([0.0] * ROBOT.joints, 0.01)
        end_s = hands.clock.now_s() + 0.01
        while hands.clock.now_s() < end_s:
            heard += hands.board.poll(max(1e-5, end_s - hands.clock.now_s()))
    return heard


@pytest.mark.parametrize("noise", ["another host's", "our own echo", "another host's requests"])
def test_a_dead_board_is_noticed_though_others_speak(noise: str) -> None:
    hands = Hands()
    hands.board.connect()
    hands.board.arm()
    stream(hands, 0.2)
    hands.line.change = lambda message: None
    spoken: dict[str, list[Message]] = {
        "another host's": [HostHeartbeat(OTHER, 1), Ping(3)],
        "our own echo": [HostHeartbeat(hands.board.host, 1), Ping(3)],
        "another host's requests": [JointModeRequest(1, 1, JointMode.ACTIVE, 0.0, OTHER)],
    }
    began_s = hands.clock.now_s()
    with pytest.raises(LostBoardError, match="silent"):
        for _ in range(200):
            hands.line.extra += [encode(message) for message in spoken[noise]]
            stream(hands, 0.01)
    assert hands.clock.now_s() - began_s == pytest.approx(0.5, abs=0.1)


def test_a_dead_board_is_noticed_though_another_board_speaks() -> None:
    hands = Hands(1, 1)
    second = hands.boards[1]
    hands.line.change = lambda message: message
    hands.boards.pop()
    hands.line._links.pop()
    hands.line.boards.pop()
    hands.board.connect()
    hands.board.arm()
    hands.line.change = lambda message: None
    beat = BoardHeartbeat(second.boot_id, Mode.DISARMED, 0, 1, hands.board.fault, 0)
    with pytest.raises(BoardFaultError, match="rebooted"):
        for _ in range(30):
            hands.line.extra.append(encode(beat))
            stream(hands, 0.1)


@pytest.mark.parametrize("serials", [(1, 2), (1, 1)])
def test_two_boards_are_refused_at_the_start(serials: tuple[int, int]) -> None:
    hands = Hands(*serials)
    with pytest.raises(NoBoardError, match=r"two boards .* leave one") as refused:
        hands.board.connect()
    assert "\n" not in str(refused.value)


def test_two_boards_are_refused_though_the_second_ones_answers_are_lost() -> None:
    hands = Hands(1, 1)
    answers: list[Message] = []

    def lose_the_second(message: Message) -> Message | None:
        if isinstance(message, InfoProtocol | InfoFirmware | InfoSerial):
            answers.append(message)
            return message if len(answers) <= 3 else None
        return message

    hands.line.change = lose_the_second
    with pytest.raises((NoBoardError, BoardFaultError), match="two boards"):
        hands.board.connect()
        stream(hands, 0.4)
    assert len(answers) > 3


def test_a_second_board_in_mid_run_ends_it_safely() -> None:
    hands = Hands(1, 2)
    first, second = hands.boards
    late = hands.line._links.pop()
    hands.line.boards.pop()
    hands.board.connect()
    hands.board.arm()
    stream(hands, 0.3)
    second.advance(hands.clock.now_s())  # it lived elsewhere
    hands.line._links.append(late)
    hands.line.boards.append(second)
    with pytest.raises(BoardFaultError, match=r"two boards speak on this line \(boot [0-9a-f]{4} and"):
        stream(hands, 0.5)
    hands.board.hold()
    hands.board.disarm()
    assert (first.mode, second.mode) == (Mode.DISARMED, Mode.DISARMED)


def test_another_host_is_told_once() -> None:
    hands = Hands()
    hands.board.connect()
    hands.board.arm()
    heard: list[object] = []
    for _ in range(5):
        hands.say(HostHeartbeat(OTHER, 1), HostHeartbeat(hands.board.host, 1))
        heard += stream(hands, 0.1)
    assert [item for item in heard if isinstance(item, OtherHost)] == [OtherHost(OTHER)]
    assert hands.board.neighbours.hosts == {OTHER}


def test_an_answer_to_another_host_is_not_ours() -> None:
    """Both ask to arm at once, with the same token; the answer to the other one comes first."""
    hands = Hands()
    hands.board.connect()

    def first(message: Message) -> Message:
        if (
            isinstance(message, ModeRequest)
            and message.mode is Mode.ARMED
            and hands.sim.mode is Mode.DISARMED
        ):
            hands.sim.receive(encode(replace(message, host=OTHER)), hands.clock.now_s())
        return message

    hands.line.on_send = first
    with pytest.raises(BoardFaultError, match="another host holds it"):
        hands.board.arm()
    assert not hands.board.claimed


def test_of_simultaneous_requests_to_arm_with_any_token_none_is_believed_by_both() -> None:
    for token in range(0, 256, 16):
        hands = Hands()
        hands.board.connect()
        hands.board._requests._token = token
        hands.sim.receive(encode(ModeRequest((token + 1) % 256, Mode.ARMED, OTHER)), hands.clock.now_s())
        with pytest.raises(BoardFaultError):
            hands.board.arm()


def test_a_newer_request_for_a_joint_is_not_undone_by_an_older_ones_repetition() -> None:
    """Rigid, then active 10 ms later; the answer to the first is lost, and its repetition would come last."""
    hands = Hands()
    hands.board.connect()
    hands.board.arm()
    lost: list[int] = []

    def lose_the_first(message: Message) -> Message | None:
        if isinstance(message, Acknowledge) and not lost:
            lost.append(message.token)
            return None
        return message

    hands.line.change = lose_the_first
    hands.board.set_joint_mode(2, JointMode.RIGID, 0.1, wait=False)
    stream(hands, 0.01)
    hands.board.set_joint_mode(2, JointMode.ACTIVE, wait=False)
    stream(hands, 1.0)
    assert lost
    assert hands.sim.joint_modes[1] is JointMode.ACTIVE


def test_requests_for_other_joints_and_limits_are_still_repeated() -> None:
    hands = Hands()
    hands.board.connect()
    asked: list[JointModeRequest] = []

    def lose_once(message: Message) -> Message | None:
        if isinstance(message, JointModeRequest) and message not in asked:
            asked.append(message)
            return None
        return message

    hands.line.on_send = lose_once
    for joint in (1, 2, 3):
        hands.board.set_joint_mode(joint, JointMode.FREE, wait=False)
    for _ in range(20):
        hands.board.poll(0.01)
    assert hands.sim.joint_modes[:3] == (JointMode.FREE,) * 3


def test_what_is_refused_names_the_fault_that_lasts() -> None:
    from firmware_protocol.catalogue import Fault

    hands = Hands()
    hands.board.connect()
    hands.sim.fail(HardwareFault(Fault.OVERTEMPERATURE), hands.clock.now_s())
    with pytest.raises(BoardFaultError, match="to arm: the board reports that it is too hot"):
        hands.board.arm()
    assert hands.sim.mode is Mode.DISARMED
    assert Result(6) is Result.FAULTY  # on the wire
