"""``--help`` of a tool without options says what it does, and does nothing else."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from tool_calls import called

TOOLS = Path(__file__).resolve().parents[2] / "tools"


@pytest.mark.parametrize(
    "name", ["coverage_firmware", "picture_of_page", "mujoco_export_peers", "compile_kernels"]
)
def test_help_says_what_the_tool_does_and_does_nothing(name: str) -> None:
    done = called(TOOLS / f"{name}.py", "--help")
    assert done.returncode == 0
    assert done.stdout.startswith("usage:")
    assert len(done.stdout.splitlines()) < 15


def test_a_word_that_it_does_not_know_is_refused() -> None:
    done = called(TOOLS / "coverage_firmware.py", "nonsense")
    assert done.returncode == 2
    assert "nonsense" in done.stderr


def test_fit_all_finds_what_it_imports_from_anywhere(tmp_path: Path) -> None:
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    words = [sys.executable, str(TOOLS / "blind" / "fit_all"), "--help"]
    done = subprocess.run(words, cwd=tmp_path, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
