"""``snakebot stop``: told only what is true, and never locked out."""

from __future__ import annotations

import fcntl
import os
import select
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest

from firmware_protocol.catalogue import HostHeartbeat, Mode, encode
from firmware_protocol.frame import Frame
from firmware_protocol.framing import pack_all
from snakebot.board import stopping
from snakebot.cli import stop as stop_command
from snakebot.cli.main import main
from snakebot.clock import MonotonicClock
from snakebot.links.base import Link
from snakebot.robot import load_robot
from snakebot.softboard import PtyEnd, SoftBoard, TcpEnd, serve

PATIENCE_S = 20.0

# A run of which only the ear is there: it ends with the stop signal, or never.
RUN = """
import fcntl, os, signal, sys, time
from pathlib import Path
from snakebot.control import registry
registry.SHARED = (Path(sys.argv[1]),)
heard = []
signal.signal(signal.SIGUSR1, lambda *_: heard.append(1))
if len(sys.argv) > 3:
    held = os.open(sys.argv[3], os.O_RDWR | os.O_NOCTTY)
    fcntl.flock(held, fcntl.LOCK_EX)
with registry.registered("serial:/dev/robot"):
    print("ready", flush=True)
    while not heard or sys.argv[2] == "deaf":
        time.sleep(0.005)
time.sleep(0.3)  # its log is being closed
"""


@contextmanager
def run(places: Path, kind: str = "obeys", device: str = "") -> Iterator[subprocess.Popen[str]]:
    words = [sys.executable, "-c", RUN, str(places), kind, *([device] if device else [])]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        assert process.stdout.readline() == "ready\n"
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.fixture(autouse=True)
def _in_short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stopping, "STOPPING_S", 0.5)


