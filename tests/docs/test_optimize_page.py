"""docs/optimize.md: its commands run, in the order of the page, where somebody has a session."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from snakebot.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "optimize.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^\$ (snakebot .*)$", PAGE, flags=re.MULTILINE)
# Faster than what the page says, the same otherwise: few draws, a coarse first look, and a narrow space.
LESS = {
    "optimize": ["--draws", "2", "--grid", "4,4,3"],
    "diagnose": ["--quick", "--only", "rate_limit"],
    "run": ["--cycles", "2"],
}
NARROW = ["--within", "alpha=25..50,beta=60..100,omega=1..4"]


def call(*words: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 0, words


def words_of(command: str) -> list[str]:
    words = shlex.split(command)[1:]
    narrow = [] if words[0] != "optimize" or "--within" in words else NARROW
    live = ["--budget", "5", "--repeats", "2"] if "--live" in words else []
    return [*words, *LESS[words[0]], *narrow, *live]


def test_the_page_has_its_commands() -> None:
    assert [command.split()[1] for command in COMMANDS] == ["diagnose", "optimize", "run", *["optimize"] * 5]
    tool = re.findall(r"^\$ (tools/\S+)", PAGE, flags=re.MULTILINE)
    assert all((ROOT / path).exists() for path in tool)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_commands_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    effect = "rate_limit:limit_rad_s=1.5"
    for number, gait in enumerate(("50 80 2", "30 80 4", "30 80 1", "50 80 2")):
        alpha, beta, omega = gait.split()
        call("run", "--alpha", alpha, "--beta", beta, "--omega", omega, "--duration", "6", "--fast", "--effect",
             effect, "--seed", str(number), "--log", f"SESSION/run_{number}.mcap")  # fmt: skip
    for command in COMMANDS:
        call(*words_of(command))
        if command.split()[1:3] == ["optimize", "calibrated.yaml"]:
            gait = Path("results/optimize_calibrated/gait.yaml").read_text()
            assert "source: snakebot optimize calibrated.yaml --for speed" in gait
    assert "ci95" in Path("calibrated.yaml").read_text()
    assert Path("results/optimize_penn_state/optimum.png").exists()
