"""docs/view.md and the README: every command that serves a page serves it, and ends with Ctrl-C."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tool_calls import called

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8") + (ROOT / "docs" / "view.md").read_text(
    encoding="utf-8"
)
COMMANDS = sorted(
    {line.strip() for line in TEXT.splitlines() if re.match(r"    snakebot (view |.* --view)", line)}
)
PROGRAM = [sys.executable, "-c", "from snakebot.cli.main import main; main()"]
RUN = ["run", "--alpha", "40", "--beta", "80", "--omega", "2", "--duration", "5", "--fast"]


@pytest.fixture(scope="module")
def port() -> Iterator[str]:
    """A simulated board on TCP stands where the page has a robot."""
    command = [*PROGRAM, "board", "sim", "--tcp", "0", "--watchdog-ms", "250", "--json"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    yield json.loads(process.stdout.readline())["port"]
    process.terminate()
    process.communicate()


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_serves_its_page(command: str, port: str, tmp_path: Path) -> None:
    subprocess.run([*PROGRAM, *RUN, "--log", "runs/REAL.mcap"], cwd=tmp_path, check=True, capture_output=True)
    words = [port if word.startswith("can:") else word for word in shlex.split(command)[1:]]
    words += ["--yes"] if "--live" in words else []
    process = subprocess.Popen(
        [*PROGRAM, *words, "--view-port", "0"], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    try:
        told = next(line for line in process.stderr if line.startswith("page: "))
        assert "http://127.0.0.1:" in told
        os.kill(process.pid, signal.SIGINT)
        process.communicate(timeout=40)
    finally:
        process.kill()
        process.communicate()
    assert process.returncode in (0, 130)


def test_the_pages_name_what_there_is() -> None:
    assert len(COMMANDS) >= 5
    assert "docs/view.png" in TEXT


def test_the_benches_that_are_named_are_there() -> None:
    for name, options in re.findall(r"`tools/(bench_\w+\.py)([^`]*)`", TEXT):
        done = called(ROOT / "tools" / name, "--help")
        assert done.returncode == 0
        for option in re.findall(r"--\w+", options):
            assert option in done.stdout, (name, option)
