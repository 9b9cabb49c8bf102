"""Who is writing a log: a lock that goes with the process, however it ends."""

from __future__ import annotations

import os
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows refuses to rename or remove an open file by itself
    fcntl = None  # type: ignore[assignment]


def lock(file: int) -> None:
    """Mark an open file as being written. A file system without locks is put up with."""
    if fcntl is not None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return


def is_being_written(path: Path) -> bool:
    """Whether a process has the file locked."""
    if fcntl is None:
        return False
    try:
        file = os.open(path, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(file)
    return False
