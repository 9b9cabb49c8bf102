"""Real processes that are stopped in mid-run, and hosts whose sleeps end late."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from snakebot.runlog import read_log

pytestmark = [pytest.mark.slow, pytest.mark.real_time]

SNAKEBOT = [sys.executable, "-m", "snakebot.cli.main"]
GAIT = ["--alpha", "66", "--beta", "80", "--omega", "2", "--json"]
ALSO_ITS_OWN_S = 0.5  # what a busy computer may add to the standstills that are made here


@pytest.fixture(autouse=True)
def runtime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


@pytest.fixture
def board() -> Iterator[str]:
    """The port of a simulated board in a process of its own, on a pseudo-terminal."""
    process = subprocess.Popen([*SNAKEBOT, "board", "sim", "--serial"], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield process.stdout.readline().strip().removeprefix("--port ")
    process.kill()
    process.wait()


def start(*arguments: str, log: Path, command: list[str] = SNAKEBOT) -> subprocess.Popen[str]:
    """A run that has been moving for a moment."""
    host = subprocess.Popen(
        [*command, "run", *GAIT, *arguments, "--log", str(log)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        process_group=0,  # a job of this process: of a group without a parent the kernel ignores SIGTSTP
    )  # fmt: skip
    part = log.with_name(log.name + ".part")
    deadline = time.monotonic() + 60
    while not (part.exists() and part.stat().st_size > 60_000):
        assert host.poll() is None, host.communicate()
        assert time.monotonic() < deadline, "the run did not start"
        time.sleep(0.05)
    return host


def stall(host: subprocess.Popen[str], stall_s: float, stop: signal.Signals) -> None:
    host.send_signal(stop)
    time.sleep(stall_s)
    host.send_signal(signal.SIGCONT)


@pytest.mark.parametrize(
    ("stall_s", "stop"),
    [(0.12, signal.SIGSTOP), (0.3, signal.SIGSTOP), (1.5, signal.SIGSTOP), (1.0, signal.SIGTSTP)],
)
def test_the_simulated_board_stands_still_with_its_host(
    stall_s: float, stop: signal.Signals, tmp_path: Path
) -> None:
    """SIGTSTP is what Ctrl-Z sends, and SIGCONT what fg does."""
    host = start("--duration", "6", log=tmp_path / "a.mcap")
    for _ in range(3):
        stall(host, stall_s, stop)
        time.sleep(0.4)
    out, said = host.communicate(timeout=60)
    assert host.returncode == 0, said
    summary = json.loads(out)
    assert summary["standstills"] >= 3
    assert 3 * stall_s - 0.05 < summary["stood_still_s"] < 3 * stall_s + ALSO_ITS_OWN_S
    assert summary["ticks"] + summary["skipped"] == 601
    assert "of motion: this computer could not run the simulation all the time" in said
    log = read_log(tmp_path / "a.mcap")
    assert log.metadata["standstill"]["total_s"] == pytest.approx(summary["stood_still_s"], abs=0.001)
    assert [event.kind for event in log.events].count("standstill") >= 1
    gaps_s = np.diff(log.host_time_ns) * 1e-9  # the wall clock went on
    assert np.sort(gaps_s)[-3] > stall_s - 0.02
    assert np.diff(log.t_s).max() < 0.1


def test_a_board_elsewhere_does_not_wait(board: str, tmp_path: Path) -> None:
    """Its watchdog stops the joints, and the host says why."""
    host = start("--duration", "30", "--port", board, log=tmp_path / "a.mcap")
    stall(host, 1.5, signal.SIGSTOP)
    _, said = host.communicate(timeout=60)
    assert host.returncode == 5, said
    (line,) = [line for line in said.splitlines() if line.startswith("snakebot: ")]
    assert "watchdog stopped the joints" in line
    assert "this computer stood still for 1." in line


OVERSLEEP = """
import sys, time
from snakebot.clock import MonotonicClock
sleep_until = MonotonicClock.sleep_until

def late(clock, t_s):  # also where the wait for answers before it was late by itself: no tick starts on time
    sleep_until(clock, t_s + float(sys.argv[1]))

MonotonicClock.sleep_until = late
from snakebot.cli.main import main
main(sys.argv[2:])
"""


def oversleeping(late_s: float) -> list[str]:
    return [sys.executable, "-c", OVERSLEEP, str(late_s)]


def test_a_host_that_is_always_a_little_late_drives_on_and_says_so_once(board: str, tmp_path: Path) -> None:
    host = start("--duration", "6", "--port", board, log=tmp_path / "a.mcap", command=oversleeping(0.006))
    out, said = host.communicate(timeout=60)
    assert host.returncode == 0, said
    assert said.count("warning") == said.count("ticks start up to") == 1, said
    summary = json.loads(out)
    assert summary["late"] > 300
    assert [event.kind for event in read_log(tmp_path / "a.mcap").events].count("late") == 1


def test_a_host_that_is_late_by_more_than_half_the_watchdog_gives_up(board: str, tmp_path: Path) -> None:
    host = subprocess.run(
        [*oversleeping(0.06), "run", *GAIT, "--port", board, "--log", str(tmp_path / "a.mcap")],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert host.returncode == 7, host.stderr
    assert "lower --rate" in host.stderr
    info = subprocess.run([*SNAKEBOT, "board", "info", board, "--json"], capture_output=True, text=True)
    assert json.loads(info.stdout)["mode"] == "disarmed"
