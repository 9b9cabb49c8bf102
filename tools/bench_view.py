#!/usr/bin/env python3
"""The live page, measured in Chromium: from STOP to joints without power, and whether a page that stays open grows.

  stop   runs with a page, one after the other, on a simulated board in a process of its own (TCP); the page draws at
         full rate; STOP is clicked; an onlooker on the same TCP port notes when the board reports STOPPED. The time
         counts from the browser's own stamp on the click, so that it holds what the page was drawing then ("until the
         page's script" is the part before its script was called). Beside it
         runs that `snakebot stop` stops, which needs no page (its time counts from the start of that process).
  open   a page that plays a recording for --minutes at --speed: memory of page and server, and the page's elements,
         after the first tenth of the time (at least a minute of the run's own time) and at the end

Open pages beside the run loop: `tools/bench_loop.py --view`, which takes its figures from here.

Aim for stop: p99 below 50 ms at 100 Hz.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

CHROMIUM = next(
    (p for name in ("chromium", "chromium-browser", "google-chrome") if (p := shutil.which(name))), None
)
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-sync",
]
SNAKEBOT = [sys.executable, "-m", "snakebot.cli.main"]
PAGES = 3
NONE, THREE, CONTROL = "no page", f"{PAGES} pages", "none again"  # in these turns the run loop is measured


@contextmanager
def board() -> Iterator[str]:
    """A simulated board on TCP; the port to use."""
    process = subprocess.Popen(
        [*SNAKEBOT, "board", "sim", "--tcp", "0", "--json"], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        yield json.loads(process.stdout.readline())["port"]
    finally:
        process.terminate()
        process.wait()


@contextmanager
def run(port: str, log: Path, seconds: float, *options: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A run with or without a page; its address."""
    words = ["run", "--alpha", "40", "--beta", "80", "--omega", "2", "--duration", f"{seconds:g}"]
    with served(*words, "--port", port, "--log", str(log), "--json", *options) as started:
        yield started


