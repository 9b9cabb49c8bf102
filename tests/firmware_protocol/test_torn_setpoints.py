"""Set-points and samples are put together whole or not at all, whatever the wire does to their frames."""

from __future__ import annotations

import random
import struct
import zlib
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.assembly import (
    ANGLE_STEP_RAD,
    SampleAssembler,
    SetpointAssembler,
    groups,
    sample_messages,
    setpoint_crc,
    setpoint_messages,
    to_wire,
)
from firmware_protocol.catalogue import Applied, Latch, Measured, Mode, Setpoint, State, decode, encode
from firmware_protocol.frame import Frame, ProtocolError

JOINTS = st.integers(1, 16)
ANGLE = st.integers(-32767, 32767).map(lambda raw: raw * ANGLE_STEP_RAD)


def raw(angles: tuple[float, ...] | list[float]) -> list[int]:
    return [round(angle / ANGLE_STEP_RAD) for angle in angles]


def through_wire(messages: list[Any]) -> list[Any]:
    return [decode(encode(message)) for message in messages]


@given(
    JOINTS.flatmap(lambda n: st.lists(ANGLE, min_size=n, max_size=n)), st.integers(0, 0xFFFF), st.randoms()
)
def test_a_whole_tick_is_released_in_any_order_of_its_frames(
    angles: list[float], sequence: int, order: random.Random
) -> None:
    messages = through_wire(setpoint_messages(sequence, angles, 0.01))
    assert len(messages) == groups(len(angles)) + 1
    order.shuffle(messages)
    assembler = SetpointAssembler(len(angles))
    results = [assembler.add(message) for message in messages]
    assert results[:-1] == [None] * (len(messages) - 1)
    assert results[-1] is not None
    latch, released = results[-1]
    assert latch.sequence == sequence
    assert raw(released) == raw(angles)
    assert assembler.dropped == 0


@st.composite
def disturbed_ticks(draw: st.DrawFn) -> tuple[int, dict[int, list[int]], list[Any]]:
    """Ticks in order, and their frames as a bad wire delivers them: lost, doubled, swapped with what is near."""
    joints = draw(JOINTS)
    start = draw(st.integers(0, 0xFFFF))
    steps = draw(st.lists(st.sampled_from([1, 1, 1, 2, 4096, 4095, 4097]), min_size=1, max_size=8))
    noise = draw(st.randoms(use_true_random=False))
    sent: dict[int, list[int]] = {}
    frames: list[Any] = []
    sequence = start
    for step in steps:
        sequence = (sequence + step) & 0xFFFF
        angles = [noise.randrange(-32767, 32768) for _ in range(joints)]
        sent[sequence] = angles
        frames += setpoint_messages(sequence, [angle * ANGLE_STEP_RAD for angle in angles], 0.01)
    loss, double, shift = draw(st.sampled_from([(0.0, 0.0, 0), (0.3, 0.1, 3), (0.1, 0.3, 12), (0.5, 0.0, 0)]))
    kept = [frame for frame in frames if noise.random() >= loss]
    kept += [frame for frame in kept if noise.random() < double]
    places = {id(frame): place + noise.randint(0, shift) for place, frame in enumerate(frames)}
    kept.sort(key=lambda frame: places[id(frame)])
    return joints, sent, kept


@settings(max_examples=150, deadline=None)
@given(disturbed_ticks())
def test_nothing_but_a_tick_that_was_sent_is_ever_released(
    case: tuple[int, dict[int, list[int]], list[Any]],
) -> None:
    joints, sent, frames = case
    assembler = SetpointAssembler(joints)
    for frame in through_wire(frames):
        result = assembler.add(frame)
        if result is not None:
            latch, angles = result
            assert raw(angles) == sent[latch.sequence]
        assert len(assembler._parts) <= 4


@settings(max_examples=300, deadline=None, derandomize=True)  # one CRC-32 in four billion agrees by chance
@given(
    st.lists(ANGLE, min_size=5, max_size=5),
    st.integers(0, 0xFFFF),
    st.integers(0, 2),
    st.integers(0, 63),
    st.data(),
)
def test_a_flipped_bit_that_no_frame_check_saw_is_not_executed(
    angles: list[float], sequence: int, which: int, bit: int, data: st.DataObject
) -> None:
    frames = [encode(message) for message in setpoint_messages(sequence, angles, 0.01)]
    bits = int.from_bytes(frames[which].data, "little") ^ (1 << bit)
    if data.draw(st.booleans()):
        bits ^= 1 << data.draw(st.integers(0, 63))
    changed = Frame(frames[which].id, bits.to_bytes(8, "little"))
    same = changed == frames[which]
    frames[which] = changed
    assembler = SetpointAssembler(5)
    for frame in frames:
        try:
            result = assembler.add(decode(frame))  # type: ignore[arg-type]
        except ProtocolError:
            continue
        if (
            result is not None
        ):  # what the checks do not span: the interval, and the unused place of a sixth joint
            latch, released = result
            assert raw(released) == raw(angles)
            assert latch.sequence == sequence
            spared = decode(changed)
            assert same or isinstance(spared, Latch) or (isinstance(spared, Setpoint) and spared.group == 1)


