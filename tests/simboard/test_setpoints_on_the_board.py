"""Set-points: complete, in order, at once; and what the joints' limits make of them."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from board_rig import Rig, bench, samples

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import Counters, Latch, Message, Mode, Setpoint, State, encode
from firmware_protocol.frame import Frame


def armed(joints: int = 5) -> Rig:
    rig = Rig(bench(joints))
    rig.advance(0.05)
    rig.go(Mode.ARMED)
    return rig


def executed(rig: Rig, said: list[Message]) -> list[int]:
    """Sequence numbers that were answered."""
    return [sample.state.sequence for sample in samples(said, rig.robot.joints)]


@pytest.mark.parametrize("joints", [1, 2, 3, 4, 6, 7, 15, 16])
def test_each_executed_setpoint_is_answered_by_one_sample(joints: int) -> None:
    rig = armed(joints)
    rig.advance(0.01)
    target = [0.0003 * (joint + 1) for joint in range(joints)]
    (sample,) = samples(rig.tick(target), joints)
    assert sample.state.sequence == rig.sequence
    assert sample.state.mode is Mode.ARMED
    assert sample.measured_counts == (0,) * joints, "read before the joints move"
    assert sample.applied_rad == pytest.approx(target, abs=1e-4)
    assert rig.plant.commands[-1] == (rig.now_s, pytest.approx(sample.applied_rad, abs=1e-4))


def test_any_order_of_frames_does() -> None:
    rig = armed(16)
    shuffler = random.Random(5)
    for sequence in range(1, 30):
        rig.advance(0.01)
        messages = setpoint_messages(sequence, [0.0] * 16, 0.01)
        shuffler.shuffle(messages)
        assert executed(rig, rig.say(*messages)) == [sequence]


def test_a_torn_mix_of_two_ticks_is_never_executed() -> None:
    rig = armed()
    rig.advance(0.01)
    one = setpoint_messages(1, [0.01] * 5, 0.01)
    two = setpoint_messages(2, [-0.01] * 5, 0.01)
    assert not executed(rig, rig.say(one[0], two[1], two[2]))
    assert not executed(rig, rig.say(one[2]))
    assert executed(rig, rig.say(two[0])) == [2]
    mixed = [one[0], replace(one[1], sequence=3), replace(one[2], sequence=3)]  # type: ignore[type-var]
    mixed[0] = replace(two[0], sequence=3)  # type: ignore[type-var]
    rig.advance(0.01)
    assert not executed(rig, rig.say(*mixed)), "the CRC spans the groups"


def test_wrong_joint_count_is_dropped() -> None:
    rig = armed(5)
    rig.advance(0.01)
    for joints in (4, 6):
        assert not executed(rig, rig.say(*setpoint_messages(joints, [0.0] * joints, 0.01)))


def test_duplicates_and_stale_ones_are_dropped_and_do_not_feed_the_watchdog() -> None:
    rig = armed()
    for sequence in (100, 101, 102):
        rig.advance(0.01)
        assert executed(rig, rig.say(*setpoint_messages(sequence, [0.0] * 5, 0.01))) == [sequence]
    for sequence in (102, 101, 100, 102 - 32767, 102 + 32768):
        rig.advance(0.01)
        assert not executed(rig, rig.say(*setpoint_messages(sequence % 65536, [0.0] * 5, 0.01)))
    rig.advance(0.0501)
    assert rig.board.mode is Mode.FAULT


def test_newer_by_up_to_half_the_range() -> None:
    for step, newer in ((1, True), (2, True), (32767, True), (32768, False), (65535, False)):
        rig = armed()
        rig.advance(0.01)
        rig.say(*setpoint_messages(7, [0.0] * 5, 0.01))
        rig.advance(0.01)
        said = rig.say(*setpoint_messages((7 + step) % 65536, [0.0] * 5, 0.01))
        assert bool(executed(rig, said)) is newer


def test_sequence_wraps_at_16_bits_and_groups_at_12() -> None:
    rig = armed()
    rig.sequence = 65536 - 8
    for _ in range(16):
        rig.advance(0.01)
        said = rig.tick([0.0] * 5)
        assert executed(rig, said) == [rig.sequence % 65536]


def test_a_lost_frames_remnant_does_not_meet_the_tick_4096_later() -> None:
    rig = armed()
    rig.advance(0.01)
    rig.say(*setpoint_messages(5, [0.0] * 5, 0.01)[1:])  # the first group is lost
    for sequence in range(6, 4096 + 40):
        rig.advance(0.01)
        assert executed(rig, rig.say(*setpoint_messages(sequence, [0.0] * 5, 0.01))) == [sequence]
    assert rig.board.mode is Mode.ARMED


def test_a_lost_tick_is_superseded_not_repeated() -> None:
    rig = armed()
    rig.advance(0.01)
    rig.tick([0.0] * 5)
    rig.advance(0.02)
    said = rig.tick([0.001] * 5, step=2)
    assert executed(rig, said) == [rig.sequence]


@pytest.mark.parametrize("mode", [Mode.DISARMED, Mode.HOLDING, Mode.STOPPED, Mode.FAULT])
def test_setpoints_are_dropped_in_every_other_mode(mode: Mode) -> None:
    rig = Rig()
    rig.enter(mode)
    before = len(rig.plant.commands)
    for _ in range(3):
        rig.advance(0.01)
        assert not [m for m in rig.tick([0.3] * 5) if isinstance(m, State)]
    assert len(rig.plant.commands) == before
    counters = [m for m in rig.advance(1.0) if isinstance(m, Counters)][-1]
    assert counters.dropped == 3


def test_frames_of_before_arming_do_not_count_after_it() -> None:
    rig = Rig()
    messages = setpoint_messages(1, [0.0] * 5, 0.01)
    rig.say(*messages[:-1])
    rig.go(Mode.ARMED)
    rig.advance(0.01)
    assert not executed(rig, rig.say(messages[-1]))


def test_frames_of_before_holding_do_not_count_after_it() -> None:
    rig = armed()
    rig.advance(0.01)
    messages = setpoint_messages(1, [0.0] * 5, 0.01)
    rig.say(*messages[:-1])
    rig.go(Mode.HOLDING)
    rig.go(Mode.ARMED)
    rig.advance(0.01)
    assert not executed(rig, rig.say(messages[-1]))


def test_holding_takes_the_speed_out() -> None:
    rig = armed(1)
    for number in range(1, 40):
        rig.advance(0.01)
        rig.tick([0.0005 * number**2])
    rig.go(Mode.HOLDING)
    held = rig.board._register.applied_rad
    rig.go(Mode.ARMED)
    rig.advance(0.01)
    rig.tick(held)
    assert rig.board._register.applied_rad == pytest.approx(held, abs=2e-4)


def test_a_burst_after_a_stall_cannot_outrun_the_limits() -> None:
    rig = armed(1)
    rig.stream(0.5)
    rig.advance(0.09)
    start_s, start = rig.now_s, rig.board._register.applied_rad[0]
    for _ in range(40):
        rig.tick([1.5], 0.01)
    reached = rig.board._register.applied_rad[0] - start
    limit = rig.robot.acceleration_limit_rad_s2[0]
    assert rig.now_s == start_s
    assert reached <= limit * 0.12 * 0.12, "no more time can be used than has passed, plus 20 ms"


def test_interval_zero_and_latch_joints_zero_do_nothing() -> None:
    rig = armed(1)
    rig.advance(0.01)
    setpoint, latch = setpoint_messages(1, [0.0], 0.01)
    assert isinstance(setpoint, Setpoint)
    assert isinstance(latch, Latch)
    raw = bytearray(encode(latch).data)
    raw[3] = 0
    rig.board.receive(encode(setpoint), rig.now_s)
    rig.board.receive(Frame(17, bytes(raw)), rig.now_s)
    assert not executed(rig, rig.advance(0.0))
