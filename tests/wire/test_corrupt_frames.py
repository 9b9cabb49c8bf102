"""Damaged packets against the firmware's own checks: none is executed. The tool does ten million."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TOOL = Path(__file__).parents[2] / "tools" / "corrupt_frames"


def executed(packets: int) -> tuple[int, int]:
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    done = subprocess.run(
        [sys.executable, str(TOOL), "--packets", str(packets), "--seed", "7"], capture_output=True, text=True
    )
    print(done.stdout)
    found = re.search(r"nobody sent: (\d+) of (\d+)", done.stdout)
    assert found, done.stderr
    assert done.returncode == 0
    rows = [line.split() for line in done.stdout.splitlines()[1:9]]
    assert all(int(row[-1]) > 0 for row in rows), "sound set-points must still be executed"
    assert int(next(row for row in rows if row[0] == "payload,")[-4]) > 0, "the last check was never asked"
    return int(found[1]), int(found[2])


def test_no_damaged_set_point_is_executed() -> None:
    wrong, damaged = executed(200_000)
    assert wrong == 0
    assert damaged >= 200_000


@pytest.mark.slow
def test_none_of_ten_million() -> None:
    wrong, damaged = executed(10_000_000)
    assert wrong == 0
    assert damaged >= 10_000_000
