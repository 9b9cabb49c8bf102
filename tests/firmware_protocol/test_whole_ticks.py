"""A tick that is taken in one go is the tick that its frames make, and whatever is not whole is left to them."""

from __future__ import annotations

import json
import math
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import firmware_protocol
from firmware_protocol.assembly import (
    ANGLE_STEP_RAD,
    LARGEST,
    Sample,
    SampleAssembler,
    SetpointAssembler,
    raw_angles,
    sample_frames,
    setpoint_frames,
)
from firmware_protocol.catalogue import Mode, Ping, PoseMotion, PosePosition, State, decode, encode
from firmware_protocol.frame import Frame, ProtocolError
from firmware_protocol.framing import Packed, StreamDecoder, pack, pack_all
from firmware_protocol.tick_kernels import count
from firmware_protocol.whole_tick import AnswerReader, AnswerWriter, SetpointReader, SetpointWriter

VECTORS = json.loads((Path(firmware_protocol.__file__).parent / "vectors.json").read_text())

joints = st.integers(1, 16)
seeds = st.integers(0, 1 << 32)
ODD = [0.0, -0.0, 3.2767, -3.2767, 5e-5, -5e-5, 1.5e-4, 2.5e-4, 1e-9]


def some_angles(draw: random.Random, size: int) -> list[float]:
    return [draw.choice([*ODD, draw.uniform(-3.2767, 3.2767), draw.gauss(0, 1e-3)]) for _ in range(size)]


def setpoint(draw: random.Random, size: int) -> tuple[int, list[float], float, list[Frame]]:
    sequence, interval_s = draw.randrange(1 << 16), 0.0005 * draw.randint(1, 255)
    angles = some_angles(draw, size)
    return sequence, angles, interval_s, setpoint_frames(sequence, raw_angles(angles), interval_s)


def answer(draw: random.Random, size: int, *, pose: bool) -> list[Frame]:
    state = State(
        draw.randrange(1 << 16), draw.randrange(1 << 12), draw.choice(list(Mode)), draw.randrange(1 << 32)
    )
    counts = [draw.choice([None, 0, -1, LARGEST, -LARGEST, draw.randint(-9999, 9999)]) for _ in range(size)]
    frames = sample_frames(state, counts, some_angles(draw, size))
    if pose:
        where = PosePosition(state.sample, draw.uniform(-838, 838), draw.uniform(-838, 838))
        frames += [
            encode(where),
            encode(PoseMotion(state.sample, draw.uniform(-83, 83), draw.uniform(-83, 83))),
        ]
    return frames


def as_assembled(frames: list[Frame], size: int) -> list[tuple[int, float, tuple[float, ...]]]:
    """The set-points that the frames make."""
    assembler = SetpointAssembler(size)
    done = [complete for frame in frames if (complete := assembler.take(frame)) is not None]
    return [(latch.sequence, latch.interval_s, angles) for latch, angles in done]


def as_sampled(frames: list[Frame], size: int) -> list[Sample]:
    assembler = SampleAssembler(size)
    samples = [
        assembler.take(frame) for frame in frames if not isinstance(decode(frame), PosePosition | PoseMotion)
    ]
    return [sample for sample in samples if sample is not None]


def disturbed(draw: random.Random, frames: list[Frame]) -> bytes:
    """Bytes of frames that something has happened to."""
    changed = list(frames)
    match draw.randrange(6):
        case 0:
            del changed[draw.randrange(len(changed))]
        case 1:
            changed.insert(draw.randrange(len(changed) + 1), draw.choice(changed))
        case 2:
            changed.insert(draw.randrange(len(changed) + 1), encode(Ping(draw.randrange(1 << 32))))
        case 3:
            draw.shuffle(changed)
        case 4:  # one bit of a payload, with a CRC that is right again
            at = draw.randrange(len(changed))
            data = bytearray(changed[at].data)
            data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
            changed[at] = Frame(changed[at].id, bytes(data))
        case _:
            at = draw.randrange(len(changed))
            changed[at] = Frame(changed[at].id, changed[at].data[: draw.randrange(8)])
    line = bytearray(pack_all(changed))
    if draw.random() < 0.5:
        line[draw.randrange(len(line))] = draw.randrange(256)
    if draw.random() < 0.2:
        del line[draw.randrange(len(line)) :]
    return bytes(line)


