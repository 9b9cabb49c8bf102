#!/usr/bin/env python3
"""All benches of tools/ with their peers, one after the other, as one table with machine, load and ratios.

    tools/bench_all.py                      everything; about half an hour
    tools/bench_all.py --markdown           the same as a table for a page
    tools/bench_all.py --quick              the same benches with little of each: minutes, and rough figures
    tools/bench_all.py --only codec bus     these; --list says which there are

"ratio": how many times better than the peer of the same run (faster, or sooner where the figure is a time); below 1 the
peer is better. "load": of the machine when that bench began. A bench whose tool is missing here is named with what it
said.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

TOOLS = Path(__file__).resolve().parent
FIGURES = "FIGURES"  # in the words of a bench: a file that it writes


@dataclass(frozen=True)
class Row:
    """A figure beside its peer's, both in ``unit``; ``more`` is better or less is. No peer: NaN is not made up."""

    what: str
    peer: str
    ours: float
    theirs: float | None
    unit: str
    more: bool = True

    @property
    def ratio(self) -> float | None:
        if self.theirs is None:
            return None
        return self.ours / self.theirs if self.more else self.theirs / self.ours


@dataclass(frozen=True)
class Bench:
    """``words``: of its command line; ``quick``: in their place with --quick. ``read``: its output as rows."""

    words: tuple[str, ...]
    quick: tuple[str, ...]
    read: Callable[[str], list[Row]]
    limit_s: float = 1200.0


def codec(text: str) -> list[Row]:
    found: dict[str, dict[str, float]] = json.loads(text)
    return [
        Row(name, way, rates["snakebot"], rate, "frames/s")
        for name, rates in found.items()
        for way, rate in rates.items()
        if way != "snakebot"
    ]


def effects(text: str) -> list[Row]:
    f: dict[str, Any] = json.loads(text)
    return [
        Row("nominal servos, a session", "scipy lfilter", f["nominal_ms"], f["lfilter_ms"], "ms", more=False),
        Row(
            "lag and rate limit, a run", "scipy solve_ivp", f["rate_limit_one_run_ms"], f["solve_ivp_one_run_ms"],
            "ms", more=False,
        ),
        Row("plant with body, online", "", f["plant_simulated_s_per_s"], None, "s/s"),
    ]  # fmt: skip


def physics(text: str) -> list[Row]:
    f: dict[str, Any] = json.loads(text)
    rows = []
    for robot, peers in f["peers"].items():
        ours = f["grid"][robot]["gaits_per_core_s"]
        theirs = peers["mujoco"]["gaits_per_core_s"], 1 / peers["scipy"]["cpu_s_per_gait"]
        for peer, rate in zip(("MuJoCo", "scipy"), theirs, strict=True):
            rows.append(Row(f"gaits of {robot}, a core", peer, ours, rate, "gaits/s"))
    return rows


def diagnosis(text: str) -> list[Row]:
    f: dict[str, Any] = json.loads(text)
    return [
        Row(
            f"a session, verdict {f['verdict']}", "one fit of the right effect", f["seconds"], f["peer_one_fit_s"],
            "s", more=False,
        )
    ]  # fmt: skip


def growth(text: str) -> list[Row]:
    """Time beside what it would be in proportion to the first case; memory beside the first's."""
    first, *others = json.loads(text)
    name = "{joints} joints, {runs} runs of {duration_s:.0f} s"
    rows = [
        Row(name.format(**first), "", first["seconds"], None, "s", more=False),
        Row(name.format(**first), "", first["memory_mib"], None, "MiB", more=False),
    ]
    for case in others:
        what = name.format(**case)
        rows += [
            Row(what, "in proportion", case["seconds"], case["in_proportion_s"], "s", more=False),
            Row(what, "the first case", case["memory_mib"], first["memory_mib"], "MiB", more=False),
        ]
    return rows


def loop(text: str) -> list[Row]:
    rows: list[dict[str, Any]] = json.loads(text)
    found = []
    for row in rows:
        if row.get("ratio_to_echo"):
            ours = row["trip_us"][0]
            where = f"{row['link']} {row['rate_hz']:.0f} Hz, round trip"
            found.append(Row(where, "echo", ours, ours / row["ratio_to_echo"][0], "us", more=False))
    return found


def bus(text: str) -> list[Row]:
    lines = re.findall(r"^(\S+ +\d+ joints) +(\S.*?) +(\d+) cycles/s", text, flags=re.MULTILINE)
    ours = {where: float(rate) for where, driver, rate in lines if driver == "snakebot"}
    return [
        Row(where, driver, ours[where], float(rate), "cycles/s")
        for where, driver, rate in lines
        if driver != "snakebot" and where in ours
    ]


def cluster(text: str) -> list[Row]:
    """Two workers of a cluster beside the plain run of the same work."""
    return [
        Row(work, "plain run", list(taken.values())[-1], next(iter(taken.values())), "s", more=False)
        for work, taken in json.loads(text).items()
    ]


def runlog(text: str) -> list[Row]:
    reading = dict(
        re.findall(r"^(snakebot\.\S+read_log|mcap make_reader \+ \w+) +([\d.]+) ", text, flags=re.MULTILINE)
    )
    writing = dict(
        re.findall(r"^(snakebot\.\S+tick|mcap Writer\S+ \+ json) +([\d.]+) ", text, flags=re.MULTILINE)
    )
    rows = []
    for what, found, unit in (("reading a log", reading, "s"), ("writing a tick", writing, "us")):
        ours = next(float(v) for name, v in found.items() if name.startswith("snakebot"))
        rows += [
            Row(what, name, ours, float(v), unit, more=False)
            for name, v in found.items()
            if not name.startswith("snakebot")
        ]
    return rows


