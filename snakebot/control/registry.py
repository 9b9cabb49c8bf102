"""Who is running on this machine: one small file a run, so that a second terminal can stop it.

A serial port can be open only once, so ``snakebot stop`` reaches a running robot through its process: SIGUSR1 makes
the run loop send the emergency stop with its next tick.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import stat
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

STOP_SIGNAL = signal.SIGUSR1
RUNS = "runs"
BOARDS = "boards"  # simulated boards that wait for a host: found by `snakebot board list`


@dataclass(frozen=True, slots=True)
class RunningRun:
    """A run that is going on in another process."""

    pid: int
    port: str


def _folder(kind: str) -> Path:
    base = os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()
    return Path(base) / f"snakebot-{os.getuid()}" / kind


def _make_ours(folder: Path) -> None:
    """
    Raises:
        OSError: somebody else was there before, or laid a link there.
    """
    for made in (folder.parent, folder):
        made.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = made.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid():
            raise PermissionError(f"{made} is not ours")
        made.chmod(0o700)


def _is_ours(folder: Path) -> bool:
    """Whether nobody else can have put something there: /tmp is everybody's, and what is there gets signals."""
    try:
        return all(
            stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022
            for found in map(os.lstat, (folder.parent, folder))
        )
    except OSError:
        return False


def _started(pid: int) -> str | None:
    """Start time of a process: a number that is used again after the process has gone does not fool us."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19]
    except (OSError, IndexError):
        return None


@contextlib.contextmanager
def registered(port: str, kind: str = RUNS) -> Iterator[None]:
    """Make this process's run known while it lasts, on its own or as one of several of a longer undertaking.

    Where no file can be written the run goes on without.
    """
    path = _folder(kind) / f"{os.getpid()}.json"
    whole = any(run.pid == os.getpid() for run in running(kind))
    try:
        _make_ours(path.parent)
        path.write_text(
            json.dumps({"pid": os.getpid(), "port": port, "started": _started(os.getpid())}), encoding="utf-8"
        )
    except OSError:
        yield
        return
    try:
        yield
    finally:
        if not whole:
            path.unlink(missing_ok=True)


def running(kind: str = RUNS) -> list[RunningRun]:
    """The runs that are alive; files that dead ones have left are cleared away."""
    found: list[RunningRun] = []
    if not _is_ours(_folder(kind)):
        return found
    for path in sorted(_folder(kind).glob("*.json")):
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
            pid, port = int(data["pid"]), str(data["port"])
            alive = _started(pid) is not None and data["started"] == _started(pid)
        except (OSError, ValueError, KeyError, TypeError):
            alive = False
        if alive:
            found.append(RunningRun(pid, port))
        else:
            path.unlink(missing_ok=True)
    return found


def stop(run: RunningRun) -> None:
    """Ask a run for the emergency stop.

    Raises:
        OSError: it is another user's, or has just ended.
    """
    os.kill(run.pid, STOP_SIGNAL)
