"""The board as a Linux program: its options, its signals, and lines that are no slcan."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from building import BUILD, make

from firmware_protocol.catalogue import (
    Acknowledge,
    BoardHeartbeat,
    InfoFirmware,
    InfoProtocol,
    InfoRequest,
    InfoSerial,
    Measured,
    Message,
    Mode,
    ZeroRequest,
    decode,
    encode,
)
from firmware_protocol.framing import StreamDecoder, pack_all

PATIENCE_S = 10.0


@pytest.fixture(scope="module")
def program() -> str:
    make("sanitized")
    return str(BUILD / "snakebot_board_sanitized")


@contextmanager
def started(program: str, *options: str) -> Iterator[tuple[subprocess.Popen[str], str, int]]:
    """The process, the port that it prints, and an open descriptor of its pseudo-terminal."""
    process = subprocess.Popen([program, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stderr is not None
    port = process.stdout.readline().strip()
    device = port.partition("?")[0].removeprefix("serial:").removeprefix("can:slcan/")
    fd = os.open(device, os.O_RDWR | os.O_NOCTTY)
    try:
        yield process, port, fd
    finally:
        os.close(fd)
        process.terminate()
        process.wait(PATIENCE_S)
        errors = process.stderr.read()
        process.stdout.close()
        process.stderr.close()
    assert process.returncode == 0, errors
    assert not errors


class Ear:
    def __init__(self, fd: int) -> None:
        self.fd = fd
        self._decoder = StreamDecoder()
        self._heard: deque[Message] = deque()

    def say(self, *messages: Message) -> None:
        os.write(self.fd, pack_all([encode(message) for message in messages]))

    def wait(self, kind: type[Message], **values: object) -> Message:
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            while self._heard:
                message = self._heard.popleft()
                if isinstance(message, kind) and all(getattr(message, k) == v for k, v in values.items()):
                    return message
            if select.select([self.fd], [], [], 0.1)[0]:
                self._heard += map(decode, self._decoder.feed(os.read(self.fd, 65536)))
        raise AssertionError(f"no {kind.__name__} {values}")


def test_options_reach_the_board(program: str) -> None:
    options = ("--joints", "7", "--counts", "4096", "--serial-number", "12345678901", "--start", "45")
    with started(program, *options) as (_, port, fd):
        assert port.startswith("serial:/dev/")
        ear = Ear(fd)
        ear.say(InfoRequest(1))
        protocol, firmware, serial = ear.wait(InfoProtocol), ear.wait(InfoFirmware), ear.wait(InfoSerial)
        assert isinstance(protocol, InfoProtocol)
        assert (protocol.joints, protocol.simulated) == (7, 1)
        assert isinstance(firmware, InfoFirmware)
        assert firmware.counts_per_rev == 4096
        assert isinstance(serial, InfoSerial)
        assert serial.serial_number == 12345678901
        ear.wait(Measured, first_counts=512)


def test_a_seed_makes_boot_ids_repeatable(program: str) -> None:
    seen = []
    for options in (("--seed", "5"), ("--seed", "5"), (), ()):
        with started(program, *options) as (_, _, fd):
            beat = Ear(fd).wait(BoardHeartbeat)
            assert isinstance(beat, BoardHeartbeat)
            seen.append(beat.boot_id)
    assert seen[0] == seen[1]
    assert len(set(seen)) >= 2


def test_signals_reset_and_stop(program: str) -> None:
    with started(program) as (process, _, fd):
        ear = Ear(fd)
        before = ear.wait(BoardHeartbeat)
        assert isinstance(before, BoardHeartbeat)
        process.send_signal(signal.SIGUSR1)
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            beat = ear.wait(BoardHeartbeat)
            assert isinstance(beat, BoardHeartbeat)
            if beat.boot_id != before.boot_id:
                break
        else:
            raise AssertionError("the boot id has not changed")
        process.send_signal(signal.SIGUSR2)
        ear.wait(BoardHeartbeat, mode=Mode.STOPPED)


def test_parameters_are_kept_in_a_file(program: str, tmp_path: Path) -> None:
    file = tmp_path / "parameters"
    for _ in range(2):
        with started(program, "--parameters", str(file)) as (_, _, fd):
            ear = Ear(fd)
            if not file.exists():
                ear.say(ZeroRequest(1, 1, 100, 9))
                ear.wait(Acknowledge)
            ear.wait(Measured, first_counts=-100)


@pytest.mark.parametrize(
    "options",
    [("--joints", "17"), ("--joints", "0"), ("--joints", "two"), ("--counts", "15"), ("--speed-limit", "nan"),
     ("--nonsense",), ("extra",), ("--start", "1e999")],
)  # fmt: skip
def test_nonsense_is_refused_in_one_line(program: str, options: tuple[str, ...]) -> None:
    done = subprocess.run(
        [program, *options], capture_output=True, text=True, check=False, timeout=PATIENCE_S
    )
    assert done.returncode == 2
    assert options[0] in done.stderr or "usage" in done.stderr
    assert not done.stdout


def test_lines_that_are_no_slcan_are_answered_with_a_bell(program: str) -> None:
    with started(program, "--slcan") as (_, port, fd):
        assert port.startswith("can:slcan//dev/")

        def hear_until(end: bytes) -> bytes:
            heard = b""
            deadline = time.monotonic() + PATIENCE_S
            while end not in heard.upper():
                assert time.monotonic() < deadline, f"no {end!r} in {heard!r}"
                if select.select([fd], [], [], 0.1)[0]:
                    heard += os.read(fd, 65536)
            return heard

        os.write(fd, b"t0504deadbeef\r")
        assert hear_until(b"\a") == b"\a", "the channel is closed"
        for line in (b"C\r", b"S8\r", b"\r"):
            os.write(fd, line)
            assert hear_until(b"\r") == b"\r"
        os.write(fd, b"O\r")
        for line in (
            b"x",
            b"t05",
            b"t0509" + b"00" * 9,
            b"tzzz0",
            b"t0501gg",
            b"t8000",
            b"t0502ab",
            b"a" * 99,
        ):
            os.write(fd, line + b"\r")
            assert hear_until(b"\a").count(b"\a") == 1, line
        os.write(fd, b"t0504DEADBEEF\r")
        hear_until(b"T0518DEADBEEF")