@contextmanager
def served(*words: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A command that serves a page, and the page's address; "" where it serves none."""
    process = subprocess.Popen([*SNAKEBOT, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    url = ""
    try:
        if "--view-port" in words:
            assert process.stderr is not None
            for line in process.stderr:
                if found := re.search(r"page: (http://\S+)", line):
                    url = found[1]
                    break
        yield process, url
    finally:
        process.kill()
        process.communicate()


class Onlooker:
    """Listens on the board's port; notes when the board says that it is stopped."""

    def __init__(self, port: str) -> None:
        from snakebot.links import open_link

        self._link = open_link(port)
        self.stopped_at: float | None = None
        self.moving = threading.Event()  # set-points are heard: it is driven
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        from firmware_protocol.catalogue import Fault, FaultEvent, Latch, decode, frame_id

        wanted, of_a_tick = frame_id(FaultEvent), frame_id(Latch)
        while not self._done.is_set():
            for frame in self._link.receive(0.05):
                if frame.id == of_a_tick:
                    self.moving.set()
                if frame.id == wanted and self.stopped_at is None:
                    event = decode(frame)
                    if isinstance(event, FaultEvent) and event.code is Fault.EMERGENCY_STOP:
                        self.stopped_at = time.time()

    def close(self) -> None:
        self._done.set()
        self._thread.join()
        self._link.close()


def title_of(number: int) -> str:
    """What the page calls one of the runs that are stopped."""
    return f"STOP {number + 1}"


def drive(port: str, folder: Path, times: int, rate: float) -> None:
    """Runs on one board with one page, each until it is stopped; prints the page's address, then how each ended."""
    from snakebot.control import Attendant, RunLoop, RunSettings, open_board, plan_run, record
    from snakebot.errors import SnakebotError
    from snakebot.gait import Gait
    from snakebot.robot import load_robot
    from snakebot.runlog import RunWriter
    from snakebot.view.feed import Feed, ViewSettings, about_run

    robot = load_robot("penn_state")
    feed = Feed(ViewSettings(port=0), about_run(robot, "STOP", port=port), several=True)
    print(feed.url, flush=True)

    class Watched(Attendant):
        tap = staticmethod(feed.tap)

        @contextmanager
        def while_running(self, loop: RunLoop, log: RunWriter) -> Iterator[None]:
            with super().while_running(loop, log), feed.serving(loop, log.path):
                yield

    plan = plan_run(Gait.from_degrees(40, 80, 2), robot.joints, duration_s=120)
    for number in range(times):
        feed.ends.clear()  # a stop is meant for all that follows, but here
        feed.begin(about_run(robot, title_of(number), port=port))
        settings = RunSettings(rate_hz=rate, log_path=folder / f"click{number}.mcap")
        try:
            with open_board(port, robot) as board:
                record(board, robot, plan, settings, Watched(port))
        except SnakebotError as error:
            print(f"{title_of(number)}: {error}", flush=True)
    feed.close()


# The browser stamps a click when it comes in; the page's script may be called later, when the page has drawn.
NOTE_CLICKS = (
    "document.getElementById('stop').addEventListener('pointerdown', (event) => {"
    " const waited = performance.now() - event.timeStamp;"
    " window.clicked = [Date.now() - waited, waited]; }, true)"
)
MOVES = (  # the title of the run that is seen moving, "" while none is
    "document.getElementById('mode').textContent === 'armed'"
    " && parseFloat(document.getElementById('clock').textContent) > 0.2"
    " ? document.getElementById('title').textContent : ''"
)


def clicks(browser: Any, folder: Path, times: int, rate: float) -> list[tuple[float, float]]:
    """Seconds from the click on STOP to the board's report, and of these until the page's script, of as many runs."""
    found: list[tuple[float, float]] = []
    words = [sys.executable, __file__, "--drive"]
    while len(found) < times:
        part = Path(tempfile.mkdtemp(dir=folder))
        with board() as port:
            wanted = times - len(found)
            process = subprocess.Popen(
                [*words, port, str(part), str(wanted), "--rate", f"{rate:g}"],
                stdout=subprocess.PIPE,
                text=True,
            )
            assert process.stdout is not None
            onlooker = Onlooker(port)
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.goto(process.stdout.readline().strip())
            page.evaluate(NOTE_CLICKS)
            title = ""
            for number in range(wanted):
                before = title
                while (title := page.evaluate(MOVES)) in ("", before) and process.poll() is None:
                    page.wait_for_timeout(20)
                if process.poll() is not None:
                    break
                page.wait_for_timeout(300 + 13 * number % 100)  # at any moment of a tick
                onlooker.stopped_at = None
                page.locator("#stop").click()
                while not (told := process.stdout.readline()).startswith(f"{title}:") and told:
                    print(f"not by a click: {told.strip()}", file=sys.stderr)
                page.wait_for_timeout(100)
                if onlooker.stopped_at is not None and "emergency stop" in told:
                    clicked_ms, waited_ms = page.evaluate("window.clicked")
                    found.append((onlooker.stopped_at - clicked_ms / 1e3, waited_ms / 1e3))
                elif "the board's watchdog stopped the joints" in told:
                    # this machine stood still for longer than the watchdog waits: there was nothing left to stop
                    print(f"once more, the watchdog was first: {told.strip()}", file=sys.stderr)
                elif "emergency stop" in told:  # `snakebot stop` of somebody else, before the click
                    print(f"once more, somebody else was first: {told.strip()}", file=sys.stderr)
                else:
                    raise SystemExit(f"the board was not stopped: {told}")
            page.close()
            onlooker.close()
            process.wait(60)
    return found


def commands(folder: Path, times: int, rate: float) -> list[float]:
    """Seconds from the start of `snakebot stop` to the board's report."""
    found: list[float] = []
    for number in range(times):
        with board() as port, run(port, folder / f"command{number}.mcap", 60, "--rate", f"{rate:g}"):
            onlooker = Onlooker(port)
            onlooker.moving.wait(30)
            time.sleep(0.7 + 0.013 * number % 0.1)
            began = time.time()
            subprocess.run([*SNAKEBOT, "stop"], capture_output=True)
            time.sleep(0.2)
            onlooker.close()
            if onlooker.stopped_at is None:
                raise SystemExit("the board was not stopped")
            found.append(onlooker.stopped_at - began)
    return found


@contextmanager
def chromium() -> Iterator[Any]:
    """The browser that is installed here."""
    if CHROMIUM is None:
        raise SystemExit("no Chromium on this machine (Debian: apt-get install chromium)")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


def growth(browser: Any, folder: Path, minutes: float, speed: float) -> dict[str, Any]:
    """A page that stays open, at two moments: bytes of its heap, its elements, kB of its server."""
    log = folder / "played.mcap"
    wave = ["--alpha", "40", "--beta", "80", "--omega", "2", "--duration", "120", "--fast"]
    subprocess.run([*SNAKEBOT, "run", *wave, "--log", str(log)], check=True, capture_output=True)
    with served("view", str(log), "--view-port", "0") as (process, url):
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(url)
        page.wait_for_timeout(2000)
        page.locator("#speed").select_option(f"{speed:g}")
        devtools = page.context.new_cdp_session(page)
        found: list[dict[str, float]] = []
        began, first_s = time.monotonic(), max(6.0 * minutes, 60.0 / speed)
        while (passed_s := time.monotonic() - began) < 60.0 * minutes:
            page.wait_for_timeout(500)
            if page.locator("#play").inner_text() == "play":
                page.locator("#play").click()  # from the start again
            if not found and passed_s >= first_s:
                found.append(_sizes(devtools, process.pid))
        found.append(_sizes(devtools, process.pid))
        page.close()
    return {"minutes": minutes, "speed": speed, "first": found[0], "last": found[-1]}


def _sizes(devtools: Any, pid: int) -> dict[str, float]:
    """What is left once the garbage has been collected."""
    for _ in range(3):
        devtools.send("HeapProfiler.collectGarbage")
    heap = devtools.send("Runtime.getHeapUsage")["usedSize"]
    counts = devtools.send("Memory.getDOMCounters")
    status = Path(f"/proc/{pid}/status").read_text()
    resident = re.search(r"VmRSS:\s+(\d+) kB", status)
    assert resident is not None
    return {
        "heap_kb": round(heap / 1024),
        "elements": counts["nodes"],
        "listeners": counts["jsEventListeners"],
        "server_kb": int(resident[1]),
    }


def loop_figures(browser: Any, folder: Path, seconds: float, turns: int) -> dict[str, dict[str, float]]:
    """Round trip and late ticks without a page, with three, and without one again, in turns.

    What differs between the two without a page is this machine: it is the control.
    """
    from snakebot.runlog import read_log

    trips: dict[str, list[float]] = {NONE: [], THREE: [], CONTROL: []}
    late: dict[str, list[bool]] = {name: [] for name in trips}
    for turn in range(turns):
        for name in trips:
            log = folder / f"{name.replace(' ', '_')}{turn}.mcap"
            options = () if name != THREE else ("--view", "--view-port", "0")
            with board() as port, run(port, log, seconds, *options) as (process, url):
                pages = [browser.new_page() for _ in range(PAGES)] if url else []
                for page in pages:
                    page.goto(url)
                process.wait(seconds + 30)
                for page in pages:
                    page.close()
            found = read_log(log)
            settled = found.t_s > 3.0  # pages have loaded by then
            trips[name] += list(found.latency_s[settled & np.isfinite(found.latency_s)])
            late[name] += list(found.late[settled])
    return {
        name: {
            "median_ms": 1e3 * float(np.median(trips[name])),
            "p99_ms": 1e3 * float(np.percentile(trips[name], 99)),
            "late": int(np.sum(late[name])),
            "late_share": float(np.mean(late[name])),
            "ticks": len(late[name]),
        }
        for name in trips
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--stops", type=int, default=20, help="clicks, and as many `snakebot stop`")
    parser.add_argument(
        "--rate", type=float, default=100.0, help="ticks a second of the runs that are stopped"
    )
    parser.add_argument(
        "--alone", action="store_true", help="without `snakebot stop`, which stops every run on this computer"
    )
    parser.add_argument("--minutes", type=float, default=0.0, help="how long a page stays open; 0: left out")
    parser.add_argument("--speed", type=float, default=1.0, choices=(1.0, 2.0, 5.0, 10.0))
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--drive", nargs=3, metavar=("PORT", "FOLDER", "TIMES"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.drive:
        port, folder, times = options.drive
        drive(port, Path(folder), int(times), options.rate)
        return
    result: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as name, chromium() as browser:
        if options.stops:
            clicked = clicks(browser, Path(name), options.stops, options.rate)
            page, script = [both for both, _ in clicked], [waited for _, waited in clicked]
            command = [] if options.alone else commands(Path(name), options.stops, options.rate)
            parts = (
                ("STOP in the page", page),
                ("until the script", script),
                ("snakebot stop", command),
            )
            for label, values in parts:
                if not values:
                    continue
                result[label] = {
                    "times": len(values),
                    "median_ms": round(1e3 * statistics.median(values), 1),
                    "p99_ms": round(1e3 * float(np.percentile(values, 99)), 1),
                    "worst_ms": round(1e3 * max(values), 1),
                }
        if options.minutes:
            result["open"] = growth(browser, Path(name), options.minutes, options.speed)
    if options.json:
        print(json.dumps(result))
        return
    for label, row in result.items():
        if label != "open":
            figures = "  ".join(f"{name} {row[name + '_ms']:6.1f}" for name in ("median", "p99", "worst"))
            print(f"{label:18} {row['times']:4} times: {figures} ms")
            continue
        for name in ("first", "last"):
            print(f"open {name:6}", "  ".join(f"{what} {value:g}" for what, value in row[name].items()))


if __name__ == "__main__":
    main()
