"""``snakebot view --port``: a page beside a run that another program makes, which does not notice it but for a STOP."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from pathlib import Path

import pytest
from page_client import PageClient
from viewed_run import PROGRAM, WAVE, served

from snakebot.errors import EXIT_BOARD_FAULT
from snakebot.runlog import read_log

Port = tuple[str, ...]


def moving(message: dict[str, object]) -> bool:
    rows = message.get("rows")
    return isinstance(rows, list) and any(abs(angle or 0) > 10 for row in rows for angle in row[3])


@pytest.mark.slow
@pytest.mark.real_time
def test_a_run_is_seen_and_stopped_by_somebody_else(board: Port, tmp_path: Path) -> None:
    log = tmp_path / "run.mcap"
    run = subprocess.Popen(
        [*PROGRAM, *WAVE, *board, "--log", str(log), "--json"], stderr=subprocess.PIPE, text=True
    )
    try:
        with served("view", *board, "--view-port", "0") as (onlooker, url):
            page = PageClient(url)
            assert page.hello["onlooker"]
            frame = page.until(moving, 20.0)
            assert None not in frame["rows"][-1][2]
            _, wanted, executed, _ = frame["rows"][-1]
            assert wanted == pytest.approx(executed, abs=1.0)  # what that run asks its board for, deg
            assert page.until(lambda m: m.get("rms_deg") and None not in m["rms_deg"])
            assert frame["pose"] is not None
            assert page.until(lambda m: (m.get("status") or {}).get("mode") == "armed")
            refused = page.ask(do="ramp_down")
            assert refused == "this page looks on: only the program that drives the robot can do that"
            assert page.ask(do="stop") is None
            page.until(lambda m: (m.get("status") or {}).get("mode") == "stopped")
            told = [
                event["message"] for event in PageClient(url).until(lambda m: bool(m.get("events")))["events"]
            ]
            assert told[-1] == "emergency stop: the joints are without power"
            _, errors = run.communicate(timeout=20)
            assert run.returncode == EXIT_BOARD_FAULT
            assert "another host" not in errors
            os.kill(onlooker.pid, signal.SIGINT)
            assert onlooker.wait(15) == 0
    finally:
        run.kill()
        run.communicate()
    recorded = read_log(log)
    assert not [event for event in recorded.events if event.kind == "other_host"]


@pytest.mark.slow
@pytest.mark.real_time
def test_a_board_that_nobody_drives_is_seen_and_its_loss_is_told(tmp_path: Path) -> None:
    words = [*PROGRAM, "board", "sim", "--tcp", "0", "--json"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    port = json.loads(process.stdout.readline())["port"]
    with served("view", "--port", port, "--view-port", "0") as (onlooker, url):
        page = PageClient(url)
        page.until(lambda m: (m.get("status") or {}).get("mode") == "disarmed")
        process.terminate()
        process.communicate()
        frame = page.until(lambda m: bool((m.get("status") or {}).get("ended")))
        assert "the line was lost" in frame["status"]["how"]
        assert onlooker.wait(15) == 4


@pytest.mark.slow
@pytest.mark.real_time
def test_a_serial_port_that_a_run_has_is_told_with_what_to_do(tmp_path: Path) -> None:
    words = [*PROGRAM, "board", "sim", "--serial", "--watchdog-ms", "250", "--json"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    port = json.loads(process.stdout.readline())["port"]
    try:
        with served(*WAVE, "--port", port, "--log", str(tmp_path / "x.mcap"), "--view", "--view-port", "0"):
            done = subprocess.run([*PROGRAM, "view", "--port", port], capture_output=True, text=True)
    finally:
        process.terminate()
        process.communicate()
    assert done.returncode == 3
    assert "start that run with `snakebot run --view`" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((), "give a LOG to play, or --port"),
        (("x.mcap", "--port", "sim:"), "give a LOG to play, or --port"),
        (("--port", "sim:"), "lives inside its run"),
        (("x.mcap", "--robot", "penn_state"), "--robot goes with --port"),
        (("x.mcap",), "no such log"),
    ],
)
def test_what_cannot_be_shown_is_told_in_one_line(words: tuple[str, ...], says: str, tmp_path: Path) -> None:
    done = subprocess.run([*PROGRAM, "view", *words], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 2
    assert says in done.stderr
    assert done.stderr.count("\n") == 1
