"""The two commands, and docs/analysis.md: every command and all code in it runs."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
from sample_runs import BENCH, PENN_STATE, bench_run, snake_run

from snakebot.cli.main import main
from snakebot.runlog import write_session
from snakebot.runlog.importing import write_run

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "analysis.md").read_text()
START_NS = 1_700_000_000_000_000_000


def run_command(*words: str) -> int:
    with pytest.raises(SystemExit) as ended:
        main(words)
    return int(ended.value.code or 0)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("made")
    first = snake_run(name="first", cycles=4)
    second = snake_run(name="second", cycles=4, effects=("rate_limit:limit_rad_s=1.8",))
    for run in (first, second):
        write_run(place / "runs" / run.name, PENN_STATE, run, {}, START_NS)
    write_session(place / "my_session", PENN_STATE, [first, second])
    write_session(place / "bench", BENCH, [bench_run("chirp")])
    return place


@pytest.fixture
def folder(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of its own for each test."""
    place = shutil.copytree(made, tmp_path / "here")
    monkeypatch.chdir(place)
    return place


def test_every_command_and_all_code_on_the_page_runs(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    blocks = dict(re.findall(r"```(console|python)\n(.*?)```", PAGE, re.DOTALL))
    commands = [shlex.split(line[2:]) for line in blocks["console"].splitlines()]
    assert len(commands) >= 5
    for words in commands:
        assert words[0] == "snakebot"
        assert run_command(*words[1:]) == 0, (words, capsys.readouterr().err)
    exec(compile(blocks["python"], "docs/analysis.md", "exec"), {})
    for name in ("report.html", "gap.html"):
        assert (folder / name).read_text().startswith("<!DOCTYPE html>")


def test_analyze_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command("analyze", "runs/first.mcap", "runs/second.mcap", "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert [run["name"] for run in data["runs"]] == ["first", "second"]
    assert data["runs"][1]["te"] > 1.2 * data["runs"][0]["te"]
    assert data["tables"]["speeds"][0]["runs"] == 2


def test_a_log_and_its_session_say_the_same(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = []
    for source in ("runs/second.mcap", "my_session/second.csv"):
        assert run_command("analyze", source, "--json") == 0
        found.append(json.loads(capsys.readouterr().out)["runs"][0])
    for key in ("te", "speed_m_s", "power_in_w"):
        assert found[0][key] == pytest.approx(found[1][key], rel=1e-4)


def test_compare_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command("compare", "runs/second.mcap", "runs/first.mcap", "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert data["alignment"]["shift_s"] == pytest.approx(0, abs=1e-3)
    assert data["speed_error_percent"] < 0


def test_a_bench_needs_no_body(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command("analyze", "bench", "--report", "bench.html") == 0
    assert run_command("compare", "bench/chirp.csv", "--report", "bench_gap.html") == 0
    assert "speed" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["analyze", "missing.mcap"], "no such log or session"),
        (["analyze", "my_session/nothing.csv"], "no such log or session"),
        (["analyze", "runs/first.mcap", "--robot", "nobody"], "no such file"),
        (["analyze", "bench", "--robot", "penn_state"], "1 joints"),
        (["analyze", "runs/first.mcap", "--report", "no/such/folder.html"], "does not exist"),
        (["analyze", "runs/first.mcap", "--report", "runs/first.mcap"], "is no report"),
        (["compare", "my_session"], "holds 2 runs"),
        (["compare", "bench/chirp.csv", "runs/first.mcap"], "not one robot"),
        (["compare", "docs.txt"], "no such log or session"),
    ],
)
def test_what_cannot_be_done_is_one_line(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], says: str
) -> None:
    assert run_command(*words) == 2
    shown = capsys.readouterr()
    assert says in shown.err
    assert len(shown.err.strip().splitlines()) == 1
    assert shown.out == ""


def test_inputs_are_left_as_they_were(folder: Path) -> None:
    before = (folder / "runs" / "first.mcap").read_bytes()
    assert run_command("analyze", "runs/first.mcap", "--report", "runs/first.mcap") == 2
    assert (folder / "runs" / "first.mcap").read_bytes() == before


REALDATA = ROOT.parent / "shared" / "realdata"


@pytest.mark.skipif(
    not REALDATA.is_dir(), reason="the recordings of real servos (../shared/realdata) are not here"
)
@pytest.mark.parametrize("name", ["pwm_servo_pendulum/with_weight", "xl330_pendulum/kp_400"])
def test_recordings_of_real_servos(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = tmp_path / "real.html"
    assert run_command("analyze", str(REALDATA / name), "--report", str(report), "--json") == 0
    runs = json.loads(capsys.readouterr().out)["runs"]
    assert all(np.isfinite(run["joints"][0]["rms_rad"]) for run in runs)
    lags = [run["joints"][0]["lag_s"] for run in runs if run["omega_rad_s"]]
    assert all(0.05 < lag < 0.3 for lag in lags), "these servos lag by 0.1 to 0.3 s"
    assert report.stat().st_size < 4_000_000
