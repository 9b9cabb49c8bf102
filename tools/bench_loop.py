#!/usr/bin/env python3
"""Round trip, lateness and late ticks of the run loop, beside a bare echo and a plain C loop in the same run.

For each link (pty, udp_multicast, slcan) and rate, three things take turns in short slices:

  snakebot   the run loop against `snakebot board sim` in its own process
  echo       a loop that writes the same request bytes (or CAN frames) on absolute deadlines and waits for an answer of
             the same size from a process that does nothing but answer: no codec, no board, no physics
  C          a plain C loop on clock_nanosleep deadlines over a pty echo (pty only): what the machine itself can do

All of them ask for SCHED_FIFO, which they get as root or with `ulimit -r`.

With --view, in their place: runs on a simulated board in a process of its own (TCP) with no page, with a live page that
three tabs of Chromium show, and with no page again, in turns. The two without a page are the control: what they differ
by is the machine. Aim: p99 of the round trip and late ticks at most 1.1 times those without.

A tick is late when it starts more than half an interval after its deadline. Aim: median and p99 of snakebot within
twice the echo's; late ticks no more than the C loop's plus one in ten thousand.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from loop_peers import JOINTS, MULTICAST, Figures, build_c, c_loop, echo_loop, serve_echo

ROOT = Path(__file__).resolve().parent.parent


@contextlib.contextmanager
def child(arguments: list[str]) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A process that prints one line when it is ready."""
    process = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True, cwd=ROOT)
    try:
        assert process.stdout is not None
        yield process, process.stdout.readline().strip()
    finally:
        process.terminate()
        process.wait(10)


class Collector:
    """A recorder that keeps lateness and round trip only."""

    def __init__(self, interval: float) -> None:
        self.interval = interval
        self.figures = Figures()

    def tick(self, tick: Any) -> None:
        self.figures.lateness.append(tick.t_s % self.interval)
        if tick.latency_s is None:
            self.figures.lost += 1
        else:
            self.figures.trips.append(tick.latency_s)

    def ignore(self, *_: Any) -> None:
        pass

    pose = event = link_statistics = telemetry = steering = frame = ignore


def snakebot_loop(port: str, rate: float, seconds: float) -> Figures:
    from snakebot.board import Board
    from snakebot.clock import MonotonicClock
    from snakebot.control import RunLoop
    from snakebot.gait import Gait, GaitMotion
    from snakebot.links import open_link
    from snakebot.robot import load_robot

    robot, clock = load_robot("penn_state"), MonotonicClock()
    gait = Gait.from_degrees(30, 80, 2)
    with open_link(port) as link:
        board = Board(link, clock)
        board.connect()
        collector = Collector(1 / rate)
        loop = RunLoop(
            board,
            robot,
            lambda start: GaitMotion(gait, JOINTS, seconds, 0.5, start),
            rate_hz=rate,
            clock=clock,
            amplitude_rad=gait.alpha_rad,
            recorder=collector,
        )
        loop.run()
    return collector.figures


BOARD = {
    "pty": ["--serial"],
    "udp_multicast": ["--can", f"udp_multicast/{MULTICAST}"],
    "slcan": ["--can", "slcan"],
}


def measure(
    kind: str, rate: float, seconds: float, slices: int, program: Path | None
) -> list[dict[str, Any]]:
    """Rows of one link and rate: the three peers, in turn."""
    figures = {"snakebot": Figures(), "echo": Figures()}
    if kind == "pty" and program is not None:
        figures["C"] = Figures()
    board = [sys.executable, "-m", "snakebot.cli.main", "board", "sim", *BOARD[kind], "--json"]
    echo = [sys.executable, str(Path(__file__).resolve()), "--echo", kind]
    for _ in range(slices):
        share = seconds / slices
        with child(board) as (_, line):
            merge(figures["snakebot"], snakebot_loop(json.loads(line)["port"], rate, max(share, 1.5)))
        with child(echo) as (_, where):
            merge(figures["echo"], echo_loop(kind, where, rate, share))
            if "C" in figures:
                assert program is not None
                merge(figures["C"], c_loop(program, where, rate, share))
    rows = []
    for name, figure in figures.items():
        rows.append({"link": kind, "rate_hz": rate, "peer": name, **figure.row(1 / rate)})
    ours, bare = rows[0]["trip_us"], rows[1]["trip_us"]
    rows[0]["ratio_to_echo"] = [round(a / b, 2) for a, b in zip(ours, bare, strict=True)]
    return rows


def merge(into: Figures, more: Figures) -> None:
    into.lateness += more.lateness
    into.trips += more.trips
    into.lost += more.lost


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--links", nargs="+", default=list(BOARD), choices=list(BOARD))
    parser.add_argument("--rates", nargs="+", type=float, default=[100, 200, 500])
    parser.add_argument("--seconds", type=float, default=20.0, help="for each peer, link and rate")
    parser.add_argument("--slices", type=int, default=4, help="turns that each peer takes")
    parser.add_argument("--view", action="store_true", help="what open pages cost the loop, at 100 Hz")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--echo", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.echo:
        serve_echo(options.echo)
        return
    if options.view:
        beside_pages(options.seconds, options.slices, as_json=options.json)
        return
    with tempfile.TemporaryDirectory() as folder:
        program = build_c(Path(folder))
        if program is None:
            print("no C compiler here: the C loop is left out", file=sys.stderr)
        rows = []
        for kind in options.links:
            for rate in options.rates:
                rows += measure(kind, rate, options.seconds, options.slices, program)
                if not options.json:
                    for row in rows[-3 if kind == "pty" and program else -2 :]:
                        show(row)
    if options.json:
        print(json.dumps(rows))


def beside_pages(seconds: float, slices: int, *, as_json: bool) -> None:
    """Runs without a page, with three, and without again, in turns."""
    from bench_view import CONTROL, NONE, THREE, chromium, loop_figures

    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        found = loop_figures(browser, Path(folder), seconds, slices)
    if as_json:
        print(json.dumps(found))
        return
    for name, figures in found.items():
        trips = f"round trip median {figures['median_ms']:.3f}  p99 {figures['p99_ms']:.3f} ms"
        late = f"late {figures['late']:g} ({1e4 * figures['late_share']:.2f} in 10000)"
        print(f"{name:10} {figures['ticks']:6} ticks: {trips}  {late}")
    for name, other in ((THREE, NONE), (CONTROL, NONE), (THREE, CONTROL)):
        print(f"{name} / {other}: round trip p99 {found[name]['p99_ms'] / found[other]['p99_ms']:.2f}")


def show(row: dict[str, Any]) -> None:
    trip, late = row["trip_us"], row["lateness_us"]
    ratio = row.get("ratio_to_echo")
    print(
        f"{row['link']:14s}{row['rate_hz']:4.0f} Hz  {row['peer']:9s} {row['ticks']:6d} ticks  round trip us "
        f"{trip[0]:6d} / {trip[1]:6d} / {trip[2]:6d}  lateness us {late[0]:5d} / {late[1]:6d} / {late[2]:6d}  "
        f"late {row['late']:3d} ({row['late_per_10000']:g} in 10000)  lost {row['lost']}"
        + (f"  ratio to echo {ratio[0]:.2f} / {ratio[1]:.2f} / {ratio[2]:.2f}" if ratio else ""),
        flush=True,
    )


if __name__ == "__main__":
    main()
