"""The page in a real Chromium: the run is seen moving, its gait changes, STOP ends it, a lost server shows in red."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import urllib.parse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewed_run import ViewedRun, served, viewed
from visits import NEEDED, Visit

from snakebot.errors import EXIT_BOARD_FAULT
from snakebot.robot import load_robot
from snakebot.runlog import RunWriter, read_log, records

pytestmark = [pytest.mark.slow, pytest.mark.real_time, NEEDED]
Start = Callable[..., ViewedRun]


@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (390, "dark")])
def test_the_robot_is_seen_moving_on_a_screen_and_on_a_phone(
    width: int, scheme: str, browser: Any, start: Start
) -> None:
    visit = Visit(browser, start().url, width, scheme)
    page = visit.page
    visit.wait("parseFloat(document.getElementById('clock').textContent) > 2.5")
    before, picture = visit.measured(), page.locator("#body").screenshot()
    page.wait_for_timeout(400)
    assert visit.measured() != before
    assert page.locator("#body").screenshot() != picture
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    box = page.locator("#stop").bounding_box()
    assert box["y"] >= 0
    assert box["y"] + box["height"] <= 800
    assert page.locator("#events").inner_text() != ""
    assert visit.complaints == []


def test_a_slider_changes_the_gait_on_the_board(browser: Any, start: Start) -> None:
    run = start("--ramp", "0.5")
    visit = Visit(browser, run.url)
    visit.wait("parseFloat(document.getElementById('clock').textContent) > 0.5")
    visit.page.locator("input[name=alpha_deg]").fill("25")
    visit.page.wait_for_timeout(2500)
    visit.page.locator("input[name=alpha_deg]").evaluate("e => e.blur()")
    visit.wait("document.querySelector('#events').textContent.includes('changed to alpha 25 deg')")
    visit.page.locator("#ramp").click()
    assert run.ends() == 130
    log = read_log(run.log)
    late = log.applied_rad[(log.t_s > log.t_s[-1] - 1.5) & (log.t_s < log.t_s[-1] - 0.6)]
    assert abs(late).max() < 0.5


def test_a_slider_beyond_a_limit_says_which_before_anything_is_sent(browser: Any, start: Start) -> None:
    run = start("--ramp", "0.5", "--omega", "6")
    visit = Visit(browser, run.url)
    visit.page.locator("input[name=alpha_deg]").fill("89")
    visit.wait("document.getElementById('limits').textContent.includes('beyond the limit of')")
    assert visit.page.locator("#events").inner_text().count("changed to") == 0


def test_the_space_bar_cuts_the_power_also_on_a_slider(browser: Any, start: Start) -> None:
    run = start()
    visit = Visit(browser, run.url)
    visit.page.locator("input[name=omega_rad_s]").focus()
    visit.page.keyboard.press("Space")
    assert run.ends() == EXIT_BOARD_FAULT
    visit.wait("!document.getElementById('lost').hidden")


def test_a_joint_is_freed_by_click(browser: Any, start: Start) -> None:
    run = start()
    visit = Visit(browser, run.url)
    visit.page.locator("#joints tbody tr:nth-child(3) select").select_option("free")
    visit.wait("document.querySelectorAll('#joints td.free').length === 1")


def test_a_server_that_hangs_shows_in_red_within_a_second(browser: Any, start: Start) -> None:
    run = start()
    visit = Visit(browser, run.url)
    children = Path(f"/proc/{run.process.pid}/task/{run.process.pid}/children").read_text().split()
    os.kill(int(children[0]), signal.SIGSTOP)
    try:
        visit.wait("!document.getElementById('lost').hidden", timeout_s=1.0)
    finally:
        os.kill(int(children[0]), signal.SIGCONT)
    visit.wait("document.getElementById('lost').hidden")
    os.kill(int(children[0]), signal.SIGKILL)
    visit.wait("!document.getElementById('lost').hidden", timeout_s=1.0)


def test_two_pages_one_drives(browser: Any, start: Start) -> None:
    run = start()
    first, second = Visit(browser, run.url), Visit(browser, run.url)
    second.wait("document.getElementById('drive').textContent.includes('Another page drives')")
    assert second.page.locator("input[name=alpha_deg]").is_disabled()
    first.page.close()
    second.wait("document.getElementById('drive').textContent.includes('No page drives')")
    second.page.locator("#drive").click()
    second.wait("!document.querySelector('input[name=alpha_deg]').disabled")


def test_an_open_page_shows_the_next_run_at_its_address(browser: Any, tmp_path: Path) -> None:
    with viewed(tmp_path / "a.mcap") as first:
        visit = Visit(browser, first.url)
        visit.page.locator("#stop").click()
        visit.wait("document.getElementById('said').textContent === 'STOP: the run has been told'")
        visit.wait("document.getElementById('lost').textContent.includes('joints are without power')")
        visit.wait("document.querySelectorAll('#joints td.no-power').length === 5")
        assert first.ends() == EXIT_BOARD_FAULT
    port = str(urllib.parse.urlsplit(first.url).port)
    with viewed(tmp_path / "b.mcap", "--view-port", port, "--alpha", "20") as _:
        visit.wait("document.getElementById('title').textContent.startsWith('alpha 20')")
        visit.wait("document.getElementById('mode').textContent === 'armed'")
        visit.wait("document.getElementById('lost').hidden")
        visit.wait("!document.querySelector('#joints select').hidden")


def test_a_probe_has_no_sliders_and_a_page_that_looks_on_no_ramp(
    browser: Any, start: Start, board: tuple[str, ...]
) -> None:
    probe = start(motion=("run", "--probe", "triangle:amplitude_deg=5,rate_deg_s=10,joints=3"))
    visit = Visit(browser, probe.url)
    visit.wait("document.getElementById('gait-box').hidden")
    visit.wait("!document.querySelector('#joints select').hidden")
    with served("view", *board, "--view-port", "0") as (_, url):
        visit = Visit(browser, url, mode="disarmed")
        assert visit.page.locator("#ramp").is_hidden()
        assert visit.page.locator("#gait-box").is_hidden()
        assert visit.page.locator("#joints select").count() == 0
        visit.page.keyboard.press("Space")
        visit.wait("document.getElementById('mode').textContent === 'stopped'")
        assert visit.complaints == []


@pytest.mark.parametrize("links", [2, 17])
def test_one_joint_and_sixteen(links: int, browser: Any, start: Start, tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "configs" / "robots" / "penn_state.yaml").read_text()
    robot = tmp_path / "robot.yaml"
    robot.write_text(text.replace("links: 6", f"links: {links}"))
    visit = Visit(browser, start("--robot", str(robot), "--beta", "40", "--alpha", "25").url, 390)
    visit.wait("parseFloat(document.getElementById('clock').textContent) > 0.5")
    assert len(visit.measured()) == links - 1
    assert visit.page.locator("#strips .uplot").count() == links - 1
    assert visit.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert visit.complaints == []


@pytest.mark.timeout(300)
def test_a_page_that_stays_open_does_not_grow(tmp_path: Path) -> None:
    """Eight minutes of a run's time at ten times its pace; `tools/bench_view.py --minutes 10` is the whole of it."""
    command = [
        sys.executable,
        "tools/bench_view.py",
        "--stops",
        "0",
        "--minutes",
        "0.8",
        "--speed",
        "10",
        "--json",
    ]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[2])
    assert done.returncode == 0, done.stderr
    first, last = (json.loads(done.stdout)["open"][name] for name in ("first", "last"))
    assert last["elements"] <= first["elements"] + 200  # the events of what was played meanwhile
    assert last["listeners"] <= first["listeners"] + 5
    assert last["heap_kb"] <= first["heap_kb"] + 2000
    assert last["server_kb"] <= first["server_kb"] + 8000


