"""``diagnose --live`` on a board in another process, stopped in mid-run: the robot is safe, nothing is half-written."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from snakebot.runlog import open_session

SNAKEBOT = [sys.executable, "-m", "snakebot.cli.main"]


@pytest.fixture
def port() -> Iterator[str]:
    words = [
        *SNAKEBOT,
        "board",
        "sim",
        "--serial",
        "--json",
        "--effect",
        "rate_limit:limit_rad_s=1.2,joints=3",
        "--watchdog-ms",
        "250",
    ]
    board = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert board.stdout is not None
    try:
        yield str(json.loads(board.stdout.readline())["port"])
    finally:
        board.terminate()
        board.wait(20)


def info(port: str) -> dict[str, Any]:
    done = subprocess.run(
        [*SNAKEBOT, "board", "info", port, "--json"], capture_output=True, text=True, check=True
    )
    told: dict[str, Any] = json.loads(done.stdout)
    return told


def wait_for(path: Path, pattern: str, process: subprocess.Popen[str]) -> bool:
    """False where the process ends before."""
    while not list(path.glob(pattern)):
        if process.poll() is not None:
            return False
        time.sleep(0.05)
    return True


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.timeout(600)
def test_ctrl_c_leaves_a_safe_robot_and_whole_logs(port: str, tmp_path: Path) -> None:
    room = tmp_path / "room"
    room.mkdir()
    status, out, said = interrupted(room, port)
    assert status == 130, said
    assert out == ""
    assert "holds 2 logs: snakebot diagnose" in said
    assert "Traceback" not in said
    assert {f.name for f in room.iterdir()} == {"logs"}  # no verdict, no page, no part of one
    assert {f.name for f in (room / "logs").iterdir()} == {"live_01.mcap", "live_02.mcap"}
    first, second = open_session(room / "logs").runs
    assert first.duration_s == pytest.approx(12.0, abs=0.5)
    assert second.duration_s < 11.0
    assert info(port)["mode"] == "disarmed"


def interrupted(room: Path, port: str) -> tuple[int, str, str]:
    """A live diagnosis that gets a Ctrl-C early in its second run: exit status, standard output, what it said."""
    words = [*SNAKEBOT, "diagnose", "--live", str(room / "logs"), "--port", port, "--yes"]
    words += ["--json", str(room / "verdict.json"), "--report", str(room / "verdict.html")]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if not wait_for(room / "logs", "*02*", process):
        return (process.returncode, *process.communicate())
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    out, said = process.communicate(timeout=120)
    return process.returncode, out, said


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.timeout(600)
def test_a_board_that_dies_in_mid_run_ends_it(tmp_path: Path) -> None:
    board = subprocess.Popen(
        [*SNAKEBOT, "board", "sim", "--serial", "--watchdog-ms", "250", "--json"],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert board.stdout is not None
    port = json.loads(board.stdout.readline())["port"]
    logs = tmp_path / "logs"
    words = [
        *SNAKEBOT,
        "diagnose",
        "--live",
        str(logs),
        "--port",
        port,
        "--yes",
        "--json",
        str(tmp_path / "v.json"),
    ]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert wait_for(logs, "*01*", process)
    time.sleep(1.0)
    board.kill()
    board.wait(20)
    out, said = process.communicate(timeout=120)
    assert process.returncode == 4, said
    assert out == ""
    assert "Traceback" not in said
    assert not (tmp_path / "v.json").exists()
