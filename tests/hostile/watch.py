"""Sees what a parser does to the machine, by Python's audit events: files written, programs started, text executed."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_CHANGES = {
    "os.chmod", "os.chown", "os.link", "os.mkdir", "os.remove", "os.rename", "os.rmdir", "os.symlink", "os.truncate",
    "os.utime", "shutil.copyfile", "shutil.move", "shutil.rmtree",
}  # fmt: skip
_NEVER = {
    "ctypes.dlopen", "os.exec", "os.fork", "os.forkpty", "os.kill", "os.posix_spawn", "os.putenv", "os.spawn",
    "os.system", "pickle.find_class", "pty.spawn", "socket.bind", "socket.connect", "socket.getaddrinfo",
    "socket.sendto", "subprocess.Popen",
}  # fmt: skip

_allowed: str | None = None  # the one folder that may be written to, while somebody watches
_seen: list[str] = []


_real = cache(os.path.realpath)


def _outside(path: Any) -> bool:
    if not isinstance(path, (str, bytes, os.PathLike)):
        return False  # a file that is open already
    return not os.path.realpath(os.fsdecode(path)).startswith(f"{_allowed}{os.sep}")


def _hook(event: str, args: tuple[Any, ...]) -> None:
    if _allowed is None:
        return
    if event == "open":
        path, mode, flags = args
        writes = any(sign in (mode or "") for sign in "wax+") or bool((flags or 0) & _WRITING)
        if writes and _outside(path):
            _seen.append(f"open {path!r} to write")
    elif event in _NEVER or (event in _CHANGES and any(map(_outside, args[:2]))):
        _seen.append(f"{event} {args!r}"[:200])
    elif event == "compile" and args[1] == "<string>":
        _seen.append(f"compile {args[0]!r}"[:200])


def watch(folder: Path) -> list[str]:
    """From now on, what is done outside ``folder`` is added to the list that is returned."""
    global _allowed
    if not _installed:
        sys.addaudithook(_hook)
        _installed.append(True)
    sys.dont_write_bytecode = True
    _seen.clear()
    _allowed = _real(folder)
    return _seen


def look_away() -> None:
    global _allowed
    _allowed = None


@contextmanager
def watching(folder: Path) -> Iterator[None]:
    """Fail if what is done inside writes anywhere but in ``folder``, starts a program, or executes text.

    Raises:
        AssertionError: it did, even if what it then met was caught.
    """
    keep = sys.dont_write_bytecode
    seen = watch(folder)
    try:
        yield
    finally:
        look_away()
        sys.dont_write_bytecode = keep
    assert not seen, f"trespass: {seen}"


_installed: list[bool] = []
