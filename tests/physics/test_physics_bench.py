"""The benchmark is run by hand; here only that it starts, and that what it counts is right."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import bench_physics
import physics_operations

TOOL = Path(__file__).parents[2] / "tools" / "bench_physics.py"


def test_the_benchmark_explains_itself() -> None:
    run = subprocess.run([sys.executable, str(TOOL), "--help"], capture_output=True, text=True, check=True)
    assert "--quick" in run.stdout
    assert "9000 gaits" in run.stdout


def test_the_grid_is_the_papers() -> None:
    assert bench_physics.grid().shape == (9000, 3)


def test_operations_grow_with_the_links_and_not_with_their_square() -> None:
    counts = [
        physics_operations.operations_per_step(bench_physics.model_of("penn_state", links=n))
        for n in (2, 3, 6, 32)
    ]
    a_link = counts[1] - counts[0]
    assert 500 < a_link < 1000
    assert counts[2] - counts[1] == 3 * a_link
    assert counts[3] - counts[2] == 26 * a_link
