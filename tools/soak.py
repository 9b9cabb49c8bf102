#!/usr/bin/env python3
"""Stream for a long time and look for growth: memory, file handles, threads, error counters.

    tools/soak.py                               an hour of streaming in virtual time
    tools/soak.py --hours 0.1                   less
    tools/soak.py --starts 10000                only starts and stops of a run
    tools/soak.py --port serial:/dev/ttyUSB0 --hours 0.1667     ten minutes on a real link, in real time

Status 1 if something has grown.
"""

from __future__ import annotations

import argparse
import gc
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "wire"))

from wire_bench import GAIT, PENN_STATE, Bench  # noqa: E402

from snakebot.board import Board  # noqa: E402
from snakebot.clock import MonotonicClock  # noqa: E402
from snakebot.control import RunLoop  # noqa: E402
from snakebot.errors import SnakebotError  # noqa: E402
from snakebot.gait import GaitMotion  # noqa: E402

GROWN_KB = 4096  # of resident memory between the first and the last part


class Nothing:
    """A recorder that keeps nothing: what grows then is a fault of the loop."""

    def __getattr__(self, name: str) -> Any:
        return lambda *_: None


def footprint() -> tuple[int, int, int]:
    """Resident kB, open file descriptors, threads."""
    gc.collect()
    status = Path("/proc/self/status").read_text(encoding="ascii")
    (line,) = (line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]), len(os.listdir("/proc/self/fd")), threading.active_count()


def show(what: str, loop: RunLoop | None = None) -> tuple[int, int, int]:
    now = footprint()
    text = f"{what:24} {now[0]:8} kB {now[1]:4} files {now[2]:3} threads"
    if loop is not None:
        progress, statistics = loop.progress, loop.board.link.statistics
        text += (
            f"; {progress.ticks} ticks, {progress.lost} lost, {progress.late} late, {statistics.corrupt} corrupt, "
            f"{loop.board.unreadable} unreadable"
        )
    print(text, flush=True)
    return now


def grown(first: tuple[int, int, int], last: tuple[int, int, int]) -> bool:
    memory, files, threads = (b - a for a, b in zip(first, last, strict=True))
    print(f"growth: {memory} kB, {files} files, {threads} threads")
    return memory > GROWN_KB or files > 0 or threads > 0


def stream(hours: float, parts: int) -> bool:
    """One long run in virtual time, looked at in equal parts."""
    seconds = 3600 * hours
    bench = Bench(duration_s=seconds, recorder=Nothing())
    bench.joints.commands = _Last()
    seen: list[tuple[int, int, int]] = []

    def look() -> None:
        if bench.loop.progress.t_s >= seconds * (len(seen) + 1) / (parts + 1):
            seen.append(show(f"{bench.loop.progress.t_s:8.0f} s streamed", bench.loop))

    bench.link.before = look
    bench.run()
    progress = bench.loop.progress
    errors = progress.lost + progress.late + bench.link.statistics.corrupt + bench.board.unreadable
    return grown(seen[1], seen[-1]) or errors > 0


class _Last(list):  # type: ignore[type-arg]
    """Keeps the last command only: the tool must not be what grows."""

    def append(self, item: Any) -> None:
        self[:] = [item]


def starts(times: int) -> bool:
    """A run from connecting to disarming, again and again."""
    first = None
    for count in range(times):
        Bench(None, count, duration_s=1.2, ramp_s=0.5).run()
        if count == times // 5:
            first = show(f"{count} starts and stops")
    assert first is not None
    return grown(first, show(f"{times} starts and stops"))


def real(port: str, hours: float) -> bool:
    """A run on a real link."""
    from snakebot.links.opening import open_link

    clock = MonotonicClock()
    link = open_link(port)
    board = Board(link, clock)
    board.connect()
    loop = RunLoop(
        board,
        PENN_STATE,
        lambda start: GaitMotion(GAIT, PENN_STATE.joints, 3600 * hours, 1, start),
        rate_hz=100,
        clock=clock,
        amplitude_rad=GAIT.alpha_rad,
        recorder=Nothing(),
    )
    seen: list[tuple[int, int, int]] = []
    done = threading.Event()

    def watch() -> None:
        while not done.wait(max(2.0, 360 * hours)):
            seen.append(show(f"{time.monotonic():.0f} s", loop))

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        loop.run()
    finally:
        done.set()
        watcher.join()
        link.close()
    return len(seen) > 2 and grown(seen[1], seen[-1])


def main() -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--parts", type=int, default=8, help="how often to look")
    parser.add_argument("--starts", type=int, help="starts and stops instead of streaming")
    parser.add_argument("--port", help="a real board instead of virtual time")
    options = parser.parse_args()
    try:
        if options.starts:
            bad = starts(options.starts)
        elif options.port:
            bad = real(options.port, options.hours)
        else:
            bad = stream(options.hours, options.parts)
    except SnakebotError as error:
        print(f"soak: {error}", file=sys.stderr)
        return error.exit_status
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
