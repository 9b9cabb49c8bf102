#!/usr/bin/env python3
"""Run for a long time and start again and again, and look for growth: memory, open files, threads, error counters.

    tools/soak.py stream --hours 1          an hour of streaming and logging in virtual time
    tools/soak.py starts --times 10000      starts and stops on one board in virtual time
    tools/soak.py real --minutes 10         `snakebot run` in a terminal on `snakebot board sim`, in real time:
                                            both processes are watched from outside (--wire serial, tcp or slcan)
    tools/soak.py restarts --times 300      the same board, and runs of the command line one after the other

Every command prints a line at the start, one for each part of the time, and the growth between the second line (what
is made once has been made by then) and the last. Status 1 if memory has grown by more than 4 MB, or if there are more
files, threads or errors than there were.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import io
import os
import pty
import re
import select
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "wire"))

import numpy as np  # noqa: E402
from wire_bench import PENN_STATE, Bench, WireLink  # noqa: E402

from snakebot.board import Board  # noqa: E402
from snakebot.control import RunLoop  # noqa: E402
from snakebot.gait import Gait, GaitMotion  # noqa: E402
from snakebot.runlog import RunWriter, read_log  # noqa: E402

GROWN_KB = 4096
SNAKEBOT = [sys.executable, "-m", "snakebot.cli.main"]
WIRES = {"serial": ["--serial"], "tcp": ["--tcp", "0"], "slcan": ["--can", "slcan"]}
SMALL = Gait.from_degrees(5, 60, 2)  # within all limits after a ramp of 0.1 s
SMALL_S, SMALL_RAMP_S = 0.4, 0.1
WATCHDOG_MS = 250  # of a board in its own process: for a computer that stands still now and then
STOOD_STILL = re.compile(r"this computer stood still|no set-point reached it for")


@dataclass
class Watch:
    """Looks at a process from outside, or at this one."""

    name: str
    pid: int | None = None
    seen: list[tuple[int, int, int]] = field(default_factory=list)  # resident kB, open files, threads

    def look(self, at: str, more: str = "") -> None:
        if self.pid is None:
            gc.collect()
        process = Path(f"/proc/{self.pid or 'self'}")
        status = dict(
            line.split(":", 1) for line in (process / "status").read_text(encoding="ascii").splitlines()
        )
        now = int(status["VmRSS"].split()[0]), len(os.listdir(process / "fd")), int(status["Threads"])
        self.seen.append(now)
        print(
            f"{self.name:6} {at:22} {now[0]:8} kB {now[1]:4} files {now[2]:3} threads{'; ' if more else ''}{more}",
            flush=True,
        )

    def grown(self) -> bool:
        first, last = self.seen[min(1, len(self.seen) - 1)], self.seen[-1]
        memory, files, threads = (b - a for a, b in zip(first, last, strict=True))
        print(f"{self.name:6} growth: {memory} kB, {files} files, {threads} threads")
        return memory > GROWN_KB or files > 0 or threads > 0


class Last(list[Any]):
    """Keeps the last command only: the tool must not be what grows."""

    def append(self, item: Any) -> None:
        self[:] = [item]


def stream(hours: float, parts: int) -> bool:
    """One long run in virtual time, logged."""
    seconds = 3600 * hours
    watch = Watch("all")
    with tempfile.TemporaryDirectory() as folder:
        writer = RunWriter(Path(folder) / "soak.mcap", PENN_STATE)
        bench = Bench(duration_s=seconds, recorder=writer)
        bench.joints.commands = Last()
        progress = bench.loop.progress

        def errors() -> int:
            return progress.lost + progress.late + bench.link.statistics.corrupt + bench.board.unreadable

        def look() -> None:
            if len(watch.seen) < parts and progress.t_s >= seconds * len(watch.seen) / parts:
                watch.look(f"{progress.t_s:.0f} s streamed", f"{progress.ticks} ticks, {errors()} errors")

        bench.link.before = look
        bench.run()
        watch.look(f"{progress.t_s:.0f} s streamed", f"{progress.ticks} ticks, {errors()} errors")
        writer.close()
    return watch.grown() or errors() > 0


def starts(times: int, parts: int) -> bool:
    """From opening the link to disarming, each time with a new host on the same board."""
    watch = Watch("all")
    bench = Bench()
    bench.joints.commands, bench.joints.power_changes = Last(), Last()
    lost = 0
    for count in range(times):
        if count >= times * len(watch.seen) / parts:
            watch.look(f"{count} starts and stops", f"{lost} errors")
        link = WireLink(bench.sim, bench.clock)
        board = Board(link, bench.clock)
        board.connect()
        loop = RunLoop(
            board,
            PENN_STATE,
            lambda start: GaitMotion(SMALL, PENN_STATE.joints, SMALL_S, SMALL_RAMP_S, start),
            rate_hz=100,
            clock=bench.clock,
            amplitude_rad=SMALL.alpha_rad,
        )
        assert loop.run().ended == "finished"
        lost += loop.progress.lost + loop.progress.late + link.statistics.corrupt + board.unreadable
        link.close()
    watch.look(f"{times} starts and stops", f"{lost} errors")
    return watch.grown() or lost > 0


@contextlib.contextmanager
def served(wire: str) -> Iterator[tuple[int, str]]:
    """A simulated board in a process of its own: its process id and its port."""
    board = subprocess.Popen(
        [*SNAKEBOT, "board", "sim", "--watchdog-ms", f"{WATCHDOG_MS}", *WIRES[wire]],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        cwd=ROOT,
    )
    assert board.stdout is not None
    try:
        yield board.pid, board.stdout.readline().strip().removeprefix("--port ")
    finally:
        board.terminate()
        board.wait()


def real(minutes: float, parts: int, wire: str) -> bool:
    """One run of the command line in a terminal (panel, keys, log), and its board."""
    seconds = 60 * minutes
    with tempfile.TemporaryDirectory() as folder, served(wire) as (board_pid, port):
        log = Path(folder) / "soak.mcap"
        gait = ["--alpha", "66", "--beta", "80", "--omega", "2", "--duration", f"{seconds:g}"]
        terminal, slave = pty.openpty()
        host = subprocess.Popen(
            [*SNAKEBOT, "run", "--port", port, *gait, "--log", str(log)],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            cwd=ROOT,
            env={**os.environ, "TERM": "xterm-256color"},
        )
        os.close(slave)
        watches = [Watch("host", host.pid), Watch("board", board_pid)]
        while not log.with_name(log.name + ".part").exists():
            time.sleep(0.1)
        begin_s = time.monotonic()
        said = b""
        while host.poll() is None:
            if select.select([terminal], [], [], 0.2)[0]:
                with contextlib.suppress(OSError):
                    said = (said + os.read(terminal, 65536))[-2000:]
            passed_s = time.monotonic() - begin_s
            if 2 + (seconds - 4) * len(watches[0].seen) / parts <= passed_s < seconds - 1:
                for watch in watches:
                    watch.look(f"{passed_s:.0f} s streamed")
        os.close(terminal)
        if host.returncode:
            print(said.decode(errors="replace"))
        bad = [watch.grown() for watch in watches]
        (written,) = log.parent.glob("soak.mcap*")  # unfinished where the run was cut off
        return errors_of(written) or any(bad) or host.returncode != 0


def errors_of(path: Path) -> bool:
    """The counters of a log: in all, and in each half of the run. True if anything was corrupt."""
    log = read_log(path)
    half = len(log.link_t_s) // 2
    for name in ("late", "skipped", "lost", "corrupt", "unreadable", "board_corrupt", "board_dropped"):
        counts = log.link[name]
        middle, end = counts[half], counts[-1]
        print(f"{name:14} {middle:6g} in the first half, {end - middle:6g} in the second")
    longest_s, answer_s = np.diff(log.t_s).max(), np.nanmax(log.latency_s)
    print(
        f"longest time between two set-points {1e3 * longest_s:.1f} ms, until an answer {1e3 * answer_s:.1f} ms"
    )
    print(f"{log.link['ticks'][-1]:g} ticks, log of {path.stat().st_size} bytes")
    return bool(any(log.link[name][-1] > 0 for name in ("corrupt", "unreadable", "board_corrupt")))


def restarts(times: int, parts: int, wire: str) -> bool:
    """``snakebot run`` again and again in this process, with its log, on one board in another.

    One that this computer was too late for is told, and made again: a quarter of ``times`` at most.
    """
    from snakebot.cli.main import main as snakebot

    with tempfile.TemporaryDirectory() as folder, served(wire) as (board_pid, port):
        watches = [Watch("host"), Watch("board", board_pid)]
        ended: dict[object, int] = {}
        gait = ["--alpha", "5", "--beta", "60", "--omega", "2"]
        gait += ["--duration", f"{SMALL_S}", "--ramp", f"{SMALL_RAMP_S}"]
        count = again = 0
        while True:
            if count >= times * len(watches[0].seen) / parts:
                for watch in watches:
                    watch.look(f"{count} starts and stops", f"status {ended}" if watch.pid is None else "")
            if count == times:
                break
            log = Path(folder) / "soak.mcap"
            status: Any = None
            said = io.StringIO()
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
                try:
                    snakebot(["run", "--port", port, *gait, "--log", str(log)])
                except SystemExit as end:
                    status = end.code
            if status in (5, 7) and STOOD_STILL.search(said.getvalue()) and again < times // 4:
                again += 1
                print(f"made again: status {status}: {said.getvalue().strip()}")
            else:
                count += 1
                ended[status] = ended.get(status, 0) + 1
                if status:
                    print(said.getvalue(), file=sys.stderr)
            for left in Path(folder).glob("soak.mcap*"):
                left.unlink()
        threads = [thread.name for thread in threading.enumerate()]
        print(f"status {ended}, {again} made again; threads here: {', '.join(threads)}")
        bad = [watch.grown() for watch in watches]
        return any(bad) or set(ended) != {0}


def main() -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    work: dict[str, Callable[[argparse.Namespace], bool]] = {
        "stream": lambda o: stream(o.hours, o.parts),
        "starts": lambda o: starts(o.times, o.parts),
        "real": lambda o: real(o.minutes, o.parts, o.wire),
        "restarts": lambda o: restarts(o.times, o.parts, o.wire),
    }
    for name in work:
        command = commands.add_parser(name)
        command.add_argument("--parts", type=int, default=6, help="how often to look")
        if name == "stream":
            command.add_argument("--hours", type=float, default=1.0)
        elif name == "real":
            command.add_argument("--minutes", type=float, default=10.0)
        else:
            command.add_argument("--times", type=int, default=10_000 if name == "starts" else 300)
        if name in ("real", "restarts"):
            command.add_argument("--wire", choices=WIRES, default="serial")
    options = parser.parse_args()
    grown = work[options.command](options)
    print("something has grown" if grown else "nothing has grown")
    return 1 if grown else 0


if __name__ == "__main__":
    sys.exit(main())
