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
import os
import select
import shutil
import subprocess
import sys
import tempfile
import tty
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
JOINTS = 5
MULTICAST = "239.74.163.2"

C_SOURCE = r"""
#define _GNU_SOURCE
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }
int main(int argc, char **argv) {
    if (argc < 6) return 2;
    int fd = atoi(argv[1]); double interval = 1 / atof(argv[2]); int ticks = atoi(argv[3]);
    size_t out = (size_t)atoi(argv[4]), in = (size_t)atoi(argv[5]);
    char buffer[4096]; memset(buffer, 1, sizeof buffer);
    prctl(PR_SET_TIMERSLACK, 1);
    struct sched_param priority = {10};
    sched_setscheduler(0, SCHED_FIFO, &priority); /* as the run loop does; nothing without the permission */
    double origin = now() + 0.01;
    for (int k = 0; k < ticks; k++) {
        double deadline = origin + k * interval;
        struct timespec at = {(time_t)deadline, (long)((deadline - (time_t)deadline) * 1e9)};
        while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, NULL)) {}
        double start = now(); size_t got = 0;
        if (write(fd, buffer, out) < 0) return 1;
        while (got < in) {
            struct pollfd p = {fd, POLLIN, 0};
            if (poll(&p, 1, 1000) <= 0) return 1;
            ssize_t n = read(fd, buffer + 1024, sizeof buffer - 1024);
            if (n <= 0) return 1;
            got += (size_t)n;
        }
        printf("%.9f %.9f\n", start - deadline, now() - start);
        int behind = (int)((now() - deadline) / interval);
        if (behind > 0) k += behind - 1 < 0 ? 0 : behind - 1;
    }
    return 0;
}
"""


@dataclass
class Figures:
    """Lateness and round trip of every tick, in s."""

    lateness: list[float] = field(default_factory=list)
    trips: list[float] = field(default_factory=list)
    lost: int = 0

    def row(self, interval: float) -> dict[str, Any]:
        import numpy as np

        trips, lateness = np.array(self.trips) * 1e6, np.array(self.lateness)
        late = int((lateness > 0.5 * interval).sum())
        return {
            "ticks": len(lateness),
            "trip_us": [round(float(v)) for v in (*np.percentile(trips, [50, 99]), trips.max())],
            "lateness_us": [
                round(float(v) * 1e6) for v in (*np.percentile(lateness, [50, 99]), lateness.max())
            ],
            "late": late,
            "late_per_10000": round(1e4 * late / max(len(lateness), 1), 2),
            "lost": self.lost,
        }


def request_and_answer() -> tuple[list[Any], list[Any]]:
    """The frames of one tick out, and of the simulated board's answer (state, measured, applied, pose)."""
    from firmware_protocol.assembly import sample_messages, setpoint_messages
    from firmware_protocol.catalogue import Mode, PoseMotion, PosePosition, State, encode

    out = [encode(m) for m in setpoint_messages(1, [0.1] * JOINTS, 0.01)]
    messages = [
        *sample_messages(State(1, 1, Mode.ARMED, 1), [1] * JOINTS, [0.1] * JOINTS),
        PosePosition(1, 0.1, 0.1),
        PoseMotion(1, 0.1, 0.1),
    ]
    return out, [encode(m) for m in messages]


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


# -- the bare echo ---------------------------------------------------------------------------------------------------


def serve_echo(kind: str) -> None:
    """The process that only answers, as urgently as the board does."""
    from snakebot.clock import urgent

    with urgent():
        _answer(kind)


