"""Linters, fuzzer and coverage: slow, and only where their programs are installed."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from building import FIRMWARE, ROOT, need

pytestmark = pytest.mark.slow


def run(*command: str, timeout_s: float = 600.0) -> str:
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=timeout_s)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    return done.stdout


@pytest.mark.timeout(600)
def test_cppcheck_and_clang_tidy_are_content() -> None:
    need("make", "cppcheck", "clang-tidy")
    run("make", "-C", str(FIRMWARE), "check")


@pytest.mark.timeout(600)
def test_a_while_of_fuzzing_finds_nothing() -> None:
    need("clang")
    printed = run(sys.executable, "tools/fuzz_firmware.py", "--runs", "40000", "--seed", "99")
    assert "executions: 40000, findings: 0" in printed


@pytest.mark.timeout(600)
def test_branches_of_the_core_are_covered() -> None:
    need("cc", "gcovr")
    printed = run(sys.executable, "tools/coverage_firmware.py")
    covered = re.search(r"core: (\d+\.\d) % of \d+ branches", printed)
    assert covered is not None, printed
    assert float(covered[1]) > 95.0


def test_other_compilers_see_no_warning(tmp_path_factory: pytest.TempPathFactory) -> None:
    need("make", "clang")
    out = tmp_path_factory.mktemp("clang")
    run("make", "-C", str(FIRMWARE), "all", "bench", "CC=clang", f"OUT={out}")
