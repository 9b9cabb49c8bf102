"""Who is running on this machine: small files a run, so that a second terminal can stop it.

A serial port can be open only once, so ``snakebot stop`` reaches a running robot through its process: SIGUSR1 makes
the run loop send the emergency stop with its next tick.

Each run writes itself down in every one of a few fixed places, and everyone looks in all of them: neither the
environment (``XDG_RUNTIME_DIR``, ``TMPDIR``) nor ``sudo`` decides who finds whom. What is found there is believed only
where nobody but the user of that very process can have written it, and while that process lives.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import pwd
import signal
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

STOP_SIGNAL = signal.SIGUSR1
RUNS = "runs"
BOARDS = "boards"  # simulated boards that wait for a host: found by `snakebot board list`

# Everybody may write to these, and read what others have written ...
SHARED = (Path("/tmp"), Path("/dev/shm"))
# ... and this one has a folder for each user, which lives on where a service has a /tmp of its own.
EACH_USERS = Path("/run/user")

_MOST_BYTES = 4096  # of a registration: a port may be long, but not so long

_inside: dict[str, bool] = {}  # what this process has registered, and whether it could be written


@dataclass(frozen=True, slots=True)
class RunningRun:
    """A run that is going on in another process.

    Attributes:
        pid: its process.
        port: where its robot is, as for ``--port``.
        uid: whose process it is.
        started: start of the process, so that the next one with its number is not taken for it.
    """

    pid: int
    port: str
    uid: int
    started: str

    @property
    def ours(self) -> bool:
        """Whether this user may stop it."""
        return os.getuid() in (0, self.uid)

    @property
    def user(self) -> str:
        """Name of its user, or the number of one that has no name."""
        try:
            return pwd.getpwuid(self.uid).pw_name
        except KeyError:
            return str(self.uid)


@dataclass(frozen=True, slots=True)
class RegisteredRuns:
    """What is registered: runs that live, and files of processes that may be runs, but cannot be told (by process)."""

    runs: list[RunningRun]
    unclear: dict[int, Path]


class _UnclearError(Exception):
    """A file that cannot be read, of a process that lives, or one whose process lives where we do not see it."""


@contextlib.contextmanager
def registered(port: str, kind: str = RUNS) -> Iterator[bool]:
    """Make this process's run known while it lasts, on its own or as one of several of a longer undertaking.

    The stop signal ends a process that has no handler for it: install that first, and remove it last.

    Yields:
        Whether anyone can find it: False where no place lets us write.
    """
    if kind in _inside:  # one of several
        yield _inside[kind]
        return
    written: list[tuple[Path, int]] = []
    try:
        for place in _own_places():
            with contextlib.suppress(OSError):
                written.append(_write(place / f"snakebot-{os.getuid()}" / kind, port))
        _inside[kind] = bool(written)
        yield bool(written)
    finally:
        _inside.pop(kind, None)
        for path, file in written:
            with contextlib.suppress(OSError):
                path.unlink()
            os.close(file)


def look(kind: str = RUNS) -> RegisteredRuns:
    """Everything registered on this computer. What dead processes of this user have left is cleared away."""
    runs: dict[int, RunningRun] = {}
    unclear: dict[int, Path] = {}
    for path, owner in _registrations(kind):
        pid = int(path.stem)
        try:
            run = _living(path, pid, owner)
        except _UnclearError:
            unclear[pid] = path
            continue
        if run is not None:
            runs[pid] = run
    return RegisteredRuns(
        [run for _, run in sorted(runs.items())],
        {pid: path for pid, path in sorted(unclear.items()) if pid not in runs},
    )


def running(kind: str = RUNS) -> list[RunningRun]:
    """The runs that are alive, of all users that can be seen from here."""
    return look(kind).runs


def stop(run: RunningRun) -> None:
    """Ask a run for the emergency stop.

    Raises:
        OSError: it is another user's, or has just ended.
    """
    if _started(run.pid) != run.started:
        raise ProcessLookupError(f"process {run.pid} has ended")
    os.kill(run.pid, STOP_SIGNAL)


# -- places ----------------------------------------------------------------------------------------------------------


def _own_places() -> list[Path]:
    private = EACH_USERS / str(os.getuid())
    return [*SHARED, private] if private.is_dir() else list(SHARED)


def _registrations(kind: str) -> Iterator[tuple[Path, int]]:
    """Files that are named like a process, each with the only user who can have put it there."""
    for place in [*SHARED, *_listed(EACH_USERS)]:
        for folder in _listed(place):
            owner = _private_to(folder / kind) if folder.name.startswith("snakebot-") else None
            if owner is not None:
                yield from (
                    (path, owner)
                    for path in _listed(folder / kind)
                    if path.suffix == ".json" and path.stem.isdecimal() and path.stem.isascii()
                )


def _listed(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:  # not there, or not for us to see
        return []


def _private_to(folder: Path) -> int | None:
    """The only user who can put something there; None where there may be others, or a link leads elsewhere."""
    try:
        outer, inner = folder.parent.lstat(), folder.lstat()
    except OSError:
        return None
    private = outer.st_uid == inner.st_uid and all(
        stat.S_ISDIR(each.st_mode) and not each.st_mode & 0o022 for each in (outer, inner)
    )
    return inner.st_uid if private else None


def _make_ours(folder: Path) -> None:
    """
    Raises:
        OSError: somebody else was there before, or laid a link there.
    """
    for made in (folder.parent, folder):
        made.mkdir(exist_ok=True)
        found = made.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid():
            raise PermissionError(f"{made} is not ours")
        made.chmod(0o755)  # others may see whom to ask, and only we may write


# -- registrations ---------------------------------------------------------------------------------------------------


def _write(folder: Path, port: str) -> tuple[Path, int]:
    """Write this process down, all at once: a reader finds the whole of it, or nothing.

    Returns:
        The file, and its descriptor: locked as long as this process lives.

    Raises:
        OSError: not here.
    """
    _make_ours(folder)
    path = folder / f"{os.getpid()}.json"
    part = path.with_suffix(".part")
    boot, ticks = (_started(os.getpid()) or " ").split(" ")
    text = json.dumps({"pid": os.getpid(), "port": port, "started": ticks, "boot": boot})
    with contextlib.suppress(FileNotFoundError):
        part.unlink()  # of a process that had our number
    file = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
    try:
        os.fchmod(file, 0o644)
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.write(file, text.encode())
        part.replace(path)
    except OSError:
        os.close(file)
        with contextlib.suppress(OSError):
            part.unlink()
        raise
    return path, file


def _living(path: Path, pid: int, owner: int) -> RunningRun | None:
    """The run that a file stands for; None where there is none any more.

    Raises:
        _UnclearError: there may be one.
    """
    started = _started(pid)
    try:
        file = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except FileNotFoundError:
        return None  # it has ended just now
    except OSError:
        file = None
    try:
        run = None if file is None else _read(file, pid, owner)
        lives = started is not None and _uid(pid) == owner
        if lives and run is not None and run.started == started:
            return run
        # A lock without a process that we see: it lives in a container.
        if (lives and run is None) or (file is not None and _locked(file)):
            raise _UnclearError
    finally:
        if file is not None:
            os.close(file)
    if run is not None and owner == os.getuid():  # nobody else can change our folders
        path.unlink(missing_ok=True)
    return None


def _read(file: int, pid: int, owner: int) -> RunningRun | None:
    """What an open file says, if it is a registration of this process, written by its user."""
    found = os.fstat(file)
    if not stat.S_ISREG(found.st_mode) or found.st_uid != owner:
        return None
    try:
        data = json.loads(os.read(file, _MOST_BYTES))
        written, port, started = data["pid"], str(data["port"]), f"{data['boot']} {data['started']}"
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return RunningRun(pid, port, owner, started) if written == pid else None


def _locked(file: int) -> bool:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return True
    return False


def _started(pid: int) -> str | None:
    """When a process began (boot, clock ticks since), so that a number used again fools nobody. None: it has gone."""
    try:
        state, *after = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except (OSError, ValueError):
        return None
    return None if state in "ZX" else f"{boot} {after[18]}"  # a zombie has only its parent left to tell


def _uid(pid: int) -> int | None:
    """Whose a process is; None where it runs with the rights of another user than its own."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return None
    real, effective = next(line for line in lines if line.startswith("Uid:")).split()[1:3]
    return int(real) if real == effective else None
