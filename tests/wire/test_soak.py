"""The short form of each soak of tools/soak.py: nothing grows."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]

TOOL = Path(__file__).parents[2] / "tools" / "soak.py"
GROWTH = re.compile(r"(\w+) +growth: (-?\d+) kB, (-?\d+) files, (-?\d+) threads")
KB = 2048  # the first of the parts has warmed it up; an hour grows by nothing


def growth(*arguments: str) -> str:
    """What the tool printed, its growth checked."""
    done = subprocess.run([sys.executable, str(TOOL), *arguments], capture_output=True, text=True)
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
    found = GROWTH.findall(done.stdout)
    assert found, done.stdout
    for name, kilobytes, files, threads in found:
        assert int(kilobytes) < KB, name
        assert int(files) <= 0, name
        assert int(threads) <= 0, name
    return done.stdout


def test_six_minutes_of_streaming() -> None:
    said = growth("stream", "--hours", "0.1")
    assert "36001 ticks, 0 errors" in said


def test_three_hundred_starts_and_stops() -> None:
    assert "300 starts and stops" in growth("starts", "--times", "300")


@pytest.mark.real_time
@pytest.mark.parametrize("wire", ["tcp", "slcan"])
def test_half_a_minute_in_real_time(wire: str) -> None:
    said = growth("real", "--minutes", "0.5", "--parts", "4", "--wire", wire)
    assert re.search(r"^corrupt +0 in the first half, +0 in the second$", said, re.MULTILINE)


@pytest.mark.real_time
@pytest.mark.parametrize("wire", ["tcp", "serial"])
def test_twenty_runs_of_the_command_line(wire: str) -> None:
    said = growth("restarts", "--times", "20", "--parts", "4", "--wire", wire)
    assert re.search(r"^status \{0: 20\}, \d+ made again; threads here: MainThread$", said, re.MULTILINE)
