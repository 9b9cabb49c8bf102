"""Stored trims and zeros: whole or not at all, and a board that has lost them says so and is not armed."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
from building import FIRMWARE, need
from test_host_program import Ear, program, started

from firmware_protocol.catalogue import (
    Acknowledge,
    BoardHeartbeat,
    Fault,
    Measured,
    Mode,
    ModeRequest,
    Result,
    TrimRequest,
    ZeroRequest,
)

__all__ = ["program"]

HOST = 9
LOADED, NONE, UNREADABLE, NOT_OURS, OTHER_VERSION, DAMAGED = range(6)
PARAMETERS_BYTES = 2 * 16 * 2


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """port/host/parameters.c by itself."""
    need("cc")
    made = tmp_path_factory.mktemp("parameters") / "parameters.so"
    sources = [FIRMWARE / "port/host/parameters.c", FIRMWARE / "core/crc.c"]
    command = [
        "cc",
        "-std=c11",
        "-D_GNU_SOURCE",
        "-fPIC",
        "-shared",
        f"-I{FIRMWARE}",
        f"-I{FIRMWARE / 'core'}",
    ]
    command += [f"-I{FIRMWARE / 'port/host'}", "-o", str(made), *map(str, sources)]
    subprocess.run(command, check=True)
    loaded = ctypes.CDLL(str(made))
    loaded.parameters_write.restype = ctypes.c_bool
    loaded.parameters_say.restype = ctypes.c_char_p
    return loaded


def read(library: Any, path: Path) -> tuple[int, bytes]:
    """What it says of a file, and what it makes of parameters that were all 0x55."""
    held = ctypes.create_string_buffer(b"\x55" * PARAMETERS_BYTES, PARAMETERS_BYTES)
    state = library.parameters_read(str(path).encode(), held)
    return state, held.raw


def write(library: Any, path: Path, parameters: bytes) -> bool:
    done: bool = library.parameters_write(str(path).encode(), parameters)
    return done


def test_what_was_written_is_read(library: Any, tmp_path: Path) -> None:
    path = tmp_path / "parameters"
    assert read(library, path) == (NONE, b"\x55" * PARAMETERS_BYTES)
    for seed in (1, 2):
        parameters = bytes((seed * i) % 256 for i in range(PARAMETERS_BYTES))
        assert write(library, path, parameters)
        assert read(library, path) == (LOADED, parameters)
    assert os.listdir(tmp_path) == ["parameters"], "a temporary file was left"


def test_every_cut_and_every_bit_is_found(library: Any, tmp_path: Path) -> None:
    """Nothing of a file that is not whole is taken."""
    path = tmp_path / "parameters"
    assert write(library, path, bytes(range(PARAMETERS_BYTES)))
    whole = path.read_bytes()
    untouched = b"\x55" * PARAMETERS_BYTES
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        assert read(library, path) == (NOT_OURS, untouched), length
    path.write_bytes(whole + b"\0")
    assert read(library, path) == (NOT_OURS, untouched)
    for bit in range(8 * len(whole)):
        damaged = bytearray(whole)
        damaged[bit // 8] ^= 1 << bit % 8
        path.write_bytes(damaged)
        assert read(library, path) == (NOT_OURS if bit < 32 else DAMAGED, untouched), bit
    path.write_bytes(bytes(PARAMETERS_BYTES))  # as versions before the checksum wrote it
    assert read(library, path) == (NOT_OURS, untouched)


def test_another_version_is_no_damage(library: Any, tmp_path: Path) -> None:
    import zlib

    path = tmp_path / "parameters"
    assert write(library, path, bytes(range(PARAMETERS_BYTES)))
    later = bytearray(path.read_bytes())
    later[4] += 1
    later[-4:] = zlib.crc32(later[:-4]).to_bytes(4, "little")
    path.write_bytes(later)
    assert read(library, path)[0] == OTHER_VERSION


def test_a_write_that_fails_leaves_what_was_there(library: Any, tmp_path: Path) -> None:
    path = tmp_path / "parameters"
    first = bytes(range(PARAMETERS_BYTES))
    assert write(library, path, first)
    (tmp_path / "parameters.new").mkdir()
    assert not write(library, path, bytes(PARAMETERS_BYTES))
    assert read(library, path) == (LOADED, first)
    assert not write(library, tmp_path / "no such folder" / "parameters", first)
    assert read(library, tmp_path) == (UNREADABLE, b"\x55" * PARAMETERS_BYTES)


def arm(ear: Ear) -> Acknowledge:
    ear.say(ModeRequest(7, Mode.ARMED, HOST))
    answer = ear.wait(Acknowledge, token=7)
    assert isinstance(answer, Acknowledge)
    return answer


def test_a_board_that_has_lost_its_zeros_is_not_armed_until_it_is_put_right(
    program: str, tmp_path: Path
) -> None:
    """Cut in mid-file: one line says so, arming is refused, nothing written over; restored and reset, all is well."""
    file = tmp_path / "parameters"
    with started(program, "--parameters", str(file)) as (_, _, fd):
        ear = Ear(fd)
        ear.say(ZeroRequest(1, 1, 100, HOST))
        ear.wait(Acknowledge, token=1)
        assert arm(ear).result is Result.OK
    whole = file.read_bytes()
    file.write_bytes(whole[:-9])
    process = subprocess.Popen(
        [program, "--parameters", str(file)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stderr is not None
    port = process.stdout.readline().strip()
    fd = os.open(port.removeprefix("serial:"), os.O_RDWR | os.O_NOCTTY)
    try:
        ear = Ear(fd)
        for _ in range(2):
            answer = arm(ear)
            assert (answer.result, answer.mode, answer.detail) == (
                Result.FAULTY,
                Mode.DISARMED,
                Fault.INTERNAL,
            )
        beat = ear.wait(BoardHeartbeat)
        assert isinstance(beat, BoardHeartbeat)
        assert (beat.mode, beat.powered) == (Mode.DISARMED, 0)
        ear.say(TrimRequest(3, 1, 0.01, HOST))
        ear.wait(Acknowledge, token=3)
        assert arm(ear).result is Result.FAULTY, "a trim of one joint does not bring back the others"
        assert file.read_bytes() == whole[:-9], "what could still be saved by hand was written over"
        file.write_bytes(whole)
        process.send_signal(signal.SIGUSR1)
        ear.wait(Measured, first_counts=-100)
        deadline = time.monotonic() + 10.0
        while arm(ear).result is not Result.OK:
            assert time.monotonic() < deadline
    finally:
        os.close(fd)
        process.terminate()
        process.wait(10.0)
        said = process.stderr.read().splitlines()
        process.stdout.close()
        process.stderr.close()
    assert process.returncode == 0
    assert len(said) == 2, said
    assert str(file) in said[0]
    assert "arming is refused" in said[0]
    assert "not written over" in said[1]
