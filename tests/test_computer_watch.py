"""A failure is the computer's only where it stood still; then the test is asked again, alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from computer_watch import ALLOWED_S, ComputerWatch

TRIALS = 50  # of a tenth of a second each: what stood still before counts in all of them, or in none


@pytest.fixture
def watch() -> Iterator[ComputerWatch]:
    watch = ComputerWatch()
    time.sleep(1.0)  # a process starts
    watch.begin()
    yield watch
    watch.end()


def test_a_computer_that_stood_still_is_noticed(watch: ComputerWatch) -> None:
    os.kill(watch.pid, signal.SIGSTOP)
    time.sleep(0.1 + ALLOWED_S)
    os.kill(watch.pid, signal.SIGCONT)
    assert watch.kept_waiting(AssertionError("5 == 0"))


def test_what_a_run_says_of_it_counts_too(watch: ComputerWatch) -> None:
    assert watch.kept_waiting(AssertionError("snakebot: this computer stood still for 0.3 s"))


def test_what_stood_still_before_the_test_does_not_count(watch: ComputerWatch) -> None:
    os.kill(watch.pid, signal.SIGSTOP)
    time.sleep(0.1 + ALLOWED_S)
    os.kill(watch.pid, signal.SIGCONT)
    assert watch.stood_still()
    for _ in range(TRIALS):  # a busy computer keeps a process waiting now and then, here too
        watch.begin()
        if not watch.stood_still():
            return
    pytest.fail(f"a time before the test still counts, {TRIALS} times")


HERE = """
import computer_watch
computer_watch.DELAY_S = 0.1
def pytest_configure(config):
    config.pluginmanager.register(computer_watch.AskAgain(config))
"""
WHO_IS_ASKED = """
import computer_watch
from pathlib import Path
computer_watch.ComputerWatch.kept_waiting = lambda watch, error: Path(f"asked-{error}").touch()
def test_right():
    pass
def test_wrong():
    raise ValueError("wrong")
"""


TWO = """
import time
from pathlib import Path
import pytest
TOLD = Path(__file__).with_name("told")
def tell(line):
    with TOLD.open("a") as file:
        file.write(line + "\\n")
@pytest.mark.timeout(1)
def test_alone():
    tell("alone")
    time.sleep(0.6)
    tell("alone")
    assert TOLD.read_text().count("alone") == 6, "this computer stood still for 0.3 s"
@pytest.mark.timeout(2)
@pytest.mark.parametrize("number", range(12))
def test_beside(number):
    tell("beside")
    time.sleep(0.6)
    tell("beside")
"""


STILL = """
import os, signal, time
def test_still(request):
    watch = next(p for p in request.config.pluginmanager.get_plugins() if hasattr(p, "watch")).watch
    os.kill(watch.pid, signal.SIGSTOP)
    time.sleep(0.3)
    os.kill(watch.pid, signal.SIGCONT)
    assert 5 == 0
"""


def suite(folder: Path, tests: str, *options: str) -> subprocess.CompletedProcess[str]:
    (folder / "conftest.py").write_text(HERE)
    (folder / "pytest.ini").write_text(f"[pytest]\npythonpath = {Path(__file__).parent}\n")
    (folder / "test_here.py").write_text(tests)
    words = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *options]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=100, check=False)


@pytest.mark.slow
@pytest.mark.real_time
def test_a_test_that_is_asked_again_has_the_computer_to_itself(tmp_path: Path) -> None:
    done = suite(tmp_path, TWO, "-n", "2", "--dist", "load")
    assert done.returncode == 0, done.stdout
    assert "13 passed, 2 rerun" in done.stdout
    told = (tmp_path / "told").read_text().split()
    assert told.count("alone") == 6
    for again in (2, 4):
        begin = [at for at, word in enumerate(told) if word == "alone"][again]
        assert told[begin : begin + 2] == ["alone", "alone"], told


def test_what_passes_does_not_wait_for_the_watch(tmp_path: Path) -> None:
    done = suite(tmp_path, WHO_IS_ASKED)
    assert "1 failed, 1 passed" in done.stdout
    assert [path.name for path in tmp_path.glob("asked-*")] == ["asked-wrong"]


def test_what_fails_each_time_fails_on_a_computer_that_stands_still_too(tmp_path: Path) -> None:
    done = suite(tmp_path, STILL)
    assert done.returncode == 1, done.stdout
    assert "1 failed, 3 rerun" in done.stdout


def test_what_fails_on_a_computer_that_keeps_its_time_fails(tmp_path: Path) -> None:
    done = suite(tmp_path, "def test_wrong():\n    assert 5 == 0\n")
    assert done.returncode == 1, done.stdout
    assert "1 failed" in done.stdout
