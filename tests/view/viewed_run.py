"""A run with its page, as a user starts it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

PROGRAM = [sys.executable, "-c", "from snakebot.cli.main import main; main()"]


@dataclass
class ViewedRun:
    """A ``snakebot run --view`` that is going on."""

    process: subprocess.Popen[str]
    url: str
    log: Path

    def ends(self, timeout_s: float = 30.0) -> int:
        """Its exit status."""
        self.process.communicate(timeout=timeout_s)
        return self.process.returncode


WAVE = ("run", "--alpha", "40", "--beta", "80", "--omega", "2", "--duration", "60")


@contextmanager
def viewed(log: Path, *options: str, motion: tuple[str, ...] = WAVE) -> Iterator[ViewedRun]:
    """A command that moves a robot, with its page."""
    with served(*motion, "--log", str(log), "--view", "--view-port", "0", *options) as (process, url):
        yield ViewedRun(process, url, log)


@contextmanager
def served(*words: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A command that serves a page; the page's address."""
    process = subprocess.Popen(
        [*PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        assert process.stderr is not None
        told = []
        for line in process.stderr:
            told.append(line)
            if found := re.search(r"page: (http://\S+)", line):
                yield process, found[1]
                break
        else:
            raise AssertionError(f"no page was served: {told}")
    finally:
        process.kill()
        process.communicate()


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., ViewedRun]]:
    """Start a viewed run; it is ended with the test."""
    with ExitStack() as stack:
        yield lambda *options, **more: stack.enter_context(viewed(tmp_path / "run.mcap", *options, **more))


@pytest.fixture
def board() -> Iterator[tuple[str, ...]]:
    """A simulated board on TCP, in a process of its own; the options that name it."""
    words = [*PROGRAM, "board", "sim", "--tcp", "0", "--watchdog-ms", "250", "--json"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield "--port", json.loads(process.stdout.readline())["port"]
    process.terminate()
    process.communicate()
