"""Who finds whom with ``snakebot stop``, and who is left alone."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from snakebot.control import registry

NOBODY = 65534
root = pytest.mark.skipif(os.getuid() != 0, reason="only root can be another user")

# Everything is imported before it becomes another user, who may not be allowed to read it.
BEGIN = """
import os, signal, sys
from pathlib import Path
from snakebot.cli import main, stop
from snakebot.control import registry
registry.SHARED, registry.EACH_USERS = (Path(sys.argv[1]),), Path(sys.argv[1]) / "no-user"
os.setuid(int(sys.argv[2]))
"""

RUN = """
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGUSR1, signal.SIGTERM})
with registry.registered("serial:/dev/robot") as known:
    print(known, flush=True)
    signal.sigwait({signal.SIGUSR1, signal.SIGTERM})
"""

LOOK_AND_STOP = """
print(*registry.running())
main.main(["stop"])
"""


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A place that everybody may write to, as /tmp is, and no other."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name)
        path.chmod(0o1777)
        monkeypatch.setattr(registry, "SHARED", (path,))
        yield path


@contextmanager
def process(*words: str, **how: object) -> Iterator[subprocess.Popen[str]]:
    """A process that has said its first line, and is gone (and waited for) afterwards."""
    started: subprocess.Popen[str] = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, **how)  # type: ignore[call-overload]
    assert started.stdout is not None
    try:
        assert started.stdout.readline().strip() == "True"
        yield started
    finally:
        started.kill()
        started.communicate()


@contextmanager
def run_of(place: Path, uid: int | None = None, **how: object) -> Iterator[subprocess.Popen[str]]:
    user = str(os.getuid() if uid is None else uid)
    with process(sys.executable, "-c", BEGIN + RUN, str(place), user, **how) as started:
        yield started


@contextmanager
def innocent(**how: object) -> Iterator[subprocess.Popen[str]]:
    """A process that no signal may reach: it would die of it."""
    with process("sh", "-c", "echo True; exec sleep 60", **how) as started:
        yield started
        assert started.poll() is None


def lay(place: Path, owner: int, pid: int, text: str) -> Path:
    """A file where a run of that user would register."""
    folder = place / f"snakebot-{owner}" / registry.RUNS
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{pid}.json"
    path.write_text(text)
    for made in (folder.parent, folder, path):
        os.chown(made, owner, -1)
    return path


def registration(pid: int, started_like: int | None = None) -> str:
    boot, ticks = (registry._started(started_like or pid) or "").split()
    return json.dumps({"pid": pid, "port": "serial:/dev/robot", "started": ticks, "boot": boot})


def test_the_environment_does_not_decide_who_finds_whom(place: Path, tmp_path: Path) -> None:
    elsewhere = {"XDG_RUNTIME_DIR": str(tmp_path), "TMPDIR": str(tmp_path), "HOME": str(tmp_path)}
    with run_of(place, env={**os.environ, **elsewhere}) as host:
        (found,) = registry.running()
        assert (found.pid, found.port, found.uid) == (host.pid, "serial:/dev/robot", os.getuid())
        assert found.ours


def test_the_places_are_those_of_everybody() -> None:
    """The fixture of all tests has put others in their place: this is what the program has."""
    code = "from snakebot.control import registry as r; print(True, *r.SHARED, r.EACH_USERS)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "/tmp", "/dev/shm", "/run/user"]


def test_a_place_that_cannot_be_written_to_is_made_up_for_by_the_others(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    users = tmp_path / "user"
    (users / str(os.getuid())).mkdir(parents=True)
    monkeypatch.setattr(registry, "SHARED", (tmp_path / "file", tmp_path / "not-there"))
    monkeypatch.setattr(registry, "EACH_USERS", users)
    with registry.registered("sim:") as known:
        assert known
        assert [run.pid for run in registry.running()] == [os.getpid()]
    assert not registry.running()
    monkeypatch.setattr(registry, "EACH_USERS", tmp_path / "not-there")
    with registry.registered("sim:") as known:
        assert not known


def test_who_looks_never_takes_a_living_run_away(place: Path) -> None:
    """One registers again and again while another looks: nothing half-written is seen, nothing deleted."""
    lost: list[int] = []
    done = threading.Event()

    def register() -> None:
        for turn in range(400):
            with registry.registered("sim:"):
                if not (place / f"snakebot-{os.getuid()}" / "runs" / f"{os.getpid()}.json").exists():
                    lost.append(turn)
        done.set()

    thread = threading.Thread(target=register)
    thread.start()
    unclear = 0
    while not done.is_set():
        unclear += len(registry.look().unclear)
    thread.join()
    assert not lost
    assert not unclear


UNREADABLE = ["", '{"pid": 1', "[]", '{"pid": 1, "port": "sim:", "started": "1", "boot": "x"}', "\0\xff"]


@pytest.mark.parametrize("text", UNREADABLE)
def test_what_cannot_be_read_is_kept_and_told_while_its_process_may_live(place: Path, text: str) -> None:
    with innocent() as other:
        path = lay(place, os.getuid(), other.pid, text)
        found = registry.look()
        assert not found.runs
        assert found.unclear == {other.pid: path}
        assert path.exists()
    assert registry.look() == registry.RegisteredRuns([], {})
    assert path.read_text() == text


def test_one_place_that_tells_is_enough(place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with run_of(place) as host:
        monkeypatch.setattr(registry, "SHARED", (place, tmp_path))
        lay(tmp_path, os.getuid(), host.pid, "half")
        found = registry.look()
        assert [run.pid for run in found.runs] == [host.pid]
        assert not found.unclear


def test_what_a_killed_run_has_left_is_cleared_away(place: Path) -> None:
    with run_of(place) as host:
        (path,) = place.rglob("*.json")
        host.kill()
        host.wait()
        assert path.exists()
        assert not registry.running()
        assert not path.exists()


def test_a_run_that_was_killed_and_not_waited_for_does_not_live(place: Path) -> None:
    with run_of(place) as host:
        host.kill()
        os.waitid(os.P_PID, host.pid, os.WEXITED | os.WNOWAIT)  # a zombie from here on
        assert not registry.running()


def test_a_number_that_is_used_again_is_not_the_run(place: Path) -> None:
    with innocent() as other:
        path = lay(place, os.getuid(), other.pid, registration(other.pid, started_like=os.getppid()))
        assert registry.look() == registry.RegisteredRuns([], {})
        assert not path.exists()
        with pytest.raises(ProcessLookupError):
            registry.stop(registry.RunningRun(other.pid, "sim:", os.getuid(), "boot 1"))


def test_a_run_in_a_container_is_kept_and_told(place: Path) -> None:
    """Its process is not one of ours, but its file is locked."""
    with run_of(place):
        (path,) = place.rglob("*.json")
        moved = path.with_name("4194999.json")  # beyond any process of here
        moved.write_text("")
        data = json.loads(path.read_text()) | {"pid": 4194999}
        path.replace(moved)
        with moved.open("w") as file:
            json.dump(data, file)
        found = registry.look()
        assert not found.runs
        assert found.unclear == {4194999: moved}
        assert moved.exists()


@root
def test_root_finds_the_runs_of_other_users(place: Path) -> None:
    with run_of(place, NOBODY) as host:
        (found,) = registry.running()
        assert (found.pid, found.uid, found.ours) == (host.pid, NOBODY, True)
        assert found.user == "nobody"
        host.kill()
        host.wait()
        assert not registry.running()


@root
def test_nobody_aims_roots_signals_at_the_process_of_another(place: Path) -> None:
    with innocent() as other:
        path = lay(place, NOBODY, other.pid, registration(other.pid))
        assert registry.look() == registry.RegisteredRuns([], {})
        assert path.exists()  # nor are their files ours to delete


@root
def test_a_folder_that_others_can_write_to_is_not_believed(place: Path) -> None:
    with run_of(place, NOBODY):
        (path,) = place.rglob("*.json")
        path.parent.chmod(0o777)
        assert not registry.running()


@root
def test_a_user_sees_the_runs_of_root_and_is_told_how_to_stop_them(place: Path) -> None:
    words = [sys.executable, "-c", BEGIN + LOOK_AND_STOP, str(place), str(NOBODY)]
    with run_of(place) as host:
        done = subprocess.run(words, capture_output=True, text=True)
        assert f"pid={host.pid}" in done.stdout, done.stderr
        assert done.returncode == 5
        assert f"process {host.pid} of root drives serial:/dev/robot" in done.stderr
        assert "`sudo snakebot stop` stops it" in done.stderr
        assert host.poll() is None


def test_the_stop_signal_reaches_a_run(place: Path) -> None:
    with run_of(place) as host:
        (found,) = registry.running()
        registry.stop(found)
        assert host.wait(20) == 0
        assert not list(place.rglob("*.json"))


def test_several_of_one_undertaking_are_one_run(place: Path) -> None:
    with registry.registered("sim:"):
        with registry.registered("sim:") as known:
            assert known
        assert [run.pid for run in registry.running()] == [os.getpid()]
    assert not registry.running()