@given(joints, seeds)
def test_a_setpoint_is_written_as_its_frames(size: int, seed: int) -> None:
    draw = random.Random(seed)
    sequence, angles, interval_s, frames = setpoint(draw, size)
    written = SetpointWriter(size).write(sequence, angles, interval_s)
    assert written is not None
    packed, carried = written
    assert packed.data == pack_all(frames)
    assert list(packed) == frames
    assert len(packed) == len(frames)
    assert carried == tuple(raw * ANGLE_STEP_RAD for raw in raw_angles(angles))


@given(joints, seeds)
def test_a_setpoint_is_read_as_its_frames(size: int, seed: int) -> None:
    draw = random.Random(seed)
    *_, frames = setpoint(draw, size)
    draw.shuffle(frames)
    reader = SetpointReader(size)
    data = b"".join(b"\0" * draw.randrange(3) + pack(frame) for frame in frames)
    read = reader.read(data)
    assert read is not None
    assert [(*read, tuple(reader.angles_rad.tolist()))] == as_assembled(frames, size)


@given(joints, seeds)
def test_what_is_no_whole_setpoint_is_left_to_its_frames(size: int, seed: int) -> None:
    draw = random.Random(seed)
    data = disturbed(draw, setpoint(draw, size)[-1])
    reader = SetpointReader(size)
    read = reader.read(data)
    if read is not None:
        decoder = StreamDecoder()
        frames = list(decoder.feed(data))
        assert decoder.corrupt == 0
        assert [(*read, tuple(reader.angles_rad.tolist()))] == as_assembled(frames, size)
        assert len({frame.data for frame in frames}) == len(frames), "nothing is left over"


@given(joints, seeds, st.booleans())
def test_an_answer_is_read_as_its_frames(size: int, seed: int, pose: bool) -> None:
    frames = answer(random.Random(seed), size, pose=pose)
    read = AnswerReader(size).read(pack_all(frames))
    assert read is not None
    assert [read.sample] == as_sampled(frames, size)
    if pose:
        position, motion = decode(frames[-2]), decode(frames[-1])
        assert isinstance(position, PosePosition)
        assert isinstance(motion, PoseMotion)
        assert read.pose == (position.x_m, position.y_m, motion.heading_rad, motion.speed_m_s)
    else:
        assert read.pose is None


@given(joints, seeds, st.booleans())
def test_what_is_no_whole_answer_is_left_to_its_frames(size: int, seed: int, pose: bool) -> None:
    draw = random.Random(seed)
    data = disturbed(draw, answer(draw, size, pose=pose))
    read = AnswerReader(size).read(data)
    if read is not None:
        decoder = StreamDecoder()
        frames = list(decoder.feed(data))
        assert decoder.corrupt == 0
        assert [read.sample] == as_sampled(frames, size)


@given(joints, seeds)
def test_an_answer_is_written_as_its_frames(size: int, seed: int) -> None:
    draw = random.Random(seed)
    state = (
        draw.randrange(1 << 16),
        draw.randrange(1 << 12),
        draw.choice(list(Mode)),
        draw.randrange(1 << 32),
    )
    counts = [draw.choice([None, 0, 40000, -40000, 10**30, draw.randint(-9999, 9999)]) for _ in range(size)]
    servo, trim = np.array(some_angles(draw, size)), np.array([draw.uniform(-0.3, 0.3) for _ in range(size)])
    applied = [min(max(angle, -LARGEST * ANGLE_STEP_RAD), LARGEST * ANGLE_STEP_RAD) for angle in servo - trim]
    pose = draw.choice([None, (1.0, -2.0, math.pi, 0.1), (839.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, math.nan)])
    frames = sample_frames(State(*state), counts, applied)
    if pose is not None and pose[0] == 1.0:
        frames += [encode(PosePosition(state[1], *pose[:2])), encode(PoseMotion(state[1], *pose[2:]))]
    written = AnswerWriter(size).write(state, counts, servo, trim, pose)
    assert written.data == pack_all(frames)
    assert list(written) == frames


