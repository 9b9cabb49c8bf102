#!/usr/bin/env python3
"""How time and memory of a diagnosis grow with joints, runs and seconds; each case in a process of its own.

    tools/bench_growth.py            one cause on 5 joints, 6 runs of 20 s at 100 Hz, then more and less of each
    tools/bench_growth.py --quick    the small cases alone

The peer is proportion: what the first case would take if time grew as the number of readings does. A ratio above 1 is
growth slower than that. ``memory``: the most that the process held, what it had before the session included.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from dataclasses import asdict, dataclass, replace
from math import radians
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from diagnosis_cases import GAITS, SETS, background, make_case, record_gaits

from snakebot.diagnosis import diagnose
from snakebot.effects import EffectSpec
from snakebot.gait import Gait
from snakebot.robot import load_robot
from snakebot.runlog import Session

RATE_HZ = 100.0
SLOWER = 0.85  # the same gaits again, where more motions are asked for than there are


@dataclass(frozen=True)
class Extent:
    """Of a session. ``runs``: the last one repeats the first."""

    joints: int
    runs: int
    duration_s: float

    @property
    def readings(self) -> float:
        return self.joints * self.runs * self.duration_s * RATE_HZ


FIRST = Extent(5, 6, 20.0)
CASES = (
    FIRST,
    replace(FIRST, joints=3), replace(FIRST, joints=10), replace(FIRST, joints=16),
    replace(FIRST, runs=3), replace(FIRST, runs=12),
    replace(FIRST, duration_s=10.0), replace(FIRST, duration_s=60.0),
    Extent(16, 10, 60.0),
)  # fmt: skip


@dataclass(frozen=True)
class Taken:
    """By one diagnosis; ``named``: the cause that is there comes first."""

    seconds: float
    cpu_seconds: float
    memory_mib: float
    verdict: str
    named: bool


def session(extent: Extent) -> Session:
    """One whose servos cannot turn faster than 1.3 rad/s, with the background of every made case."""
    rng = np.random.default_rng(SETS["test"] + 500)
    nominal = load_robot("penn_state")
    assert nominal.body is not None
    body = nominal.body.model_copy(update={"links": extent.joints + 1})
    nominal = nominal.model_copy(update={"joints": extent.joints, "body": body})
    real, truth = background(nominal, rng), (EffectSpec("rate_limit", {"limit_rad_s": 1.3}),)
    gaits = []
    for number in range(extent.runs - 1):
        alpha, beta, omega = GAITS[number % len(GAITS)]
        gaits.append(Gait(radians(alpha), radians(beta), omega * SLOWER ** (number // len(GAITS))))
    return Session(nominal, tuple(record_gaits(real, truth, gaits, rng, extent.duration_s)))


def measure(extent: Extent) -> Taken:
    """In this process: diagnose once something small, which compiles, then the session."""
    warm = make_case(("rate_limit",), SETS["test"], runs=2, duration_s=3.0, channel="pose", repeat=False)
    diagnose(warm.session, only=["rate_limit"], quick=True)
    made = session(extent)
    clock, cpu = time.perf_counter(), time.process_time()
    found = diagnose(made)
    clock, cpu = time.perf_counter() - clock, time.process_time() - cpu
    most_kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    named = bool(found.causes) and found.causes[0].effect == "rate_limit"
    return Taken(round(clock, 1), round(cpu, 1), round(most_kib / 1024), found.verdict, named)


def in_proportion_s(extent: Extent, first_s: float) -> float:
    """What a case would take if time grew from that of ``FIRST`` as the number of readings does."""
    return first_s * extent.readings / FIRST.readings


def in_a_process(extent: Extent) -> Taken:
    words = [sys.executable, __file__, "--one", *(str(v) for v in asdict(extent).values())]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{extent}: {(done.stderr.strip().splitlines() or ['it ended without a word'])[-1]}")
    return Taken(**json.loads(done.stdout))


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument(
        "--one", nargs=3, type=float, metavar=("JOINTS", "RUNS", "SECONDS"), help="this case, here"
    )
    options = parser.parse_args()
    if options.one:
        joints, runs, seconds = options.one
        print(json.dumps(asdict(measure(Extent(int(joints), int(runs), seconds)))))
        return 0
    cases = [c for c in CASES if not options.quick or c.readings <= FIRST.readings]
    if not options.json:
        print("joints  runs  s a run   clock s   CPU s   in proportion  ratio   memory MiB  verdict")
    rows = []
    first_s = 0.0
    for extent in cases:
        taken = in_a_process(extent)
        first_s = first_s or taken.seconds
        proportional = in_proportion_s(extent, first_s)
        rows.append({**asdict(extent), **asdict(taken), "in_proportion_s": round(proportional, 1)})
        if not options.json:
            size = f"{extent.joints:6d} {extent.runs:5d} {extent.duration_s:8.0f}"
            ratio = proportional / taken.seconds
            spent = f"{taken.seconds:9.1f} {taken.cpu_seconds:7.1f} {proportional:13.1f} {ratio:8.2f}"
            said = taken.verdict + ("" if taken.named else ", another cause first")
            print(f"{size} {spent} {taken.memory_mib:10.0f}   {said}", flush=True)
    if options.json:
        print(json.dumps(rows, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
