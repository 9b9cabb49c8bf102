"""``snakebot run --probe``: the motion, its log, a session of it, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from snakebot.cli.main import main
from snakebot.runlog import open_session, read_log

TRIANGLE = "triangle:amplitude_deg=5,rate_deg_s=20,joints=3"


def call(*arguments: str) -> int:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    return int(ended.value.code or 0)


def test_a_probe_moves_its_joint_alone_and_the_log_and_a_session_say_which(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "probe.mcap"
    assert call("run", "--probe", TRIANGLE, "--cycles", "2", "--fast", "--json", "--log", str(log)) == 0
    assert json.loads(capsys.readouterr().out)["ended"] == "finished"
    run = read_log(log).to_run()
    assert run.gait is None
    assert run.metadata["probe"] == TRIANGLE
    moved = np.degrees(np.abs(run.measured_rad).max(axis=0))
    assert moved[2] == pytest.approx(5, abs=0.5)
    assert np.delete(moved, 2).max() < 0.1
    assert call("session", "make", str(tmp_path / "session"), str(log)) == 0
    (again,) = open_session(tmp_path / "session").runs
    assert again.gait is None
    assert again.metadata["probe"] == TRIANGLE
    capsys.readouterr()
    assert call("log", "list", str(tmp_path)) == 0
    assert "triangle" in capsys.readouterr().out
    assert call("analyze", str(log), "--json") == 0


def test_a_lifted_robot_bears_no_load_and_the_log_says_so(tmp_path: Path) -> None:
    """A soft joint gives way to the ground; in the air a slow one bears next to nothing."""
    bend = {}
    slow = "sine:amplitude_deg=20,omega_rad_s=2"
    for where in ((), ("--lifted",)):
        log = tmp_path / f"{len(where)}.mcap"
        soft = ("--effect", "compliance:stiffness_nm_rad=5")
        assert call("run", "--probe", slow, "--cycles", "2", "--fast", *soft, "--log", str(log), *where) == 0
        run = read_log(log).to_run()
        bend[run.metadata.get("lifted", False)] = np.abs(run.measured_rad[:, 2] - run.command_rad[:, 2]).max()
    assert set(bend) == {False, True}
    assert bend[True] < 0.6 * bend[False]


def test_a_dry_run_shows_a_probe_and_its_limits(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("run", "--probe", "steps:amplitude_deg=20", "--dry-run", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["gait"] is None
    assert shown["probe"] == "steps:amplitude_deg=20"
    assert shown["joints"][0]["angle_deg"] == pytest.approx(20)
    assert call("run", "--probe", TRIANGLE, "--dry-run") == 0
    assert TRIANGLE.split(",")[0] in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--probe", TRIANGLE, "--alpha", "66"), "--probe or --alpha, not both"),
        (("--probe", TRIANGLE, "--gait", "gentle"), "--probe or --gait, not both"),
        (("--probe", "wobble:amplitude_deg=3"), "triangle, steps, sine"),
        (("--probe", TRIANGLE, "--cycles", "1.5"), "whole cycles"),
        (("--probe", TRIANGLE, "--duration", "4.5"), "no room"),
        (("--probe", TRIANGLE, "--cycles", "1e9"), "10000"),
        (("--probe", "triangle:amplitude_deg=1e-6,rate_deg_s=1000", "--duration", "1e5"), "at most"),
        (("--probe", "steps:amplitude_deg=120,joints=1"), "allows 95"),
        (("--probe", "steps:amplitude_deg=20,joints=9"), "robot with 5 joints"),
    ],
)
def test_what_cannot_be_probed_is_one_line_and_status_2(
    arguments: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call("run", *arguments, "--dry-run") == 2
    error = capsys.readouterr().err
    assert words in error
    assert len(error.strip().splitlines()) == 1
