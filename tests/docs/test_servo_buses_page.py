"""docs/servo-buses.md: every command on it runs, with emulated servos where the page has an adapter."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "servo-buses.md").read_text(encoding="utf-8")
COMMANDS = [line[2:] for line in PAGE.splitlines() if line.startswith("$ snakebot ")]
ADAPTER = "/dev/ttyUSB0"
SERVED = "serial:socket://127.0.0.1:5555"
PROGRAM = [sys.executable, "-m", "snakebot.cli.main"]


def started(words: list[str], folder: Path) -> tuple[subprocess.Popen[str], str]:
    """A program that stays, and the port that it prints."""
    process = subprocess.Popen([*PROGRAM, *words], stdout=subprocess.PIPE, text=True, cwd=folder)
    assert process.stdout is not None
    line = process.stdout.readline()
    assert line.startswith("--port "), line
    return process, line.split()[1]


def end(process: subprocess.Popen[str]) -> None:
    process.terminate()
    assert process.wait(20) == 0
    if process.stdout is not None:
        process.stdout.close()


@pytest.fixture
def adapter(tmp_path: Path) -> Iterator[str]:
    process, port = started(["board", "sim", "--feetech", "--robot", "sts3215_snake"], tmp_path)
    yield port.removeprefix("feetech:")
    end(process)


def test_the_page_has_the_commands_that_it_should() -> None:
    assert len(COMMANDS) >= 11
    named = {" ".join(command.split()[1:3]) for command in COMMANDS}
    assert {"board sim", "board list", "board serve", "robot calibrate", "robot list", "robot show"} <= named
    assert {command.split()[1] for command in COMMANDS} >= {"run", "jog", "doctor"}


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.timeout(300)
def test_every_command_on_the_page_runs(adapter: str, tmp_path: Path) -> None:
    """In the order of the page: calibrate writes the description that later ones use."""
    serving: subprocess.Popen[str] | None = None
    served = ""
    for command in COMMANDS:
        words = [w.replace(ADAPTER, adapter).replace(SERVED, served) for w in shlex.split(command)[1:]]
        if words[:2] == ["board", "sim"]:
            process, _ = started(words, tmp_path)
            end(process)
            continue
        if words[:2] == ["board", "serve"]:
            words[words.index("--tcp") + 1] = "127.0.0.1:0"
            serving, served = started(words, tmp_path)
            continue
        if words[0] in ("run", "jog"):
            words.append("--yes")
        # a person at a terminal: enter, and turns of joints; keys
        typed = {"robot": "\n" * 20, "jog": "++q"}.get(words[0], "")
        if words[:2] == ["robot", "calibrate"]:
            words.append("--zeros-only")  # nobody turns the joints here
        done = subprocess.run(
            [*PROGRAM, *words], input=typed, capture_output=True, text=True, cwd=tmp_path, timeout=60
        )
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    assert serving is not None
    end(serving)


def test_every_register_and_option_on_the_page_exists() -> None:
    from snakebot.robot import JointServo
    from snakebot.servobus.models import MODELS

    for name in re.findall(r"\b(XL330|XL430|2XC430|XM430|STS3215|SCS0009)\b", PAGE):
        assert name.lower() in MODELS
    for key in ("id", "model", "direction", "zero_counts", "torque_limit"):
        assert key in JointServo.model_fields
        assert f"{key}:" in PAGE