def test_what_the_wire_cannot_carry_is_not_written() -> None:
    writer = SetpointWriter(2)
    for bad in (math.nan, math.inf, -math.inf, 3.27676, -3.27676, 1e300):
        assert writer.write(1, [0.0, bad], 0.01) is None
    for interval_s in (math.nan, 0.0, 0.0004, 0.1281, -0.01):
        assert writer.write(1, [0.0, 0.0], interval_s) is None
    assert writer.write(1, [0.0], 0.01) is None
    with pytest.raises(ProtocolError, match="no angle"):
        AnswerWriter(1).write((1, 1, 1, 1), [0], np.array([math.nan]), np.zeros(1), None)


def test_a_mode_without_a_name_is_left_to_its_frames() -> None:
    frames = answer(random.Random(1), 3, pose=False)
    unnamed = bytearray(frames[0].data)
    unnamed[3] |= 0xF0
    assert AnswerReader(3).read(pack_all([Frame(frames[0].id, bytes(unnamed)), *frames[1:]])) is None


@pytest.mark.parametrize("vector", VECTORS["ticks"], ids=lambda vector: f"{len(vector['angles_rad'])}")
def test_the_golden_vectors(vector: dict[str, Any]) -> None:
    angles, sequence = vector["angles_rad"], vector["sequence"]
    written = SetpointWriter(len(angles)).write(sequence, angles, vector["interval_s"])
    assert written is not None
    assert [frame.data.hex() for frame in written[0]] == [shown["payload"] for shown in vector["frames"]]
    reader = SetpointReader(len(angles))
    read = reader.read(written[0].data)
    assert read is not None
    assert read[0] == sequence
    assert read[1] == pytest.approx(vector["interval_s"])
    assert reader.angles_rad.tolist() == pytest.approx(angles, abs=1e-9)


@given(seeds)
def test_a_quickened_decoder_hears_and_counts_the_same(seed: int) -> None:
    """Whatever comes, in whatever pieces."""
    draw = random.Random(seed)
    stream = b"".join(
        draw.choice(
            [
                pack_all(setpoint(draw, 5)[-1]),
                pack_all(answer(draw, 5, pose=True)),
                disturbed(draw, answer(draw, 5, pose=False)),
                draw.randbytes(draw.randrange(20)),
                pack_all([Frame(draw.randrange(0x800), draw.randbytes(draw.randrange(9))) for _ in range(3)]),
                bytes(draw.randrange(3)),
            ]
        )
        for _ in range(8)
    )
    plain, quick = StreamDecoder(), StreamDecoder().quicken()
    while stream:
        size = draw.choice([1, 7, 14, 43, 44, 128, len(stream)])
        part, stream = stream[:size], stream[size:]
        heard = quick.feed(part)
        assert list(heard) == plain.feed(part)
        assert len(heard) == len(list(heard))
        assert quick.corrupt == plain.corrupt


@given(st.integers(0, 0x7FF), st.binary(max_size=8))
def test_every_frame_is_counted(identifier: int, data: bytes) -> None:
    packet = pack(Frame(identifier, data))
    assert count(packet) == 1
    assert count(packet[:-1]) == -1
    assert list(Packed(packet, 1)) == [Frame(identifier, data)]
    assert pack_all(Packed(packet, 1)) == b"\0" + packet


@given(st.binary(max_size=40))
def test_bytes_that_are_no_packets_are_not_counted(data: bytes) -> None:
    decoder = StreamDecoder()
    heard = decoder.feed(data)
    whole = count(data)
    assert whole == (len(heard) if decoder.corrupt == 0 and (not data or data[-1] == 0) else -1)
