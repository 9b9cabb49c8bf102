"""Files that are there whole or not at all, and never in place of something that is no earlier one of their kind."""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from snakebot.errors import BadInputError, cannot_write

# How each kind of output begins: what begins otherwise is somebody's log, table or session.
BEGINNINGS: dict[str, tuple[bytes, ...]] = {
    "report": (b"<!doctype html",),
    "JSON": (b"{", b"["),
    "robot": (b"schema: snakebot.robot/",),
    "MJCF": (b"<!-- snakebot:",),
    "callbacks": (b'"""callbacks of a snakebot model for mujoco',),
    "ranges": (b"schema: snakebot.ranges/",),
    "table": (b"par1",),  # Parquet
}
_LOOKED_AT = 4096  # bytes
_NO_LINKS = (
    errno.EPERM,
    errno.ENOTSUP,
    errno.EOPNOTSUPP,
    errno.ENOSYS,
    errno.EMLINK,
)  # FAT, some network drives


def check_output(option: str, path: Path, kind: str) -> None:
    """Say so before minutes of work, not after, where an output cannot or must not be written.

    Args:
        option: as the user gave it, for the message.
        kind: a key of ``BEGINNINGS``.

    Raises:
        BadInputError: a folder, in no folder, in one that cannot be written to, or a file that is no such output.
    """
    if path.is_dir():
        raise BadInputError(f"{option} {path}: is a folder; give the name of a file")
    if not path.parent.is_dir():
        raise BadInputError(f"{option} {path}: folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK):
        raise BadInputError(f"{option} {path}: folder {path.parent} cannot be written to")
    if not path.is_file():
        return
    try:
        with path.open("rb") as file:
            head = file.read(_LOOKED_AT).lstrip().lower()
    except OSError as error:
        raise BadInputError(f"{option} {path}: {error.strerror}") from None
    if head and not head.startswith(BEGINNINGS[kind]):
        raise in_the_way(option, path, kind)


def in_the_way(option: str, path: Path, kind: str) -> BadInputError:
    """What is there is no earlier output of this kind."""
    return BadInputError(f"{option} {path}: exists, and is no {kind}; it stays as it is. Give another name")


def check_apart(outputs: Sequence[tuple[str, Path]]) -> None:
    """
    Raises:
        BadInputError: two options name the same file.
    """
    taken: dict[Path, str] = {}
    for option, path in outputs:
        other = taken.setdefault(path.resolve(), option)
        if other != option:
            raise BadInputError(f"{option} {path}: is the file of {other}, too; give another name")


def write_all(outputs: Sequence[tuple[Path, str]]) -> None:
    """All or nothing: every file is complete beside its place before the first one takes it.

    Raises:
        BadInputError: one cannot be written.
    """
    try:
        with contextlib.ExitStack() as stack:
            for path, text in outputs:
                stack.enter_context(replacing(path)).write_text(text, encoding="utf-8")
    except OSError as error:
        where = ", ".join(str(path) for path, _ in outputs)
        raise cannot_write(f"{where}: cannot be written", error) from None


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary file beside ``path`` that takes its place where all goes well, and goes away where not.

    What is there and is no file (a device, a pipe) is handed out itself.
    """
    if path.exists() and not path.is_file():
        yield path
        return
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:100]}.")
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def creating(path: Path) -> Iterator[Path]:
    """As ``replacing``, but never in place of anything, not even of a link that leads nowhere.

    Raises:
        FileExistsError: the name is taken, or was by the time the file was complete.
    """
    if os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, "exists already", str(path))
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:100]}.")
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        take_name(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def take_name(temporary: Path, path: Path) -> None:
    """Give a complete file its name, in one step, if nothing has that name.

    Raises:
        FileExistsError: something has it; ``temporary`` stays.
    """
    try:
        os.link(temporary, path)
    except OSError as error:
        if error.errno not in _NO_LINKS:
            raise
    else:
        temporary.unlink()
        return
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600))  # the name is ours, then the file
    try:
        temporary.replace(path)
    except OSError:
        path.unlink(missing_ok=True)
        raise


def _umask() -> int:
    now = os.umask(0)
    os.umask(now)
    return now