def test_frames_of_neighbouring_ticks_never_mix() -> None:
    """Every way of taking each frame of a tick from one of two ticks: only the two pure ones are released."""
    old, new = ([0.1] * 5, [0.2] * 5)
    first = setpoint_messages(7, old, 0.01)
    second = setpoint_messages(7, new, 0.01)  # as after a wrap of the number: the CRC alone keeps them apart
    for choice in range(8):
        chosen = [second[k] if choice >> k & 1 else first[k] for k in range(3)]
        assembler = SetpointAssembler(5)
        result = [assembler.add(message) for message in chosen][-1]  # type: ignore[arg-type]
        assert (result is not None) == (choice in (0, 7))
        if result is None:
            assert assembler.dropped == 1


def test_a_remnant_does_not_meet_the_tick_4096_later() -> None:
    assembler = SetpointAssembler(3)
    remnant = setpoint_messages(10, [1.0] * 3, 0.01)[0]
    assert assembler.add(remnant) is None  # type: ignore[arg-type]
    for message in setpoint_messages(11, [0.5] * 3, 0.01):
        assembler.add(message)  # type: ignore[arg-type]
    assert assembler.dropped == 1  # given up when a newer one was complete
    latch = setpoint_messages(10 + 4096, [0.7] * 3, 0.01)[-1]
    assert assembler.add(latch) is None  # type: ignore[arg-type]


def test_the_crc_is_over_sequence_joints_and_raw_angles() -> None:
    """PROTOCOL.md: CRC-32 over `sequence u16 | joints u8 | joints x i16`, little-endian."""
    expected = zlib.crc32(struct.pack("<HB3h", 0xABCD, 3, 1000, -2000, 0))
    assert setpoint_crc(0xABCD, [0.1, -0.2, 0.0]) == expected


def test_a_latch_of_another_joint_count_is_not_executed() -> None:
    assembler = SetpointAssembler(5)
    frames = setpoint_messages(1, [0.1] * 6, 0.01)  # as many groups as five joints have
    assert [assembler.add(frame) for frame in frames][-1] is None  # type: ignore[arg-type]
    assert assembler.dropped == 1


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf"), 3.28, -3.28])
def test_an_angle_that_the_wire_cannot_carry_is_refused(bad: float) -> None:
    with pytest.raises(ProtocolError):
        to_wire(bad)
    with pytest.raises(ProtocolError):
        setpoint_messages(1, [0.0, bad], 0.01)


@pytest.mark.parametrize("joints", [0, 17])
def test_joint_counts_that_the_wire_cannot_carry_are_refused(joints: int) -> None:
    with pytest.raises(ProtocolError, match="1 to 16"):
        setpoint_messages(1, [0.0] * joints, 0.01)


@given(st.floats(-3.2767, 3.2767))
def test_what_the_wire_carries_is_within_half_a_step(angle: float) -> None:
    assert abs(to_wire(angle) - angle) <= ANGLE_STEP_RAD / 2 + 1e-12
    assert to_wire(to_wire(angle)) == to_wire(angle)


COUNTS = st.none() | st.integers(-32767, 32767)


@given(
    JOINTS.flatmap(lambda n: st.tuples(*[st.lists(s, min_size=n, max_size=n) for s in (COUNTS, ANGLE)])),
    st.randoms(),
)
def test_a_whole_sample_is_released_in_any_order(
    readings: tuple[list[int | None], list[float]], order: random.Random
) -> None:
    counts, applied = readings
    state = State(3, 77, Mode.ARMED, 123_456)
    messages = through_wire(sample_messages(state, counts, applied))
    order.shuffle(messages)
    assembler = SampleAssembler(len(counts))
    *before, sample = [assembler.add(message) for message in messages]
    assert before == [None] * (len(messages) - 1)
    assert sample is not None
    assert sample.state == state
    assert list(sample.measured_counts) == counts
    assert raw(sample.applied_rad) == raw(applied)


@given(st.integers(-(10**6), 10**6))
def test_counts_beyond_16_bits_are_no_reading(count: int) -> None:
    frames = sample_messages(State(0, 0, Mode.ARMED, 0), [count], [0.0])
    assembler = SampleAssembler(1)
    sample = [assembler.add(message) for message in frames][-1]  # type: ignore[arg-type]
    assert sample is not None
    assert sample.measured_counts == ((count,) if abs(count) <= 32767 else (None,))


@settings(max_examples=200, deadline=None)
@given(
    st.integers(1, 16),
    st.integers(0, 4095),
    st.randoms(use_true_random=False),
    st.sampled_from([0.0, 0.2, 0.6]),
)
def test_a_sample_never_mixes_frames_of_two(
    joints: int, start: int, noise: random.Random, loss: float
) -> None:
    """Each sample carries its own number everywhere: a mix would show."""
    assembler = SampleAssembler(joints)
    released = 0
    for number in range(start, start + 12):
        mark = number % 1000
        state = State(number, number & 0xFFF, Mode.ARMED, mark)
        for message in sample_messages(state, [mark] * joints, [mark * ANGLE_STEP_RAD] * joints):
            if noise.random() < loss:
                continue
            assert isinstance(message, State | Measured | Applied)
            sample = assembler.add(message)
            if sample is not None:
                released += 1
                assert sample.measured_counts == (sample.state.board_time_us,) * joints
                assert raw(sample.applied_rad) == [sample.state.board_time_us] * joints
    if loss == 0:
        assert released == 12
        assert assembler.dropped == 0