@pytest.fixture
def stop(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """The command: exit status, standard output, standard error."""

    def command(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as ended:
            main(["stop", *arguments])
        said = capsys.readouterr()
        assert isinstance(ended.value.code, int)
        return ended.value.code, said.out, said.err

    return command


Stop = Callable[..., tuple[int, str, str]]


@contextmanager
def served(end: Link) -> Iterator[SoftBoard]:
    board = SoftBoard(load_robot("penn_state"))
    done = threading.Event()
    thread = threading.Thread(target=serve, args=(board, end, MonotonicClock(), done))
    thread.start()
    try:
        yield board
    finally:
        done.set()
        thread.join(PATIENCE_S)
        end.close()


# -- runs ------------------------------------------------------------------------------------------------------------


def test_all_runs_are_stopped_and_waited_for(places: Path, stop: Stop) -> None:
    with ExitStack() as stack:
        hosts = [stack.enter_context(run(places)) for _ in range(3)]
        status, out, err = stop()
        assert status == 0, err
        for host in hosts:
            assert f"stopped the run on serial:/dev/robot (process {host.pid})" in out
            assert host.wait(PATIENCE_S) == 0


def test_a_run_that_does_not_obey_is_told(places: Path, stop: Stop, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stop_command, "OBEY_S", 0.5)
    with run(places) as host, run(places, "deaf") as deaf:
        status, out, err = stop()
        assert status == 5
        assert f"process {host.pid}" in out
        assert f"process {deaf.pid} on serial:/dev/robot has not obeyed" in err
        assert str(deaf.pid) not in out
        assert "cut the robot's supply" in err


def test_a_file_that_cannot_be_read_is_told(places: Path, stop: Stop) -> None:
    with run(places) as host:
        (path,) = places.rglob(f"{host.pid}.json")
        path.write_text("{")
        status, _, err = stop()
        assert status == 5
        assert f"process {host.pid} may be a run, but {path} does not tell" in err
        assert path.exists()
        path.unlink()


def test_nothing_to_stop(stop: Stop) -> None:
    status, out, err = stop()
    assert (status, out) == (2, "")
    assert "no run is going on" in err


# -- boards ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [PtyEnd, TcpEnd])
def test_the_board_says_that_it_has_stopped(make: Callable[[], Link], stop: Stop) -> None:
    end = make()
    with served(end) as board:
        status, out, err = stop("--port", end.port)
        assert status == 0, err
        assert out == f"stopped the board on {end.port}\n"
        assert board.mode is Mode.STOPPED


def test_a_port_where_nobody_answers_is_no_stop(stop: Stop) -> None:
    end = PtyEnd()
    status, out, err = stop("--port", end.port)
    end.close()
    assert (status, out) == (3, "")
    assert "no board answered" in err


def test_a_port_that_is_not_there(stop: Stop) -> None:
    status, _, err = stop("--port", "serial:/dev/there-is-none")
    assert status == 3
    assert "no such device" in err


def test_a_board_that_does_not_obey_is_told(stop: Stop) -> None:
    end = TcpEnd()
    with served(end) as board:
        board._stop_id = -1
        status, out, err = stop("--port", end.port)
    assert (status, out) == (5, "")
    assert "has not obeyed the emergency stop" in err
    assert "it is disarmed: cut its supply" in err


def test_a_stop_is_repeated_until_it_gets_there(stop: Stop) -> None:
    class Lossy(TcpEnd):
        heard = 0

        def receive(self, timeout_s: float) -> Sequence[Frame]:
            frames = super().receive(timeout_s)
            self.heard += len(frames)
            return frames if self.heard > 12 else []

    end = Lossy()
    with served(end) as board:
        assert stop("--port", end.port)[0] == 0
        assert board.mode is Mode.STOPPED


def test_the_port_of_a_run_that_was_stopped_is_waited_for(places: Path, stop: Stop) -> None:
    """The run cuts the power; the board's own word comes as soon as its port is free."""
    end = PtyEnd()
    with served(end) as board, run(places, "obeys", end.path):
        other = os.open(end.path, os.O_RDWR | os.O_NOCTTY)
        with pytest.raises(BlockingIOError):
            fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.close(other)
        status, out, err = stop("--port", end.port)
        assert status == 0, err
        assert "stopped the run" in out
        assert "stopped the board" in out
        assert board.mode is Mode.STOPPED


# -- crowds ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("have_spoken", [False, True], ids=["silent", "spoke once"])
@pytest.mark.parametrize("count", [15, 50, 200])
def test_idle_connections_do_not_lock_a_stop_out(count: int, have_spoken: bool, stop: Stop) -> None:
    end = TcpEnd()
    with served(end) as board, ExitStack() as stack:
        holder = stack.enter_context(socket.create_connection(end.address))
        beat = pack_all([encode(HostHeartbeat(7, 1))])
        stack.enter_context(speaking(holder, beat))
        crowd: Sequence[socket.socket] = [
            stack.enter_context(socket.create_connection(end.address)) for _ in range(count)
        ]
        for idle in crowd if have_spoken else ():
            with suppress(OSError):  # it has made room already
                idle.sendall(beat)
        status, _, err = stop("--port", end.port)
        assert status == 0, err
        assert board.mode is Mode.STOPPED
        holder.sendall(beat)
        holder.settimeout(PATIENCE_S)
        assert holder.recv(1), "the host that speaks was sent away"


@contextmanager
def speaking(host: socket.socket, words: bytes) -> Iterator[None]:
    """Who drives speaks with every tick."""
    done = threading.Event()

    def speak() -> None:
        while not done.wait(0.01):
            with suppress(OSError):
                host.sendall(words)

    thread = threading.Thread(target=speak)
    thread.start()
    time.sleep(0.1)  # it has driven for some ticks when a crowd comes
    try:
        yield
    finally:
        done.set()
        thread.join()


def test_who_drives_stays_when_a_crowd_speaks_between_two_of_its_ticks() -> None:
    end = TcpEnd()
    beat = pack_all([encode(HostHeartbeat(7, 1))])
    with ExitStack() as stack:
        holder = stack.enter_context(socket.create_connection(end.address))
        end.receive(1.0)
        for _ in range(3):
            holder.sendall(beat)
            assert end.receive(1.0)
        for _ in range(50):
            stack.enter_context(socket.create_connection(end.address)).sendall(beat)
        while end.receive(0.01):
            pass
        assert not select.select([holder], [], [], 0)[0], "the host that speaks was sent away"


def test_last_words_of_a_connection_that_makes_room_are_heard() -> None:
    from firmware_protocol.catalogue import EmergencyStop

    end = TcpEnd()
    with ExitStack() as stack:
        first = stack.enter_context(socket.create_connection(end.address))
        end.receive(PATIENCE_S)
        first.sendall(pack_all([encode(EmergencyStop())]))
        for _ in range(40):
            stack.enter_context(socket.create_connection(end.address))
        heard: list[Frame] = []
        deadline_s = time.monotonic() + PATIENCE_S
        while not heard and time.monotonic() < deadline_s:
            heard += end.receive(0.1)
        assert heard == [encode(EmergencyStop())]
    end.close()
