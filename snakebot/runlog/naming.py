"""Where logs are and how they are named: ``runs/20261121T081530Z_a66_b80_w2.mcap``, never twice the same."""

from __future__ import annotations

import math
import os
import re
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from snakebot.gait import Gait

DEFAULT_FOLDER = Path("runs")
SUFFIX = ".mcap"
PART_SUFFIX = ".part"


def final_path(path: str | os.PathLike[str]) -> Path:
    """The name that a log has when it is closed, whether given with, without ``.mcap`` or as a ``.part``."""
    name = os.fspath(path).removesuffix(PART_SUFFIX)
    return Path(name if name.endswith(SUFFIX) else name + SUFFIX)


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
    stamp = (now or datetime.now(UTC)).astimezone(UTC).strftime("%Y%m%dT%H%M%SZ")
    safe = re.sub(r"[^A-Za-z0-9.+-]+", "_", label).strip("._") or "run"
    stem = f"{stamp}_{safe[:80]}"
    for count in range(1, 10_000):
        path = Path(folder) / f"{stem}{'' if count == 1 else f'-{count}'}{SUFFIX}"
        if not path.exists() and not path.with_name(path.name + PART_SUFFIX).exists():
            return path
    raise FileExistsError(stem)
