"""Where logs are and how they are named: ``runs/20261121T081530Z_a66_b80_w2.mcap``, never twice the same."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError, LogError

if TYPE_CHECKING:
    from snakebot.gait import Gait

DEFAULT_FOLDER = Path("runs")
SUFFIX = ".mcap"
PART_SUFFIX = ".part"


def final_path(path: str | os.PathLike[str]) -> Path:
    """The name that a log has when it is closed, whether given with, without ``.mcap`` or as a ``.part``."""
    name = os.fspath(path).removesuffix(PART_SUFFIX)
    return Path(name if name.endswith(SUFFIX) else name + SUFFIX)


def numbered(path: Path) -> Iterator[Path]:
    """``x.mcap``, ``x-2.mcap``, ``x-3.mcap`` ...: what a log is called whose name is taken."""
    yield path
    for count in range(2, 10_000):
        yield path.with_name(f"{path.name.removesuffix(SUFFIX)}-{count}{SUFFIX}")


def no_such_log(path: str | os.PathLike[str]) -> BadInputError:
    """The error to raise where a log is missing: it says how to see those that are there."""
    folder = Path(path).parent
    if not folder.is_dir():
        return BadInputError(f"{path}: no such log: there is no folder {folder}")
    where = "" if folder == DEFAULT_FOLDER else f" {folder}"
    return BadInputError(f"{path}: no such log; `snakebot log list{where}` lists those in its folder")


def check_new_log(path: str | os.PathLike[str]) -> None:
    """Say before a robot moves where its log cannot be made; that it could be is no promise.

    Raises:
        LogError: the name is taken, is a folder's, or lies where nothing can be written.
    """
    final = final_path(path)
    if Path(path).is_dir():
        raise LogError(f"{path}: is a folder; give the name of a log in it")
    if _is_taken(final):
        raise LogError(f"{final}: exists already; a log is never overwritten")
    folder = final.parent
    while not os.path.lexists(folder):
        folder = folder.parent
    if not folder.is_dir():
        raise LogError(f"{final}: cannot make the log: {folder} is not a folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise LogError(f"{final}: cannot make the log: {folder} cannot be written to")


def _is_taken(path: Path) -> bool:
    return any(os.path.lexists(name) for name in (path, path.with_name(path.name + PART_SUFFIX)))


def gait_label(gait: Gait | None) -> str:
    """``a66_b80_w2``: alpha and beta in degrees, omega in rad/s."""
    if gait is None:
        return "run"
    numbers = (math.degrees(gait.alpha_rad), math.degrees(gait.beta_rad), gait.omega_rad_s)
    return "_".join(f"{letter}{number:.4g}" for letter, number in zip("abw", numbers, strict=True))


def new_log_path(
    label: str = "run", folder: str | os.PathLike[str] = DEFAULT_FOLDER, now: datetime | None = None
) -> Path:
    """A name in ``folder`` that neither a log nor an unfinished one has yet: UTC time, then ``label``."""
    return next(path for path in numbered(stamped_path(label, folder, now)) if not _is_taken(path))


def stamped_path(
    label: str = "run", folder: str | os.PathLike[str] = DEFAULT_FOLDER, now: datetime | None = None
) -> Path:
    """UTC time, then ``label``. Where it is taken, ``RunWriter(..., or_numbered=True)`` takes the next number."""
    stamp = (now or datetime.now(UTC)).astimezone(UTC).strftime("%Y%m%dT%H%M%SZ")
    safe = re.sub(r"[^A-Za-z0-9.+-]+", "_", label).strip("._") or "run"
    stem = f"{stamp}_{safe[:80]}"
    return Path(folder) / (stem + SUFFIX)
