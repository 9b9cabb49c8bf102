"""slcan: our lines against python-can's, and both ends on a bad line."""

from __future__ import annotations

import os
import select
import threading
import time
import tty
from collections.abc import Iterator

import can
import pytest
from can.interfaces.slcan import slcanBus
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.frame import Frame
from snakebot.links.slcan import SlcanDecoder, format_all, format_frame, parse_frame
from snakebot.links.slcan_adapter import SlcanAdapter

FRAMES = st.builds(Frame, st.integers(0, 0x7FF), st.binary(max_size=8))


@pytest.fixture
def pty() -> Iterator[tuple[int, str]]:
    master, slave = os.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    os.close(slave)
    os.close(master)


def test_the_adapter_serves_python_can(pty: tuple[int, str]) -> None:
    """python-can's own slcan bus, which knows nothing of ours, on the other side."""
    master, path = pty
    adapter = SlcanAdapter()
    heard: list[Frame] = []
    done = threading.Event()

    def serve() -> None:
        while not done.is_set():
            if not select.select([master], [], [], 0.02)[0]:
                continue
            frames = adapter.feed(os.read(master, 4096))
            heard.extend(frames)
            os.write(master, adapter.answer() + adapter.pack(Frame(f.id ^ 1, f.data[::-1]) for f in frames))

    thread = threading.Thread(target=serve)
    thread.start()
    sent = [Frame(16 + k, bytes(range(k))) for k in range(9)]
    try:
        with slcanBus(channel=path, bitrate=1_000_000, sleep_after_open=0) as bus:
            for frame in sent:
                bus.send(can.Message(arbitration_id=frame.id, data=frame.data, is_extended_id=False))
            bus.send(can.Message(arbitration_id=0x12345678, data=b"other", is_extended_id=True))
            bus.send(can.Message(arbitration_id=0x12, is_remote_frame=True, is_extended_id=False))
            received = [bus.recv(5.0) for _ in sent]
            assert bus.get_version(5.0) == (10, 13)
            assert bus.get_serial_number(5.0) is not None
        deadline = time.monotonic() + 5.0
        while adapter.open and time.monotonic() < deadline:  # python-can says C when it goes
            time.sleep(0.01)
    finally:
        done.set()
        thread.join(5.0)
    assert heard == sent
    assert [Frame(m.arbitration_id, bytes(m.data)) for m in received if m] == [
        Frame(f.id ^ 1, f.data[::-1]) for f in sent
    ]
    assert adapter.corrupt == 0
    assert not adapter.open


@given(FRAMES)
def test_a_frame_is_the_line_that_the_format_says(frame: Frame) -> None:
    line = format_frame(frame)
    assert line == f"t{frame.id:03X}{len(frame.data)}{frame.data.hex().upper()}\r".encode()
    assert parse_frame(line[:-1]) == frame
    assert parse_frame(line[:-1].lower()) == frame
    assert parse_frame(line[:-1] + b"1A2B") == frame  # with a time stamp


@given(st.lists(FRAMES, max_size=20), st.integers(1, 40))
def test_frames_come_back_in_pieces_of_any_size(frames: list[Frame], size: int) -> None:
    data = format_all(frames)
    decoder = SlcanDecoder()
    pieces = [data[k : k + size] for k in range(0, len(data), size)]
    assert [frame for piece in pieces for frame in decoder.feed(piece)] == frames
    assert decoder.corrupt == 0


@given(st.binary(max_size=400), FRAMES)
def test_noise_costs_its_own_line_alone(noise: bytes, frame: Frame) -> None:
    for end in (SlcanDecoder(), SlcanAdapter()):
        if isinstance(end, SlcanAdapter):
            end.feed(b"O\r")
        end.feed(noise + b"\r")
        if isinstance(end, SlcanAdapter):
            end.feed(b"O\r")  # the noise may have closed it
        assert end.feed(format_frame(frame)) == [frame]


def test_what_is_others_business_is_passed_over() -> None:
    decoder = SlcanDecoder()
    lines = b"T1234567821122\rr0123\rR123456780\rz\rZ\r\rV1013\rd12381122334455667788\r"
    assert decoder.feed(lines) == []
    assert decoder.corrupt == 0


@pytest.mark.parametrize("line", [b"t", b"t12", b"t8001", b"t12391", b"t1232AB", b"t1231GG", b"t1231AB1"])
def test_broken_lines_are_counted(line: bytes) -> None:
    decoder = SlcanDecoder()
    assert decoder.feed(line + b"\r") == []
    assert decoder.corrupt == 1


def test_a_refusal_is_counted() -> None:
    decoder = SlcanDecoder()
    assert decoder.feed(b"\a") == []
    assert decoder.corrupt == 1


def test_a_line_that_never_ends_takes_no_memory() -> None:
    decoder = SlcanDecoder()
    for _ in range(100):
        decoder.feed(b"t" * 1000)
        assert len(decoder._cutter._pending) <= 143
    assert decoder.feed(b"\r" + format_frame(Frame(1, b"x"))) == [Frame(1, b"x")]
    assert decoder.corrupt == 1


class TestAdapter:
    def ask(self, adapter: SlcanAdapter, line: bytes) -> bytes:
        adapter.feed(line)
        return adapter.answer()

    def test_nothing_passes_while_the_channel_is_closed(self) -> None:
        adapter = SlcanAdapter()
        assert adapter.pack([Frame(32, b"x")]) == b""
        assert adapter.feed(b"t01010A\r") == []
        assert adapter.answer() == b"\a"
        assert self.ask(adapter, b"O\r") == b"\r"
        assert adapter.pack([Frame(32, b"x")]) == b"t020178\r"
        assert adapter.feed(b"t01010A\r") == [Frame(16, b"\n")]
        assert adapter.answer() == b"z\r"
        assert self.ask(adapter, b"C\r") == b"\r"
        assert adapter.pack([Frame(32, b"x")]) == b""

    def test_who_only_listens_cannot_send(self) -> None:
        adapter = SlcanAdapter()
        assert self.ask(adapter, b"L\r") == b"\r"
        assert adapter.feed(b"t0100\r") == []
        assert adapter.answer() == b"\a"
        assert adapter.pack([Frame(32, b"")]) == b"t0200\r"

    def test_it_takes_what_python_can_says_at_the_start(self) -> None:
        adapter = SlcanAdapter()
        for line in (b"C\r", b"S8\r", b"\r", b"O\r", b"O\r"):
            assert self.ask(adapter, line) == b"\r"
        adapter = SlcanAdapter()
        for line in (b"C\r", b"S8\r", b"Y5\r", b"O\r", b"O\r"):
            assert self.ask(adapter, line) == b"\r"

    @pytest.mark.parametrize(
        "line", [b"?\r", b"S\r", b"Sx\r", b"OO\r", b"t01010\r", b"T123\r", b"\xff\xfe\r"]
    )
    def test_nonsense_is_refused_and_counted(self, line: bytes) -> None:
        adapter = SlcanAdapter()
        adapter.feed(b"O\r")
        adapter.answer()
        assert adapter.feed(line) == []
        assert adapter.answer() == b"\a"
        assert adapter.corrupt == 1