def _answer(kind: str) -> None:
    from firmware_protocol.framing import pack_all

    request, answer = request_and_answer()
    if kind == "pty":
        master, slave = os.openpty()
        tty.setraw(slave)
        print(os.ttyname(slave), flush=True)
        size, reply, got = len(pack_all(request)), pack_all(answer), 0
        while True:
            got += len(os.read(master, 4096))
            if got >= size:
                got -= size
                os.write(master, reply)
    import can

    if kind == "slcan":
        master, slave = os.openpty()
        tty.setraw(slave)
        print(os.ttyname(slave), flush=True)
        lines = b"".join(b"t%03X%d%s\r" % (f.id, len(f.data), f.data.hex().upper().encode()) for f in answer)
        count = 0
        while True:
            data = os.read(master, 4096)
            count += data.count(b"t")
            if count >= len(request):
                count -= len(request)
                os.write(master, lines)
    ours = {frame.id for frame in answer}
    with can.Bus(interface="udp_multicast", channel=MULTICAST) as bus:
        print("ready", flush=True)
        count = 0
        while True:
            message = bus.recv(1.0)
            if message is None or message.arbitration_id in ours:
                continue
            count += 1
            if count == len(request):
                count = 0
                for frame in answer:
                    bus.send(can.Message(arbitration_id=frame.id, data=frame.data, is_extended_id=False))


def echo_loop(kind: str, where: str, rate: float, seconds: float) -> Figures:
    """The host's side of the bare echo."""
    from firmware_protocol.framing import pack_all
    from snakebot.clock import MonotonicClock, urgent

    request, answer = request_and_answer()
    exchange: Callable[[], bool]
    with contextlib.ExitStack() as stack:
        stack.enter_context(urgent())
        if kind == "pty":
            fd = os.open(where, os.O_RDWR | os.O_NOCTTY)
            stack.callback(os.close, fd)
            out, size = pack_all(request), len(pack_all(answer))

            def exchange() -> bool:
                os.write(fd, out)
                got = 0
                while got < size:
                    if not select.select([fd], [], [], 0.1)[0]:
                        return False
                    got += len(os.read(fd, 4096))
                return True
        else:
            import can

            if kind == "slcan":
                bus: Any = can.Bus(interface="slcan", channel=where, bitrate=1_000_000, sleep_after_open=0)
            else:
                bus = can.Bus(interface="udp_multicast", channel=MULTICAST)
            stack.callback(bus.shutdown)
            messages = [can.Message(arbitration_id=f.id, data=f.data, is_extended_id=False) for f in request]
            ours = {frame.id for frame in request}

            def exchange() -> bool:
                for message in messages:
                    bus.send(message)
                got = 0
                while got < len(answer):
                    message = bus.recv(0.1)
                    if message is None:
                        return False
                    got += message.arbitration_id not in ours
                return True

        clock, figures = MonotonicClock(), Figures()
        origin, k = clock.now_s() + 0.05, 0
        while k < seconds * rate:
            deadline = origin + k / rate
            clock.sleep_until(deadline)
            start = clock.now_s()
            figures.lateness.append(start - deadline)
            if exchange():
                figures.trips.append(clock.now_s() - start)
            else:
                figures.lost += 1
            k = max(k + 1, int((clock.now_s() - origin) * rate))
    return figures


# -- snakebot --------------------------------------------------------------------------------------------------------


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


# -- the C loop ------------------------------------------------------------------------------------------------------


def build_c(folder: Path) -> Path | None:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return None
    source, program = folder / "control.c", folder / "control"
    source.write_text(C_SOURCE)
    subprocess.run([compiler, "-O2", "-o", program, source], check=True)
    return program


def c_loop(program: Path, where: str, rate: float, seconds: float) -> Figures:
    from firmware_protocol.framing import pack_all

    request, answer = request_and_answer()
    fd = os.open(where, os.O_RDWR | os.O_NOCTTY)
    try:
        result = subprocess.run(
            [
                program,
                str(fd),
                str(rate),
                str(int(seconds * rate)),
                str(len(pack_all(request))),
                str(len(pack_all(answer))),
            ],
            stdout=subprocess.PIPE,
            text=True,
            pass_fds=[fd],
            check=True,
        )
    finally:
        os.close(fd)
    figures = Figures()
    for line in result.stdout.splitlines():
        lateness, trip = map(float, line.split())
        figures.lateness.append(lateness)
        figures.trips.append(trip)
    return figures


# -- all together ----------------------------------------------------------------------------------------------------

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
