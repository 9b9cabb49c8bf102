"""How a page ends: with its run, whatever becomes of that; the next run has the port, and an open page shows it."""

from __future__ import annotations

import contextlib
import os
import signal
import time
import urllib.parse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from page_client import PageClient
from viewed_run import ViewedRun, viewed
from websockets.exceptions import ConnectionClosed

from snakebot.errors import EXIT_BOARD_FAULT
from snakebot.runlog import read_log

Start = Callable[..., ViewedRun]
PROBE = ("run", "--probe", "triangle:amplitude_deg=5,rate_deg_s=10,joints=3")


def armed(message: dict[str, Any]) -> bool:
    return (message.get("status") or {}).get("mode") == "armed"


def last_frame(page: PageClient) -> dict[str, Any]:
    """The last frame before the server closes the connection."""
    frame: dict[str, Any] = {}
    with pytest.raises(ConnectionClosed):
        while True:
            message = page.read()
            if message["type"] == "frame":
                frame = message
    return frame


def server_of(run: ViewedRun) -> int:
    children = Path(f"/proc/{run.process.pid}/task/{run.process.pid}/children").read_text().split()
    return int(children[0])


def gone(pid: int, within_s: float = 5.0) -> bool:
    """Whether a process ends within some time."""
    deadline = time.monotonic() + within_s
    while time.monotonic() < deadline:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return True
        if state == "Z":
            return True
        time.sleep(0.02)
    return False


def test_a_run_that_is_killed_takes_its_server_with_it_and_the_page_says_what_holds(start: Start) -> None:
    run = start()
    page = PageClient(run.url)
    page.until(armed)
    server = server_of(run)
    run.process.kill()
    frame = last_frame(page)
    assert frame["status"]["ended"]
    assert "watchdog stops the joints" in frame["status"]["how"]
    assert gone(server)


@pytest.mark.slow
@pytest.mark.real_time
def test_pages_are_told_how_a_run_ended(start: Start) -> None:
    run = start("--ramp", "0.5", "--duration", "2")
    page = PageClient(run.url)
    frame = last_frame(page)
    assert frame["status"]["mode"] == "disarmed"
    assert frame["status"]["how"] == "run finished"
    assert run.ends() == 0


@pytest.mark.slow
@pytest.mark.real_time
def test_the_fault_and_the_boards_mode_are_shown_after_a_stop(start: Start) -> None:
    run = start()
    page = PageClient(run.url)
    page.until(armed)
    page.ask(do="stop")
    frame = last_frame(page)
    assert (frame["status"]["mode"], frame["status"]["ended"]) == ("stopped", True)
    assert "emergency stop: the joints are without power" in frame["status"]["how"]
    assert run.ends() == EXIT_BOARD_FAULT


@pytest.mark.slow
@pytest.mark.real_time
def test_the_next_run_has_the_same_port_at_once(tmp_path: Path) -> None:
    with viewed(tmp_path / "a.mcap", "--ramp", "0.5", "--duration", "2") as first:
        page = PageClient(first.url)
        page.until(armed)
        assert first.ends() == 0
    port = str(urllib.parse.urlsplit(first.url).port)
    with viewed(tmp_path / "b.mcap", "--view-port", port) as second:
        assert second.url == first.url
        assert PageClient(second.url).hello["joints"] == 5


@pytest.mark.slow
@pytest.mark.real_time
def test_a_stopped_server_holds_up_neither_the_run_nor_its_end(start: Start) -> None:
    run = start("--ramp", "0.5", "--duration", "6", "--frames")  # more than the socket holds
    PageClient(run.url).until(armed)
    server = server_of(run)
    os.kill(server, signal.SIGSTOP)
    try:
        assert run.ends() == 0
        assert gone(server)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(server, signal.SIGKILL)
    log = read_log(run.log)
    assert (log.metadata["ended"], len(log.t_s)) == ("finished", 601)


@pytest.mark.slow
@pytest.mark.real_time
def test_a_page_that_reads_nothing_does_not_keep_the_server(start: Start) -> None:
    run = start("--ramp", "0.5", "--duration", "2")
    page = PageClient(run.url)
    server = server_of(run)
    page.connection.socket.setsockopt(1, 8, 1)  # SO_RCVBUF: full at once, and never read again
    assert run.ends() == 0
    assert gone(server)


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.parametrize(
    "words",
    [
        pytest.param(("stop", {"do": "stop"}), id="stop"),
        pytest.param(("ramp down", {"do": "ramp_down"}), id="ramp down"),
    ],
)
def test_what_is_asked_for_before_the_first_tick_is_done(
    words: tuple[str, dict[str, str]], start: Start
) -> None:
    run = start("--ramp", "0.5")
    page = PageClient(run.url)
    assert page.ask(**words[1]) is None
    assert run.ends() == (EXIT_BOARD_FAULT if words[0] == "stop" else 130)


@pytest.mark.slow
@pytest.mark.real_time
def test_a_probe_and_a_replay_have_a_page_without_a_gait(start: Start, tmp_path: Path) -> None:
    run = start(motion=PROBE)
    page = PageClient(run.url)
    frame = page.until(lambda m: armed(m) and m["status"]["t_s"] > 0.3)
    assert frame["status"]["gait"] is None
    refused = page.ask(do="gait", alpha_deg=30, beta_deg=70, omega_rad_s=1, offset_deg=0)
    assert refused == "only a running gait can be changed"
    assert page.ask(do="ramp_down") is None
    assert run.ends() == 130
    with viewed(tmp_path / "again.mcap", motion=("log", "replay", str(run.log))) as replay:
        page = PageClient(replay.url)
        frame = page.until(lambda m: armed(m) and m["status"]["t_s"] > 0.3)
        assert frame["status"]["gait"] is None
        assert page.ask(do="stop") is None
        assert replay.ends() == EXIT_BOARD_FAULT
