"""``diagnose --live --view``: one page over all runs, with the verdict as it forms, and a STOP that ends them all."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest
from page_client import PageClient
from viewed_run import PROGRAM, served
from websockets.exceptions import ConnectionClosed

from snakebot.errors import EXIT_BOARD_FAULT

LIVE = ("--fast", "--yes", "--quick", "--quiet", "--budget", "5", "--view", "--view-port", "0")
EFFECT = ("--effect", "rate_limit:limit_rad_s=1.5")


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.timeout(900)  # a busy computer takes its time for a diagnosis
def test_a_page_stays_over_all_runs_and_shows_the_verdict(tmp_path: Path) -> None:
    stories: list[dict[str, Any]] = []
    titles: list[str] = []
    with served("diagnose", "--live", str(tmp_path / "logs"), *LIVE, *EFFECT) as (process, url):
        page = PageClient(url)
        last: dict[str, Any] = {}
        try:
            while True:
                message = page.read(400.0)
                if message["type"] == "hello":
                    titles.append(message["title"])
                elif message["type"] == "frame":
                    last = message
                    stories += [message["story"]] if "story" in message else []
        except ConnectionClosed:
            pass
        out, _ = process.communicate(timeout=60)
        assert process.returncode == 0
    assert len(set(titles)) >= 4  # each run says what it is
    assert any("of the starting set is going on" in story["now"] for story in stories)
    assert any(story["now"].startswith("diagnosing 5 runs: ") for story in stories)
    final = stories[-1]
    assert [run["how"].split()[1] for run in final["runs"]] == ["ticks,"] * 5
    assert all(run["command"].startswith("snakebot run --alpha") for run in final["runs"])
    assert final["verdict"] == out.splitlines()[0]
    assert final["causes"][0]["name"].startswith("a limit of speed")
    assert final["causes"][0]["parameters"][0].startswith("fastest turn: 1.5")
    assert last["status"]["how"] == "the verdict stands"


@pytest.mark.slow
@pytest.mark.real_time
@pytest.mark.timeout(900)  # a busy computer takes its time for a diagnosis
@pytest.mark.parametrize(("wish", "status"), [("stop", EXIT_BOARD_FAULT), ("ramp_down", 130)])
def test_an_end_during_the_diagnosis_ends_it(wish: str, status: int, tmp_path: Path) -> None:
    with served("diagnose", "--live", str(tmp_path / "logs"), *LIVE, *EFFECT) as (process, url):
        page = PageClient(url)
        page.until(lambda m: m.get("story", {}).get("now", "").startswith("diagnosing"), 400.0)
        assert page.ask(do=wish) is None
        _, errors = process.communicate(timeout=60)
        assert process.returncode == status
        assert "holds 5 logs" in errors


@pytest.mark.slow
@pytest.mark.real_time
def test_options_of_the_page_are_refused_without_live(tmp_path: Path) -> None:
    done = subprocess.run([*PROGRAM, "diagnose", str(tmp_path), "--view"], capture_output=True, text=True)
    assert done.returncode == 2
    assert "--view: only with --live" in done.stderr
