"""What is left of a log when the process is killed or the disk is full."""

from __future__ import annotations

import json
import os
import random
import shlex
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from log_victim import MOST
from runlog_samples import ROBOT, assert_equals_ticks, make_ticks
from samples import sample

from snakebot.runlog import RunLog, RunWriter, read_log
from snakebot.runlog.finish import finish

VICTIM = Path(__file__).with_name("log_victim.py")
MAY_BE_LOST_S = 0.5


def _start(what: str, path: Path, seed: int) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, str(VICTIM), what, str(path), str(seed)], stdout=subprocess.PIPE)


def _kill_while_writing(path: Path, seed: int) -> None:
    chance = random.Random(seed)
    victim = _start("kill", path, seed)
    assert victim.stdout is not None
    told = victim.stdout.read(16)  # the first tick is handed over
    time.sleep(chance.uniform(0.0, 1.2))
    killed_ns = time.monotonic_ns()
    victim.send_signal(signal.SIGKILL)
    told += victim.stdout.read()
    victim.wait()
    handed_over = dict(struct.iter_unpack("<qq", told[: len(told) // 16 * 16]))

    log = read_log(path.with_name(path.name + ".part"))
    assert not log.complete
    assert_equals_ticks(log, make_ticks(MOST, seed=seed))
    safe = {number for number, at_ns in handed_over.items() if at_ns < killed_ns - MAY_BE_LOST_S * 1e9}
    assert safe <= set(log.sequence.tolist())
    np.testing.assert_array_equal(log.sequence, range(len(log.sequence)))  # and no hole before the end

    RunWriter(path.with_name("next.mcap"), ROBOT).close()  # the next run needs no clean-up
    _recovered_equals(log, path)


def _recovered_equals(log: RunLog, path: Path) -> None:
    finish(log.path, path)
    recovered = read_log(path)
    assert recovered.complete
    assert recovered.problems == ()
    assert not log.path.exists()
    for name in (
        "sequence",
        "t_s",
        "host_time_ns",
        "setpoint_rad",
        "sent_rad",
        "applied_rad",
        "measured_rad",
    ):
        np.testing.assert_array_equal(getattr(recovered, name), getattr(log, name))
    assert recovered.metadata == log.metadata
    assert recovered.attachments == log.attachments


@pytest.mark.parametrize("seed", range(3))
def test_killed_while_writing(tmp_path: Path, seed: int) -> None:
    _kill_while_writing(tmp_path / "run.mcap", seed)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_killed_while_writing_at_many_moments(tmp_path: Path) -> None:
    for seed in range(100, 100 + sample(50, 17)):
        folder = tmp_path / str(seed)
        folder.mkdir()
        _kill_while_writing(folder / "run.mcap", seed)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_killed_while_closing(tmp_path: Path) -> None:
    """The log is whole under one of its two names at every moment."""
    for seed in range(sample(30, 10)):
        path = tmp_path / f"run{seed}.mcap"
        part = path.with_name(path.name + ".part")
        victim = _start("close", path, seed)
        assert victim.stdout is not None
        assert victim.stdout.read(7) == b"closing"
        time.sleep(random.Random(seed).uniform(0.0, 0.06))
        victim.send_signal(signal.SIGKILL)
        victim.wait()
        for name in (path, part):
            if name.exists():
                log = read_log(name)
                assert_equals_ticks(log, make_ticks(MOST, seed=seed))
                if name == path:
                    assert log.complete
                    assert len(log.sequence) == 400
        assert path.exists() or part.exists()


def _limit_file_size() -> None:
    import resource

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (120_000, 120_000))


def test_a_file_that_may_not_grow(tmp_path: Path) -> None:
    """The same path as a full disk (a write that fails half-way), without needing to be root."""
    pytest.importorskip("resource", reason="needs a POSIX system")
    command = [sys.executable, str(VICTIM), "fill", str(tmp_path / "run.mcap"), "5"]
    done = subprocess.run(command, capture_output=True, preexec_fn=_limit_file_size, check=True)
    _check_filled(json.loads(done.stdout), "File too large")


def test_disk_full(tmp_path: Path) -> None:
    """A real tmpfs of 160 KiB fills up."""
    if os.geteuid() != 0:
        pytest.skip("a small tmpfs can only be mounted by root; test_a_file_that_may_not_grow stands in")
    victim = shlex.join([sys.executable, str(VICTIM), "fill", str(tmp_path / "disk" / "run.mcap"), "6"])
    (tmp_path / "disk").mkdir()
    mount = shlex.join(["mount", "-t", "tmpfs", "-o", "size=160k", "tmpfs", str(tmp_path / "disk")])
    done = subprocess.run(
        ["unshare", "-m", "sh", "-c", f"{mount} || exit 77; exec {victim}"], capture_output=True
    )
    if done.returncode == 77:
        pytest.skip(f"no tmpfs can be mounted here: {done.stderr.decode().strip()}")
    assert done.returncode == 0, done.stderr.decode()
    _check_filled(json.loads(done.stdout), "No space left on device")


def _check_filled(result: dict[str, object], why: str) -> None:
    said, rows, measured = str(result["said"]), result["rows"], result["measured"]
    assert why in said
    assert "\n" not in said
    assert result["closed_as"] == "run.mcap.part"
    assert isinstance(rows, list)
    assert isinstance(measured, list)
    assert rows == list(range(len(rows)))
    assert 50 < len(rows) <= int(str(result["handed_over"]))
    assert result["problems"] == []
    ticks = make_ticks(MOST, seed=6 if "space" in why else 5)
    for number, angles in zip(rows, measured, strict=True):
        wanted = ticks[number].measured_rad
        np.testing.assert_array_equal(angles, np.full(5, np.nan) if wanted is None else wanted)
