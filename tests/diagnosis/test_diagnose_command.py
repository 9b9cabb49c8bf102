"""``snakebot diagnose`` as a user calls it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner, Result
from sessions import bench, make_session

from snakebot.cli import diagnose_live
from snakebot.cli.diagnose import command
from snakebot.effects import robot_effects
from snakebot.errors import BadInputError, SnakebotError
from snakebot.robot import load_robot
from snakebot.runlog import write_session


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("diagnose") / "my_session"
    session = make_session(bench(1), ["rate_limit:limit_rad_s=1.3"])
    write_session(path, session.robot, session.runs, "csv")
    return path


def call(*arguments: object) -> Result:
    return CliRunner().invoke(command, [str(a) for a in arguments], catch_exceptions=True)


def test_verdict_report_and_calibrated_robot(folder: Path, tmp_path: Path) -> None:
    verdict, page, robot = tmp_path / "verdict.json", tmp_path / "verdict.html", tmp_path / "calibrated.yaml"
    only = ("--only", "rate_limit", "--only", "servo_lag")
    result = call(folder, "--json", verdict, "--report", page, "--apply", robot, "--quick", *only)
    assert result.exit_code == 0, result.output
    assert "oint 1 cannot turn faster than 1.30 rad/s" in result.output
    advised = r"snakebot run .* --effect rate_limit:limit_rad_s=1\.(3|29\d*) --robot ROBOT.yaml\n"
    assert re.search(advised, result.output)
    data = json.loads(verdict.read_text())
    assert data["verdict"] == "explained"
    text = page.read_text()
    assert "oint 1 cannot turn faster than 1.30 rad/s" in text
    assert "How it shows" in text
    (spec,) = robot_effects(load_robot(robot))
    assert spec.name == "rate_limit"
    assert spec.value("limit_rad_s") == pytest.approx(1.3, rel=0.01)
    assert yaml.safe_load(robot.read_text())["provenance"]["effects.rate_limit"]["status"] == "fitted"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["calibrated.yaml", "verdict.html", "verdict.json"]


def test_json_to_standard_output_is_json_alone(folder: Path) -> None:
    result = call(folder, "--json", "-", "--only", "rate_limit", "--quick")
    assert json.loads(result.output)["schema"] == "snakebot.diagnosis/2"


def test_bad_input_is_one_line_and_writes_nothing(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "x.json"
    for arguments, words in (
        ((tmp_path / "nothing", "--json", out), "nothing"),
        ((folder, "--only", "rate_limt", "--json", out), "rate_limt"),
        ((folder, "--known", "limit_rad_s", "--json", out), "PARAM=VALUE"),
        ((folder, "--json", tmp_path / "no" / "x.json"), "does not exist"),
        ((folder, "--report", tmp_path), "is a folder"),
    ):
        result = call(*arguments)
        assert isinstance(result.exception, BadInputError), result.output
        assert result.exception.exit_status == 2
        assert words in str(result.exception)
        assert "\n" not in str(result.exception)
    assert list(tmp_path.iterdir()) == []


def test_apply_without_a_cause_is_refused_but_the_verdict_stands(tmp_path: Path) -> None:
    session = make_session(bench(1))
    write_session(tmp_path / "s", session.robot, session.runs, "csv")
    result = call(tmp_path / "s", "--apply", tmp_path / "robot.yaml", "--quick")
    assert result.exit_code == 0
    assert "No gap" in result.output
    assert not (tmp_path / "robot.yaml").exists()


def test_a_cancelled_diagnosis_leaves_nothing(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import snakebot.diagnosis.engine as engine

    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(engine, "search", stop)
    result = call(folder, "--json", tmp_path / "x.json", "--report", tmp_path / "x.html")
    assert result.exit_code != 0
    assert list(tmp_path.iterdir()) == []


def test_the_commands_in_the_documentation_are_understood(
    folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    text = (Path(__file__).parents[2] / "docs" / "diagnosis.md").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line.startswith("snakebot diagnose my_session")]
    assert len(lines) == 3
    for line in text.splitlines():
        if line.startswith("snakebot diagnose --live"):
            with command.make_context("diagnose", line.split()[2:]) as context:
                assert context.params["live"]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_session").symlink_to(folder)
    for line in lines:
        result = call(*line.split()[2:], "--quick", "--quiet", "--only", "rate_limit")
        assert result.exit_code == 0, (line, result.output, result.exception)


@pytest.mark.slow
def test_live_runs_a_starting_set_on_the_simulated_board_and_finds_the_effect(tmp_path: Path) -> None:
    arguments = (
        "--live",
        tmp_path / "logs",
        "--fast",
        "--yes",
        "--quick",
        "--quiet",
        "--json",
        tmp_path / "v.json",
    )
    result = call(*arguments, "--effect", "rate_limit:limit_rad_s=1.5,joints=2")
    assert result.exit_code == 0, (result.output, result.exception)
    (cause,) = json.loads((tmp_path / "v.json").read_text())["causes"]
    assert (cause["effect"], cause["joints"]) == ("rate_limit", [2])
    assert len(list((tmp_path / "logs").glob("*.mcap"))) == 5


def test_live_with_nobody_to_ask_or_no_such_port_makes_nothing(tmp_path: Path) -> None:
    for words, said in (
        (["--fast"], "there is nobody to ask"),
        (["--port", "serial:/dev/no_such_port", "--yes"], "/dev/no_such_port"),
    ):
        result = call("--live", tmp_path / "logs", *words)
        assert isinstance(result.exception, SnakebotError)
        assert said in str(result.exception)
        assert not (tmp_path / "logs").exists()


def test_live_asks_before_anything_moves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnose_live, "confirmable", lambda options: None)  # the runner is no terminal
    result = CliRunner().invoke(command, ["--live", str(tmp_path / "logs"), "--fast"], input="n\n")
    assert isinstance(result.exception, BadInputError)
    assert "fewer than two runs" in str(result.exception)
    assert list((tmp_path / "logs").iterdir()) == []
