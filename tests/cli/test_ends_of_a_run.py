"""What ends a run from outside: hangups, signals at the worst moment, a terminal that has gone."""

from __future__ import annotations

import os
import pty
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from snakebot.cli import keys
from snakebot.cli.main import main
from snakebot.cli.terminal import leave_dead_terminal
from snakebot.control import Attendant, RunLoop, registry
from snakebot.control.making import Ready
from snakebot.runlog import read_log

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, registry.STOP_SIGNAL)
RUN = ["run", "--alpha", "40", "--beta", "60", "--omega", "2", "--duration", "6", "--ramp", "1", "--fast"]


def run(log: Path) -> int:
    with pytest.raises(SystemExit) as ended:
        main([*RUN, "--log", str(log)])
    assert isinstance(ended.value.code, int)
    return ended.value.code


@pytest.fixture
def at_tick(monkeypatch: pytest.MonkeyPatch) -> Callable[[int, Callable[[], None]], None]:
    """Have something happen in mid-run."""
    moments: dict[int, Callable[[], None]] = {}
    send = RunLoop._send

    def send_then(self: RunLoop, ready: Ready, t_s: float) -> None:
        moments.get(self.progress.ticks, lambda: None)()
        send(self, ready, t_s)

    monkeypatch.setattr(RunLoop, "_send", send_then)
    return moments.__setitem__


def kill(number: int) -> Callable[[], None]:
    return lambda: os.kill(os.getpid(), number)


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGTERM])
def test_a_hangup_is_one_request_however_often_it_comes(
    number: int, at_tick: Callable[[int, Callable[[], None]], None], tmp_path: Path
) -> None:
    for tick in (200, 201, 230):
        at_tick(tick, kill(number))
    at_tick(240, kill(signal.SIGTERM))
    assert run(tmp_path / "a.mcap") == 130
    log = read_log(tmp_path / "a.mcap")
    assert log.complete
    assert [event.kind for event in log.events][-4:] == ["stopping", "holding", "disarmed", "interrupted"]
    assert 290 <= len(log.t_s) <= 310  # a whole second of ramp


def test_ctrl_c_counts(at_tick: Callable[[int, Callable[[], None]], None], tmp_path: Path) -> None:
    at_tick(200, kill(signal.SIGINT))
    at_tick(210, kill(signal.SIGINT))
    assert run(tmp_path / "a.mcap") == 130
    assert 210 <= len(read_log(tmp_path / "a.mcap").t_s) <= 213


def test_whoever_finds_a_run_may_stop_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The signal may come as soon as the file is there, and until it is gone: it never ends the process."""
    write, handled = registry._write, []

    def write_and_stop(folder: Path, port: str) -> Any:
        written = write(folder, port)
        if folder.name == registry.RUNS:
            os.kill(os.getpid(), registry.STOP_SIGNAL)
        return written

    class Closing:
        def __getattr__(self, name: str) -> Any:
            return getattr(os, name)

        def close(self, file: int) -> None:
            handled.append(signal.getsignal(registry.STOP_SIGNAL))
            os.close(file)

    monkeypatch.setattr(registry, "_write", write_and_stop)
    before = [signal.getsignal(number) for number in SIGNALS]
    assert run(tmp_path / "a.mcap") == 5
    assert [signal.getsignal(number) for number in SIGNALS] == before
    assert not list(tmp_path.glob("a.mcap*"))  # a log is kept as soon as one set-point has been sent

    monkeypatch.setattr(registry, "_write", write)
    monkeypatch.setattr(registry, "os", Closing())
    assert run(tmp_path / "b.mcap") == 0
    assert signal.SIG_DFL not in handled
    assert callable(handled[-1])


def test_a_run_that_cannot_register_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setattr(registry, "SHARED", (tmp_path / "file",))
    assert run(tmp_path / "a.mcap") == 0
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    assert said[0].startswith("snakebot: warning: `snakebot stop` cannot find this run")
    (event,) = [event for event in read_log(tmp_path / "a.mcap").events if event.kind == "unregistered"]
    assert event.level == "warning"


def test_outside_the_main_thread_nobody_is_invited_to_send_signals() -> None:
    """Handlers can be had in the main thread only: a run elsewhere is not registered, or a stop would end it all."""
    seen: list[int] = []

    def elsewhere() -> None:
        with Attendant("sim:").while_running(None, None):  # type: ignore[arg-type]
            seen.append(len(registry.running()))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert seen == [0]


# -- a terminal that has gone ----------------------------------------------------------------------------------------


def in_a_session_of_its_own(work: Callable[[int], int]) -> int:
    """Do ``work`` in a process whose terminal it can take away (it is given the far end). Returns what it returns."""
    back, told = os.pipe()
    child = os.fork()
    if child == 0:
        status = 99
        try:
            os.setsid()
            signal.signal(signal.SIGHUP, signal.SIG_IGN)
            far, near = pty.openpty()
            for stream in (0, 1, 2):
                os.dup2(near, stream)
            os.close(near)
            status = work(far)
        finally:
            os.write(told, bytes([status]))
            os._exit(0)
    os.close(told)
    status = os.read(back, 1)[0]
    os.close(back)
    os.waitpid(child, 0)
    return status


def writes(stream: int) -> bool:
    try:
        os.write(stream, b"x")
    except OSError:
        return False
    return True


def test_what_is_written_to_a_dead_terminal_is_thrown_away() -> None:
    def work(far: int) -> int:
        leave_dead_terminal()
        alive = os.ttyname(1).startswith("/dev/pts/")  # a living one stays
        os.close(far)
        dead = not writes(1)
        leave_dead_terminal()
        return alive + 2 * dead + 4 * (writes(1) and writes(2))

    assert in_a_session_of_its_own(work) == 7


def test_pipes_and_files_stay(capfd: pytest.CaptureFixture[str]) -> None:
    leave_dead_terminal()
    os.write(1, b"here")
    assert capfd.readouterr().out == "here"


def test_the_keyboard_of_a_dead_terminal_is_not_read_for_ever() -> None:
    def work(far: int) -> int:
        import sys

        sys.stdin = os.fdopen(0)
        with keys.listening(None, None):  # type: ignore[arg-type]
            (thread,) = [each for each in threading.enumerate() if each.name == "keys"]
            os.close(far)
            thread.join(20)
            ended = not thread.is_alive()
        return 1 + 2 * ended

    assert in_a_session_of_its_own(work) == 3


@pytest.mark.parametrize("verbose", [(), ("-v",)])
def test_a_run_that_fails_prints_the_last_frames_where_that_is_wanted(
    verbose: tuple[str, ...],
    at_tick: Callable[[int, Callable[[], None]], None],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    at_tick(100, kill(registry.STOP_SIGNAL))
    with pytest.raises(SystemExit) as ended:
        main([*RUN, "--log", str(tmp_path / "a.mcap"), *verbose])
    assert ended.value.code == 5
    said = capsys.readouterr().err.splitlines()
    assert said[-1].startswith("snakebot: sim: emergency stop")
    frames = [line for line in said if " tx " in line or " rx " in line]
    assert len(frames) == (40 if verbose else 0)
    assert any("EmergencyStop" in line for line in frames) is bool(verbose)
    assert "traffic" in [event.kind for event in read_log(tmp_path / "a.mcap").events]
