"""``snakebot run`` with a course: what it refuses, with which status, and what it tells."""

from __future__ import annotations

import json
import socket
from pathlib import Path

import pytest

from snakebot.cli.main import main
from snakebot.runlog import read_log

RUN = ["run", "--alpha", "37", "--beta", "80", "--omega", "2"]


def status(*words: str) -> int:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert isinstance(ended.value.code, int)
    return ended.value.code


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--heading", "0", "--line", "y=0"], "not both"),
        (["--heading", "nan"], "--heading"),
        (["--heading", "900"], "--heading 900: within 360 deg"),
        (["--line", "y"], "--line"),
        (["--line", "y=0", "--lifted"], "cannot be held"),
        (["--line", "y=0", "--start", "1,2"], "--start"),
        (["--line", "y=0", "--start", "1,2,nan"], "--start"),
        (["--line", "y=0", "--alpha", "94.5", "--omega", "1"], "to steer with"),
        (["--line", "y=0", "--pose", "udp://127.0.0.1:9000", "--fast"], "leave out --fast"),
        (["--pose", "tcp://127.0.0.1:9000"], "--pose"),
        (["--start", "0,0,20", "--port", "serial:/dev/no_such_board"], "--start"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line_with_status_2(
    words: list[str],
    why: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert status(*RUN, *words) == 2
    told = capsys.readouterr().err.strip()
    assert why in told
    assert len(told.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_tracker_that_says_nothing_is_refused_with_status_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    assert status(*RUN, "--line", "y=0", "--pose", f"udp://127.0.0.1:{port}") == 2
    assert "start the tracker first" in capsys.readouterr().err
    assert not list(tmp_path.rglob("*.mcap*"))


def test_the_json_and_the_report_tell_the_course(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = [
        *RUN,
        "--line",
        "y=0",
        "--start",
        "0,0,20",
        "--cycles",
        "3",
        "--fast",
        "--json",
        "--log",
        "a.mcap",
    ]
    assert status(*words) == 0
    told = json.loads(capsys.readouterr().out)["steering"]
    assert told["decisions"] >= 3
    assert told["saturated"] == told["stale_times"] == told["bad_poses"] == 0
    assert abs(told["cross_track_m"]) < 0.3
    assert read_log("a.mcap").metadata["course"] == {
        "heading_deg": 0.0,
        "through_x_m": 0.0,
        "through_y_m": 0.0,
    }
    assert status("analyze", "a.mcap", "--report", "a.html") == 0
    page = Path("a.html").read_text(encoding="utf-8")
    for title in ("Path", "Heading error", "Distance from the line", "Steering offset"):
        assert f'"title":"{title}"' in page.replace(": ", ":")
    assert status("log", "export", "a.mcap", "a.csv") == 0
    assert "cross_track_m" in Path("a.csv").read_text().splitlines()[0]


def test_a_run_without_a_course_tells_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert status(*RUN, "--cycles", "1", "--fast", "--json", "--log", "a.mcap") == 0
    assert json.loads(capsys.readouterr().out)["steering"] is None
    assert read_log("a.mcap").steering_t_s.size == 0


def test_the_panel_shows_error_offset_and_limit() -> None:
    from rich.console import Console

    from snakebot.cli.panel import panel
    from snakebot.control.progress import Progress, SteeringSoFar, TrackingSoFar

    progress = Progress(10.0, TrackingSoFar(5, 1.0))
    progress.steering = SteeringSoFar(0.1, -0.05, 0.2, decisions=4, saturated=2, stale=True)
    console = Console(width=120, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    console.print(panel(progress, "title", "sim:", "", [1.6] * 5, 120))
    text = console.export_text()
    assert "heading error    5.7 deg" in text
    assert "off the line -0.050 m" in text
    assert "offset   11.5 deg" in text
    assert "at its limit 2 of 4" in text
    assert "NO POSE" in text
