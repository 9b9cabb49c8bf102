"""What a user is told of a computer that stalls: in the summary, as a warning, and in the panel."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from rich.console import Console

from snakebot.cli import keys, summary
from snakebot.cli.panel import panel
from snakebot.control import Progress, RecordedRun, RunResult
from snakebot.control.progress import TrackingSoFar
from snakebot.gait import Gait


def result(*standstills_s: float, often_late: bool = False) -> RecordedRun:
    progress = Progress(10.0, TrackingSoFar(5, 1.0), often_late=often_late, worst_lateness_s=0.0054)
    for each_s in standstills_s:
        progress.standstill.add(each_s)
    return RecordedRun(RunResult("finished", 10.0, progress), Path("a.mcap"))


@pytest.fixture(autouse=True)
def wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")


def test_the_summary_counts_standstills(capsys: pytest.CaptureFixture[str]) -> None:
    summary.report(result(0.1, 0.15, 0.06), as_json=False)
    out, err = capsys.readouterr()
    assert "this computer stood still 3 times, 0.31 s in all, the longest 0.15 s" in out
    assert err == ""


def test_json_has_them_too(capsys: pytest.CaptureFixture[str]) -> None:
    summary.report(result(0.1, 0.15, 0.06), as_json=True)
    found = json.loads(capsys.readouterr().out)
    assert (found["standstills"], found["stood_still_s"]) == (3, 0.31)


def test_nothing_is_said_of_a_computer_that_hardly_stalls(capsys: pytest.CaptureFixture[str]) -> None:
    summary.report(result(0.001, 0.002), as_json=False)
    out, err = capsys.readouterr()
    assert "stood still" not in out + err


def test_a_run_that_took_much_longer_than_its_motion_is_a_warning(capsys: pytest.CaptureFixture[str]) -> None:
    summary.report(result(3.0, 1.5), as_json=True)
    err = capsys.readouterr().err
    assert err.startswith("snakebot: warning: the run took 14.5 s for 10.0 s of motion")
    assert err.count("\n") == 1


def test_ticks_that_are_often_late_are_one_warning(capsys: pytest.CaptureFixture[str]) -> None:
    summary.report(result(often_late=True), as_json=True)
    err = capsys.readouterr().err
    assert err.startswith("snakebot: warning: ticks start up to 5.4 ms late: ")
    assert err.count("\n") == 1


def test_the_panel_names_every_key_in_a_narrow_terminal() -> None:
    console = Console(width=80, record=True, file=io.StringIO())
    told = keys.shown(Gait(1, 1, 1))
    console.print(panel(result().progress, "a gait", "sim:", told, [1.0] * 5, 80))
    text = console.export_text()
    assert "space bar EMERGENCY STOP" in text
    assert "o/O offset" in text


@pytest.mark.parametrize(("standstills_s", "shown"), [((0.2, 0.11), True), ((0.001,), False)])
def test_the_panel_shows_them(standstills_s: tuple[float, ...], shown: bool) -> None:
    console = Console(width=100, record=True, file=io.StringIO())
    console.print(panel(result(*standstills_s).progress, "a gait", "sim:", "", [1.0] * 5, 100))
    assert ("stood still 2 times, 0.31 s in all" in console.export_text()) is shown
