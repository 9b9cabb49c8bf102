"""The firmware built with make, once for all test processes; later runs build only what has changed."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE = ROOT / "firmware_protocol/firmware"
BUILD = ROOT / "build/firmware"


def need(*programs: str) -> None:
    """Skip, saying so, where a program is missing."""
    for program in programs:
        if shutil.which(program) is None:
            pytest.skip(f"{program} is not installed")


def make(target: str) -> str:
    """Build a target; what make printed."""
    need("make", "cc")
    BUILD.mkdir(parents=True, exist_ok=True)
    with (BUILD / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        done = subprocess.run(
            ["make", "-C", str(FIRMWARE), target, f"OUT={BUILD}"], capture_output=True, text=True, check=False
        )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def core_library_path() -> Path:
    """The core as a library; the one that counts coverage where tools/coverage_firmware.py says so."""
    given = os.environ.get("SNAKEBOT_CORE_LIBRARY")
    if given:
        return Path(given)
    make("bench")
    return BUILD / "bench.so"
