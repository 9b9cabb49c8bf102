"""Real processes and a real pseudo-terminal: hosts stopped, killed and hung up, and a board that goes away."""

from __future__ import annotations

import json
import os
import pty
import select
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from firmware_protocol.catalogue import Mode
from snakebot.board import Board
from snakebot.clock import MonotonicClock
from snakebot.links.opening import open_link
from snakebot.runlog import open_run, read_log

pytestmark = [pytest.mark.slow, pytest.mark.real_time]

SNAKEBOT = [sys.executable, "-m", "snakebot.cli.main"]
GAIT = ["--alpha", "40", "--beta", "60", "--omega", "2", "--duration", "60"]


@pytest.fixture
def board() -> Iterator[tuple[subprocess.Popen[str], str]]:
    process = subprocess.Popen([*SNAKEBOT, "board", "sim", "--tcp", "0"], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield process, process.stdout.readline().strip().removeprefix("--port ")
    process.kill()
    process.wait()


def run(port: str, log: Path, **how: Any) -> subprocess.Popen[bytes]:
    host: subprocess.Popen[bytes] = subprocess.Popen(
        [*SNAKEBOT, "run", "--port", port, *GAIT, "--log", str(log)],
        stderr=subprocess.PIPE, stdout=subprocess.PIPE, **how,
    )  # fmt: skip
    deadline = time.monotonic() + 60
    assert host.stderr is not None
    while mode(port) is not Mode.ARMED:
        assert host.poll() is None, host.stderr.read()
        assert time.monotonic() < deadline, "the run did not start"
    time.sleep(1.0)
    return host


def mode(port: str) -> Mode | None:
    """Seen by a second host, which listens only."""
    link = open_link(port)
    try:
        listener = Board(link, MonotonicClock())
        listener.connect()
        return listener.mode
    finally:
        link.close()


def safe(port: str) -> bool:
    """Within 0.1 s of the board's time; the listener's handshake takes longer than that."""
    return mode(port) in (Mode.FAULT, Mode.STOPPED, Mode.DISARMED)


def test_kill_9(board: tuple[subprocess.Popen[str], str], tmp_path: Path) -> None:
    host = run(board[1], tmp_path / "a.mcap")
    host.kill()
    host.wait()
    time.sleep(0.1)
    assert safe(board[1])
    (log,) = tmp_path.glob("a.mcap*")
    assert len(open_run(log).t_s) > 20


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_signals_ramp_down(number: int, board: tuple[subprocess.Popen[str], str], tmp_path: Path) -> None:
    host = run(board[1], tmp_path / "a.mcap")
    host.send_signal(number)
    _, said = host.communicate(timeout=30)
    assert b"Traceback" not in said
    assert host.returncode == 130, said
    assert mode(board[1]) is Mode.DISARMED
    assert len(open_run(tmp_path / "a.mcap").t_s) > 50


def test_stopped_for_two_seconds(board: tuple[subprocess.Popen[str], str], tmp_path: Path) -> None:
    host = run(board[1], tmp_path / "a.mcap")
    host.send_signal(signal.SIGSTOP)
    time.sleep(0.2)
    assert mode(board[1]) is Mode.FAULT
    time.sleep(1.8)
    host.send_signal(signal.SIGCONT)
    _, said = host.communicate(timeout=30)
    assert host.returncode == 5, said
    assert b"watchdog stopped the joints" in said
    assert b"Traceback" not in said
    assert len(open_run(tmp_path / "a.mcap").t_s) > 20


def test_a_board_that_goes_away(board: tuple[subprocess.Popen[str], str], tmp_path: Path) -> None:
    host = run(board[1], tmp_path / "a.mcap")
    board[0].kill()
    _, said = host.communicate(timeout=30)
    assert host.returncode == 4, said
    assert b"Traceback" not in said
    assert len(open_run(tmp_path / "a.mcap").t_s) > 20


def test_a_board_that_hangs(board: tuple[subprocess.Popen[str], str], tmp_path: Path) -> None:
    """Its process stands still, watchdog and all: the host ends by itself; the board is safe once it goes on."""
    host = run(board[1], tmp_path / "a.mcap")
    board[0].send_signal(signal.SIGSTOP)
    _, said = host.communicate(timeout=30)
    board[0].send_signal(signal.SIGCONT)
    assert host.returncode == 4, said
    assert b"Traceback" not in said
    assert safe(board[1])
    assert len(open_run(tmp_path / "a.mcap").t_s) > 20


def test_a_pseudo_terminal_that_is_closed(tmp_path: Path) -> None:
    process = subprocess.Popen([*SNAKEBOT, "board", "sim", "--serial"], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    port = process.stdout.readline().strip().removeprefix("--port ")
    log = tmp_path / "a.mcap"
    host = subprocess.Popen(
        [*SNAKEBOT, "run", "--port", port, *GAIT, "--log", str(log)],
        stderr=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    deadline = time.monotonic() + 60
    while not log.with_name("a.mcap.part").exists():
        assert host.poll() is None, host.stderr
        assert time.monotonic() < deadline, "the run did not start"
        time.sleep(0.05)
    time.sleep(2)
    process.kill()
    _, said = host.communicate(timeout=30)
    process.wait()
    assert host.returncode == 4, said
    assert b"Traceback" not in said
    assert b"check cable" in said
    assert len(open_run(log).t_s) > 20


BUS_GOES_DOWN = """
ip link set lo up && ip route add 239.0.0.0/8 dev lo || exit 77
"$0" -m snakebot.cli.main board sim --can udp_multicast/239.74.163.2 >"$1/board" 2>&1 & board=$!
trap 'kill $board' EXIT
while ! grep -q port "$1/board"; do sleep 0.1; done
"$0" -m snakebot.cli.main run --port can:udp_multicast/239.74.163.2 --alpha 40 --beta 60 --omega 2 --duration 60 \
    --log "$1/a.mcap" 2>"$1/said" & host=$!
while [ ! -e "$1/a.mcap.part" ]; do sleep 0.1; done
sleep 2
ip link set lo down
wait $host; echo "status $?"
ip link set lo up && ip route add 239.0.0.0/8 dev lo
"$0" -m snakebot.cli.main board info can:udp_multicast/239.74.163.2 --json
"""


def test_a_bus_that_goes_down(tmp_path: Path) -> None:
    """A CAN bus over multicast in a network of its own; the board lives on and is asked afterwards."""
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        pytest.skip("unshare or ip is missing")
    done = subprocess.run(
        ["unshare", "-n" if os.getuid() == 0 else "-rn", "sh", "-c", BUS_GOES_DOWN, sys.executable, str(tmp_path)],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    if "status" not in done.stdout:
        pytest.skip(f"no network namespace can be made here: {done.stderr}")
    status, info = done.stdout.splitlines()
    said = (tmp_path / "said").read_text()
    assert status == "status 4", said
    assert "Traceback" not in said
    assert json.loads(info)["mode"] == "fault"
    assert len(open_run(tmp_path / "a.mcap").t_s) > 20


@pytest.mark.parametrize("shell", [False, True], ids=["alone", "under an interactive shell"])
def test_a_terminal_that_is_closed(
    shell: bool, board: tuple[subprocess.Popen[str], str], tmp_path: Path
) -> None:
    """It ramps down, holds and relaxes, and its log is whole: terminal and shell both send SIGHUP, and nothing that is
    written to the dead terminal stops it.
    """
    log = tmp_path / "a.mcap"
    words = [*SNAKEBOT, "run", "--port", board[1], *GAIT, "--log", str(log)]
    if shell and shutil.which("bash") is None:
        pytest.skip("no bash")
    master, slave = pty.openpty()
    host = subprocess.Popen(
        ["bash", "--norc", "-i"] if shell else words,
        stdin=slave, stdout=slave, stderr=slave, start_new_session=True,
        preexec_fn=lambda: __import__("fcntl").ioctl(0, __import__("termios").TIOCSCTTY, 0),
    )  # fmt: skip
    os.close(slave)
    closed = threading.Event()
    window = threading.Thread(target=be_a_terminal, args=(master, closed))
    window.start()
    if shell:
        os.write(master, f"{shlex.join(words)}\n".encode())
    deadline = time.monotonic() + 60
    while mode(board[1]) is not Mode.ARMED:
        assert time.monotonic() < deadline
    time.sleep(3)
    closed.set()
    window.join()
    host.wait(30)
    while not log.exists():  # the shell may be gone first
        assert time.monotonic() < deadline
        time.sleep(0.05)
    read = read_log(log)
    assert mode(board[1]) is Mode.DISARMED
    assert [event.kind for event in read.events][-4:] == ["stopping", "holding", "disarmed", "interrupted"]
    (stopping,) = [event for event in read.events if event.kind == "stopping"]
    assert read.t_s[-1] - stopping.t_s > 1.5  # the whole ramp


def be_a_terminal(master: int, closed: threading.Event) -> None:
    """Read what is written, or the writer would wait; then close the window."""
    while not closed.is_set():
        if select.select([master], [], [], 0.05)[0]:
            os.read(master, 65536)
    os.close(master)


def test_a_second_host_is_refused_and_told_who_holds_the_board(
    board: tuple[subprocess.Popen[str], str],
    tmp_path: Path,
    stop_only: Callable[..., subprocess.CompletedProcess[str]],
) -> None:
    host = run(board[1], tmp_path / "a.mcap")
    second = subprocess.run([*SNAKEBOT, "run", "--port", board[1], *GAIT], capture_output=True, text=True)
    assert second.returncode == 5, second.stderr
    assert "holds it" in second.stderr
    stop = stop_only([host.pid], "--port", board[1])
    assert stop.returncode == 0, stop.stderr
    _, said = host.communicate(timeout=30)
    assert host.returncode in (5, 130), (
        said,
        stop.stderr,
    )  # the run here is told too, and may hear that first
    assert mode(board[1]) in (Mode.STOPPED, Mode.DISARMED)