def view(text: str) -> list[Row]:
    f: dict[str, Any] = json.loads(text)
    page, command = f["STOP in the page"], f.get("snakebot stop")
    theirs = None if command is None else command["median_ms"]
    return [Row("STOP in the page, median", "snakebot stop", page["median_ms"], theirs, "ms", more=False)]


BENCHES = {
    "codec": Bench(
        ("bench_codec.py", "--json"), ("bench_codec.py", "--json", "--rounds", "3", "--round-s", "0.02"), codec
    ),
    "effects": Bench(("bench_effects.py", "--json"), ("bench_effects.py", "--json"), effects),
    "physics": Bench(
        ("bench_physics.py", "--json", FIGURES), ("bench_physics.py", "--quick", "--json", FIGURES), physics
    ),
    "runlog": Bench(("bench_runlog.py",), ("bench_runlog.py", "--seconds", "10", "--repeat", "2"), runlog),
    "bus": Bench(
        ("bench_bus.py",), ("bench_bus.py", "--joints", "5", "--seconds", "1", "--rounds", "2"), bus
    ),
    "cluster": Bench(
        ("bench_cluster.py", "--json"),
        ("bench_cluster.py", "--json", "--gaits", "200", "--sessions", "2"),
        cluster,
    ),
    "loop": Bench(
        ("bench_loop.py", "--json"),
        ("bench_loop.py", "--json", "--links", "pty", "--rates", "100", "--seconds", "2", "--slices", "2"),
        loop,
    ),
    "view": Bench(("bench_view.py", "--json"), ("bench_view.py", "--json", "--stops", "3"), view),
    "diagnosis": Bench(("bench_diagnosis", "--json"), ("bench_diagnosis", "--json"), diagnosis),
    "pair": Bench(
        ("bench_diagnosis", "--pair", "--json"), ("bench_diagnosis", "--pair", "--json"), diagnosis
    ),
    "growth": Bench(("bench_growth.py", "--json"), ("bench_growth.py", "--quick", "--json"), growth),
}  # fmt: skip


@dataclass(frozen=True)
class Done:
    """What came of a bench: rows, or what it said instead; ``load`` before it."""

    name: str
    load: float
    rows: list[Row]
    failed: str = ""


def run(name: str, *, quick: bool) -> Done:
    bench, load = BENCHES[name], os.getloadavg()[0]
    script, *options = bench.quick if quick else bench.words
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "figures.json"
        words = [str(file) if word == FIGURES else word for word in options]
        try:
            done = subprocess.run(
                [sys.executable, str(TOOLS / script), *words], capture_output=True, text=True, timeout=bench.limit_s
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return Done(name, load, [], f"took more than {bench.limit_s:.0f} s")
        if done.returncode:
            said = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
            return Done(name, load, [], said[-1])
        text = file.read_text(encoding="utf-8") if file.exists() else done.stdout
    try:
        rows = bench.read(text)
    except (ValueError, KeyError, StopIteration) as error:
        return Done(name, load, [], f"its output was not understood: {error!r}")
    return Done(name, load, rows, "" if rows else "it printed no figure with a peer")


def machine() -> str:
    """One line: what ran this."""
    name = platform.processor() or platform.machine()
    try:
        found = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
        name = found[1] if found else name
    except OSError:
        pass
    system = f"{platform.system()} {platform.release()}"
    return f"{name}, {os.cpu_count()} cores; {system}; Python {platform.python_version()}"


def cells(done: Done) -> list[tuple[str, ...]]:
    """A bench's part of the table: what, ours, unit, peer, theirs, ratio; empty where there is no peer."""
    return [
        (row.what, f"{row.ours:,.4g}", row.unit, row.peer)
        + (("", "") if row.theirs is None else (f"{row.theirs:,.4g}", f"{row.ratio:.2f}"))
        for row in done.rows
    ]


def lines(done: Done) -> list[str]:
    """Its part of the table, for a terminal."""
    head = f"{done.name:<10}{done.load:5.1f}  "
    if done.failed:
        return [f"{head}left out: {done.failed}"]
    return [
        f"{head}{what:<34} {ours:>12} {unit:<9} {peer or '-':<28} {theirs:>12} {ratio:>8}".rstrip()
        for what, ours, unit, peer, theirs, ratio in cells(done)
    ]


MARKDOWN_HEAD = "| bench | what | snakebot | | peer | its | ratio |\n|---|---|---|---|---|---|---|"


def markdown(done: Done) -> list[str]:
    """The same with ``MARKDOWN_HEAD`` above."""
    shown = [(f"left out: {done.failed}", *[""] * 5)] if done.failed else cells(done)
    return [f"| {' | '.join((done.name, *row))} |" for row in shown]


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="little of each, rough figures")
    parser.add_argument("--only", nargs="+", choices=tuple(BENCHES), default=tuple(BENCHES), metavar="NAME")
    parser.add_argument("--markdown", action="store_true", help="print the table for a page")
    parser.add_argument("--list", action="store_true", help="say which there are, and end")
    options = parser.parse_args()
    if options.list:
        for name, bench in BENCHES.items():
            print(f"{name:<10} tools/{' '.join(bench.words)}")
        return 0
    print(machine())
    columns = f"{'bench':<10}{'load':>5}  {'what':<34} {'snakebot':>12} {'':<9} {'peer':<28} {'its':>12} {'ratio':>8}"
    print(f"\n{MARKDOWN_HEAD}" if options.markdown else columns)
    failed, loads = 0, []
    for name in options.only:
        done = run(name, quick=options.quick)
        failed += bool(done.failed)
        loads.append(f"{name} {done.load:.1f}")
        print("\n".join(markdown(done) if options.markdown else lines(done)), flush=True)
    if options.markdown:
        print(f"\nLoad of the machine when each began: {', '.join(loads)}.")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
