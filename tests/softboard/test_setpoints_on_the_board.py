"""Set-points: what reaches the joints of them. What a host sees is asked by the conformance suite."""

from __future__ import annotations

import struct
import zlib

import pytest
from board_rig import Rig, bench, samples

from firmware_protocol.assembly import setpoint_messages
from firmware_protocol.catalogue import Latch, Message, Mode, Setpoint, encode, frame_id
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
    commanded_s, commanded_rad = rig.plant.commands[-1]
    assert commanded_s == rig.now_s
    assert commanded_rad == pytest.approx(sample.applied_rad, abs=1e-4)


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


def test_the_lowest_integer_of_an_angle_is_an_angle() -> None:
    """-32768 is in the range of the DBC, and no angle that a host of ours sends: it is limited as any other."""
    rig = armed()
    rig.advance(0.01)
    raw = [-32768, 0, 0, 0, 0]
    for group, part in enumerate((raw[:3], [*raw[3:], 0])):
        data = struct.pack("<H3h", 1 | group << 12, *part)
        rig.board.receive(Frame(frame_id(Setpoint), data), rig.now_s)
    crc = zlib.crc32(struct.pack("<HB5h", 1, 5, *raw))
    (sample,) = samples(rig.say(Latch(1, 5, 0.01, crc)), 5)
    assert sample.state.sequence == 1
    assert -0.1 < sample.applied_rad[0] < 0
    assert sample.applied_rad[1:] == (0.0,) * 4
