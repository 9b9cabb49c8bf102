"""COBS and CRC on a serial line: what is sent comes back, and no noise gets through or stays."""

from __future__ import annotations

import binascii
import random
from itertools import pairwise

import pytest
from cobs import cobs
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.frame import Frame, ProtocolError
from firmware_protocol.framing import MAX_ENCODED, StreamDecoder, crc16, pack, pack_all, unpack

FRAMES = st.builds(Frame, st.integers(0, 0x7FF), st.binary(max_size=8))


def crc16_by_its_definition(data: bytes) -> int:
    """CRC-16/CCITT-FALSE bit by bit (Rocksoft parameters: 16, 1021, FFFF, false, false, 0000)."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


def cut(data: bytes, at: list[int]) -> list[bytes]:
    edges = sorted({0, len(data), *(position % (len(data) + 1) for position in at)})
    return [data[start:end] for start, end in pairwise(edges)]


def test_the_check_value_of_the_crc() -> None:
    assert crc16(b"123456789") == 0x29B1


@given(st.binary(max_size=40))
def test_the_crc_is_the_one_it_says(data: bytes) -> None:
    assert crc16(data) == crc16_by_its_definition(data) == binascii.crc_hqx(data, 0xFFFF)


@given(FRAMES)
def test_a_packet_is_cobs_of_id_payload_and_crc(frame: Frame) -> None:
    packet = pack(frame)
    assert packet[-1] == 0
    assert 0 not in packet[:-1]
    assert len(packet) <= MAX_ENCODED + 1
    body = cobs.decode(packet[:-1])
    assert body[:2] == frame.id.to_bytes(2, "little")
    assert body[2:-2] == frame.data
    assert int.from_bytes(body[-2:], "little") == crc16_by_its_definition(body[:-2])
    assert unpack(packet[:-1]) == frame


@given(st.lists(FRAMES, max_size=20), st.lists(st.integers(0, 10_000), max_size=20))
def test_frames_come_back_however_the_stream_is_cut(frames: list[Frame], cuts: list[int]) -> None:
    decoder = StreamDecoder()
    received = [frame for part in cut(pack_all(frames), cuts) for frame in decoder.feed(part)]
    assert received == frames
    assert decoder.corrupt == 0


@given(st.lists(FRAMES, min_size=1, max_size=6), st.integers(0, 50), st.integers(0, 20))
def test_extra_zeros_change_nothing(frames: list[Frame], where: int, count: int) -> None:
    packets = [pack(frame) for frame in frames]
    packets.insert(where % (len(packets) + 1), bytes(count))
    decoder = StreamDecoder()
    assert decoder.feed(b"".join(packets)) == frames
    assert decoder.corrupt == 0


@given(st.binary(max_size=200), st.lists(FRAMES, min_size=1, max_size=4))
@settings(derandomize=True)  # one random packet in 65536 has a CRC that agrees
def test_noise_before_a_batch_costs_nothing_of_it(noise: bytes, frames: list[Frame]) -> None:
    decoder = StreamDecoder()
    decoder.feed(noise)
    assert decoder.feed(pack_all(frames))[-len(frames) :] == frames


@given(FRAMES, st.integers(0, 12), st.integers(1, 255))
@settings(max_examples=400, derandomize=True)
def test_a_changed_byte_in_a_packet_costs_that_packet_alone(frame: Frame, where: int, change: int) -> None:
    before, after = Frame(0x123, b"before"), Frame(0x456, b"after")
    packet = bytearray(pack(frame))
    packet[where % (len(packet) - 1)] ^= change
    decoder = StreamDecoder()
    received = decoder.feed(pack(before) + bytes(packet) + pack(after))
    assert received == [before, after]
    assert 1 <= decoder.corrupt <= 2  # a byte that becomes zero makes two of one


@given(FRAMES, st.integers(0, 12))
@settings(derandomize=True)
def test_a_lost_byte_costs_at_most_two_packets(frame: Frame, where: int) -> None:
    before, between, after = Frame(1, b"1"), Frame(2, b"2"), Frame(3, b"3")
    packet = bytearray(pack(frame))
    del packet[where % len(packet)]
    decoder = StreamDecoder()
    received = decoder.feed(pack(before) + bytes(packet) + pack(between) + pack(after))
    assert received in ([before, between, after], [before, after])
    assert decoder.corrupt == 1


def test_what_gets_through_a_very_bad_line_was_sent() -> None:
    """A line that damages every second packet: about one wrong frame in 65536 damaged ones may pass a 16-bit CRC."""
    noise = random.Random(7)
    sent: set[Frame] = set()
    decoder = StreamDecoder()
    received: list[Frame] = []
    damaged = 0
    for _ in range(20_000):
        frame = Frame(noise.randrange(0x800), noise.randbytes(noise.randrange(9)))
        sent.add(frame)
        packet = bytearray(pack(frame))
        if noise.random() < 0.5:
            damaged += 1
            for _ in range(noise.randrange(1, 5)):
                packet[noise.randrange(len(packet))] = noise.randrange(256)
        position = noise.randrange(len(packet))
        received += [*decoder.feed(bytes(packet[:position])), *decoder.feed(bytes(packet[position:]))]
    wrong = [frame for frame in received if frame not in sent]
    assert len(wrong) <= 3
    assert len(received) > 0.4 * 20_000
    assert decoder.corrupt > 0.5 * damaged


@given(st.lists(st.binary(min_size=1, max_size=300).map(lambda b: b.replace(b"\0", b"\1")), max_size=20))
def test_a_line_that_never_ends_takes_no_memory(parts: list[bytes]) -> None:
    decoder = StreamDecoder()
    for part in parts:
        assert decoder.feed(part) == []
        assert len(decoder._pending) <= MAX_ENCODED
    frame = Frame(5, b"after")
    assert decoder.feed(b"\0" + pack(frame))[-1] == frame
    assert decoder.corrupt == (1 if parts else 0)


@pytest.mark.parametrize("frame", [Frame(0x800, b""), Frame(-1, b""), Frame(1, bytes(9))])
def test_what_is_no_frame_is_not_packed(frame: Frame) -> None:
    with pytest.raises(ProtocolError, match="no frame of this protocol"):
        pack(frame)


@pytest.mark.parametrize(
    "body", [b"", b"\1\0", b"\1", bytes(13), (0x800).to_bytes(2, "little") + b"x", b"\xff\xff"]
)
def test_a_packet_with_a_right_crc_but_no_frame_inside_is_refused(body: bytes) -> None:
    packet = cobs.encode(body + crc16(body).to_bytes(2, "little"))
    if body == b"\1\0":
        assert unpack(packet) == Frame(1, b"")  # the shortest that is one
        return
    with pytest.raises(ProtocolError):
        unpack(packet)


def test_bytes_that_are_not_cobs_are_refused() -> None:
    with pytest.raises(ProtocolError, match="not COBS"):
        unpack(b"\x05ab")
