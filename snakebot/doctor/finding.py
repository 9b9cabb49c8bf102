"""A finding of ``snakebot doctor``: what was looked at, how good it is, and what to do about it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path


class Status(StrEnum):
    """How good a finding is. ``INFO`` is neither."""

    OK = "ok"
    INFO = "info"
    WARN = "warn"
    FAIL = "fail"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at: what was found, and what to do about it (empty where nothing is to be done)."""

    what: str
    status: Status
    found: str
    advice: str = ""


def read_text(path: Path) -> str | None:
    """A small file's text, or None where there is none to read."""
    try:
        return path.read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return None


def percentile(sorted_values: list[float], share: float) -> float:
    """The value below which this share of them lies (nearest rank)."""
    return sorted_values[min(len(sorted_values) - 1, int(share * len(sorted_values)))]
