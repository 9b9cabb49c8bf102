"""A real run while both cores, and more, are busy: late ticks are counted and never bunched into a burst."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from snakebot.runlog import read_log

pytestmark = pytest.mark.slow

SNAKEBOT = [sys.executable, "-m", "snakebot.cli.main"]
INTERVAL_S = 0.01
ROUNDING_S = 1e-5


@pytest.fixture
def busy() -> Iterator[None]:
    """Two processes a core that do nothing but compute."""
    hogs = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2 * (os.cpu_count() or 1))
    ]
    yield
    for hog in hogs:
        hog.kill()
        hog.wait()


@pytest.mark.usefixtures("busy")
@pytest.mark.filterwarnings("ignore::snakebot.runlog.reader.LogWarning")
def test_a_busy_computer(tmp_path: Path) -> None:
    board = subprocess.Popen([*SNAKEBOT, "board", "sim", "--tcp", "0"], stdout=subprocess.PIPE, text=True)
    assert board.stdout is not None
    port = board.stdout.readline().strip().removeprefix("--port ")
    gait = ["--alpha", "40", "--beta", "60", "--omega", "2", "--duration", "10"]
    done = subprocess.run(
        [*SNAKEBOT, "run", "--port", port, *gait, "--json", "--log", str(tmp_path / "a.mcap")],
        capture_output=True,
        text=True,
    )
    board.kill()
    board.wait()
    assert done.returncode in (0, 5, 7), done.stderr  # it may be too busy, and then says so
    assert "Traceback" not in done.stderr
    log = read_log(next(tmp_path.glob("a.mcap*")))
    counts = {name: float(log.link[name][-1]) for name in ("ticks", "late", "skipped", "lost")}
    gaps_s = np.diff(log.t_s)
    print(
        f"status {done.returncode}: {counts}; set-points {1e3 * gaps_s.min():.1f} to {1e3 * gaps_s.max():.1f} ms apart"
    )
    for width in (2, 5, 10):  # in any stretch of time no more ticks than belong there, and one that was late
        assert (log.t_s[width:] - log.t_s[:-width]).min() > (
            width - 1
        ) * INTERVAL_S - INTERVAL_S / 2 - ROUNDING_S
    assert (log.t_s[log.late] % INTERVAL_S > INTERVAL_S / 2 - ROUNDING_S).all()
    if done.returncode == 0:
        summary = json.loads(done.stdout)
        assert summary["late"] == log.late.sum()
        assert summary["ticks"] + summary["skipped"] == pytest.approx(1001, abs=1)
