"""End to end on the real bus protocol: a fault in one emulated servo, five gaits, and the diagnosis that names it."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

PROGRAM = [sys.executable, "-c", "from snakebot.cli.main import main; main()"]
SNAKE = "sts3215_snake"
GAITS = [(66, 80, 1), (66, 80, 2), (60, 70, 3), (50, 80, 4), (40, 90, 5)]  # deg, deg, rad/s


def call(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*PROGRAM, *words], capture_output=True, text=True, timeout=600)


@contextlib.contextmanager
def servos(*options: str) -> Iterator[str]:
    """Emulated servos as their own program, whose port is given out."""
    words = [*PROGRAM, "board", "sim", "--feetech", *options, "--json"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield json.loads(process.stdout.readline())["port"]
    finally:
        process.terminate()
        process.communicate()


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_rate_limit_in_one_bus_servo_is_named(tmp_path: Path) -> None:
    logs = []
    with servos("--robot", SNAKE, "--effect", "rate_limit:limit_rad_s=2.5,joints=3") as port:
        for alpha, beta, omega in GAITS:
            log = str(tmp_path / f"gait_{omega}.mcap")
            gait = ("--alpha", str(alpha), "--beta", str(beta), "--omega", str(omega), "--cycles", "3")
            done = call("run", "--robot", SNAKE, *gait, "--port", port, "--yes", "--log", log)
            assert done.returncode == 0, done.stderr
            logs.append(log)
    verdict = tmp_path / "verdict.json"
    done = call("diagnose", *logs, "--json", str(verdict))
    assert done.returncode == 0, done.stderr
    found = json.loads(verdict.read_text())
    assert found["verdict"] == "explained"
    assert [(cause["effect"], cause["joints"]) for cause in found["causes"]] == [("rate_limit", [3])]
    limit = found["causes"][0]["parameters"]["limit_rad_s"]
    assert limit["estimate"] == pytest.approx(2.5, rel=0.05)
    assert limit["ci95"][0] < 2.5 < limit["ci95"][1]
