"""docs/before-and-after.md: every command on it runs, and so does its Python."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from sessions import bench, make_session

from snakebot.cli.main import cli
from snakebot.runlog import write_session

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "before-and-after.md").read_text(encoding="utf-8")
COMMANDS = [line[2:] for line in PAGE.splitlines() if line.startswith("$ snakebot ")]


def test_the_page_has_the_commands_that_it_should() -> None:
    named = {" ".join(command.split()[1:3]) for command in COMMANDS}
    assert {"session plan", "session check", "robot export"} <= named
    assert {command.split()[1] for command in COMMANDS} >= {"predict", "diagnose"}


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_every_command_runs_in_this_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    robot = bench(1)
    Path("my_bench.yaml").write_text(robot.to_yaml())
    write_session("my_session", robot, make_session(robot, ["rate_limit:limit_rad_s=1.3"]).runs)
    for command in COMMANDS:
        result = CliRunner().invoke(cli, shlex.split(command)[1:], catch_exceptions=False)
        assert result.exit_code == 0, f"{command}: {result.output}"
    assert "intervals:" in Path("calibrated.yaml").read_text()
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert float(done.stdout.strip("[] \n")) == pytest.approx(0.3, abs=0.05)