def test_a_recording_without_a_pose_shows_the_body_and_at_its_end_no_active_joint(
    browser: Any, tmp_path: Path
) -> None:
    path, start_ns = tmp_path / "run.mcap", 1_700_000_000_000_000_000
    with RunWriter(path, load_robot("penn_state"), {"note": "x"}, start_time_ns=start_ns) as writer:
        for number in range(100):
            t_s = number * 0.01
            angles = np.full(5, 0.2)
            writer.tick(
                records.Tick(number, t_s, start_ns + round(t_s * 1e9), angles, angles, angles, angles)
            )
        writer.event(records.Event(1.2, "disarmed", "joints relaxed"))
    with served("view", str(path), "--view-port", "0") as (_, url):
        visit = Visit(browser, url, 390, mode="recording")
        visit.wait("document.getElementById('pose').textContent.startsWith('no pose')")
        visit.wait(f"({DRAWN})('--measured') > 500")
        visit.wait("document.getElementById('play').textContent === 'play'")
        visit.wait("document.querySelectorAll('#joints td.no-power').length === 5")
        assert visit.complaints == []


# How many dots of the body's picture have one of the page's colours.
DRAWN = """(name) => {
  const canvas = document.getElementById('body'), size = [0, 0, canvas.width, canvas.height];
  const hex = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const wanted = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  const dots = canvas.getContext('2d').getImageData(...size).data;
  let found = 0;
  for (let at = 0; at < dots.length; at += 4) found += wanted.every((part, k) => dots[at + k] === part) ? 1 : 0;
  return found;
}"""
