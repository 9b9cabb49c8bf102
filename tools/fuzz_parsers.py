#!/usr/bin/env python3
"""Fuzz the parsers of everything that comes from outside, and print what came of it.

    tools/fuzz_parsers.py                       every parser, 10 000 cases each
    tools/fuzz_parsers.py port csv --runs 1000000
    tools/fuzz_parsers.py --runs 1000000 --seconds 600 --engine hypothesis
    tools/fuzz_parsers.py --runs 1000000 --seconds 300 --go-on     counts what earlier runs did

Engines: atheris (libFuzzer, guided by coverage; needs the extra `fuzz`: pip install 'snakebot[fuzz]') and hypothesis
(damaged sound input, as in tests/hostile). A case may raise the documented errors only, in one printable line; it may
write nothing outside its own folder, start no program, execute no text, and all cases together may not take more than
256 MiB over what the parser takes for sound input. What does is a finding: its input is left in build/fuzz, and the
exit status is 1. A parser ends at --runs cases or after --seconds, whichever is first. What was
run is written down in --ledger: with --go-on those cases count. Every process has a seed of its own.
"""

from __future__ import annotations

import argparse
import csv
import math
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "build" / "fuzz"
MORE_MIB = 256  # over the memory that sound input takes
CASES_OF_A_PROCESS = 200_000  # atheris loses some 500 bytes of memory a case, hypothesis keeps a tree of them
CASE_S = 30  # a case that takes longer hangs
sys.path.insert(0, str(ROOT / "tests" / "hostile"))
from watch import look_away, watch  # noqa: E402

Case = Callable[[bytes], None]


def peak_mib() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10


def place_of(error: BaseException) -> str:
    """What makes two findings the same: the kind of error, and the last line of ours that it went through."""
    ours = [f for f in traceback.extract_tb(error.__traceback__) if "/snakebot/" in f.filename]
    at = (ours or list(traceback.extract_tb(error.__traceback__)))[-1]
    return f"{type(error).__name__} at {Path(at.filename).name}:{at.lineno}"


class Counted:
    """A parser that counts its cases and keeps its findings, so that fuzzing goes on after one."""

    def __init__(self, name: str) -> None:
        from parsers import DOCUMENTED, PARSERS, folder

        self.name, self.parse, self.documented = name, PARSERS[name], DOCUMENTED
        self.folder = folder()
        self.cases = 0
        self.findings: dict[str, str] = {}
        self.base_mib = self.peak_mib = peak_mib()

    def __call__(self, data: bytes) -> None:
        self.cases += 1
        trespasses = watch(self.folder)
        try:
            self.parse(data)
        except self.documented as error:
            line = str(error)
            if not line.isprintable() and not isinstance(error, ValueError) and not self.printable(line):
                self.found(data, "an error of several lines, or with control characters", line)
        except Exception as error:
            self.found(data, place_of(error), "".join(traceback.format_exception(error)))
        look_away()
        if trespasses:
            self.found(data, f"trespass: {trespasses[0][:60]}", "\n".join(trespasses))
        before, self.peak_mib = self.peak_mib, peak_mib()
        if self.peak_mib > self.base_mib + MORE_MIB >= before:
            grown = f"from {before} MiB to {self.peak_mib} MiB, where sound input takes {self.base_mib} MiB"
            self.found(data, "too much memory", grown)

    @staticmethod
    def printable(line: str) -> bool:
        return not any(ord(sign) < 32 or 127 <= ord(sign) < 160 for sign in line)

    def found(self, data: bytes, place: str, told: str) -> None:
        look_away()
        if place not in self.findings:
            path = OUT / f"finding-{self.name}-{len(self.findings)}"
            path.write_bytes(data)
            self.findings[place] = told
            print(
                f"FINDING {self.name}: {place} ({path.relative_to(ROOT)})\n{told}",
                file=sys.stderr,
                flush=True,
            )

    def tell(self) -> None:
        figures = (self.cases, len(self.findings), peak_mib(), self.base_mib)
        print("RESULT", *figures, file=sys.stderr, flush=True)


def by_atheris(counted: Counted, seeds: list[bytes], runs: int, seconds: int, seed: int) -> None:
    """libFuzzer does not come back: the result is told as soon as the last case is done, or by the clock."""
    import atheris

    corpus = OUT / "corpus" / counted.name
    corpus.mkdir(parents=True, exist_ok=True)
    for number, data in enumerate(seeds):
        (corpus / f"seed-{number}").write_bytes(data)
    until = time.monotonic() + seconds
    told = False

    def one(data: bytes) -> None:
        nonlocal told
        counted(data)
        if counted.cases >= runs or (counted.cases % 64 == 0 and time.monotonic() > until):
            if not told:
                counted.tell()
            told = True
            os._exit(0)

    length = max(4096, *map(len, seeds))
    flags = [
        f"-runs={2 * runs}",
        f"-seed={seed}",
        f"-timeout={CASE_S}",
        f"-max_len={length}",
        "-rss_limit_mb=4096",
    ]
    atheris.Setup([sys.argv[0], *flags, f"-artifact_prefix={OUT}/stopped-{counted.name}-", str(corpus)], one)
    atheris.Fuzz()


def by_hypothesis(counted: Counted, runs: int, seconds: int, seed: int) -> None:
    """In rounds, each with a tree of what hypothesis has tried."""
    import hypothesis
    from damage import damaged_many

    until = time.monotonic() + seconds
    number = 0
    while counted.cases < runs and time.monotonic() < until:

        @hypothesis.seed(1000 * seed + number)
        @hypothesis.settings(
            max_examples=500,
            deadline=None,
            database=None,
            suppress_health_check=list(hypothesis.HealthCheck),
        )
        @hypothesis.given(damaged_many(counted.name, 16))
        def round_of_cases(inputs: list[bytes]) -> None:
            for data in inputs:
                if counted.cases < runs and time.monotonic() < until:
                    counted(data)

        round_of_cases()
        number += 1
    counted.tell()


def child(name: str, engine: str, runs: int, seconds: int, seed: int) -> None:
    """One parser in this process."""
    if engine == "atheris":
        import atheris

        with atheris.instrument_imports(include=["snakebot", "firmware_protocol"]):
            counted, sound = ready(name)
        by_atheris(counted, sound, runs, seconds, seed)
    else:
        counted, sound = ready(name)
        by_hypothesis(counted, runs, seconds, seed)


def ready(name: str) -> tuple[Counted, list[bytes]]:
    """The parser, all that it imports on the way imported, and its sound input."""
    from seeds import seeds

    counted, sound = Counted(name), seeds(name)
    for data in sound:
        for part in (data, data[: len(data) // 2], b""):
            try:
                counted.parse(part)
            except counted.documented:
                continue
    counted.base_mib = counted.peak_mib = peak_mib()
    return counted, sound


def main() -> int:
    if sys.argv[1:2] == ["--child"]:  # nothing of ours may be imported before atheris can instrument it
        name, engine, runs, seconds, seed = sys.argv[2:]
        child(name, engine, int(runs), int(seconds), int(seed))
        return 0
    from parsers import FOLDER_VARIABLE, PARSERS

    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("parsers", nargs="*", help=", ".join(PARSERS))
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--seconds", type=int, default=3600, help="for each parser")
    parser.add_argument("--engine", choices=("atheris", "hypothesis"), default="atheris")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--go-on", action="store_true", help="count what earlier runs did towards --runs")
    parser.add_argument(
        "--ledger",
        type=Path,
        default=OUT / "cases.csv",
        help="parser, engine, seed, cases, findings of each run",
    )
    options = parser.parse_args()
    unknown = set(options.parsers) - set(PARSERS)
    if unknown:
        parser.error(f"no parser {', '.join(sorted(unknown))}; there are {', '.join(PARSERS)}")
    try:
        __import__(options.engine)
    except ImportError:
        parser.error(f"{options.engine} is not installed: pip install 'snakebot[fuzz,test]'")
    OUT.mkdir(parents=True, exist_ok=True)
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # files there cost no disk
    place = tempfile.mkdtemp(prefix="snakebot-fuzz-", dir=memory)
    findings = 0
    try:
        for name in options.parsers or PARSERS:
            findings += fuzz(name, options, {**os.environ, FOLDER_VARIABLE: place})
    finally:
        shutil.rmtree(place, ignore_errors=True)
    print(f"findings: {findings}")
    return 1 if findings else 0


def done_before(path: Path, name: str, engine: str) -> tuple[int, int]:
    """Cases of a parser in earlier runs without a finding, and how many runs these were."""
    if not path.exists():
        return 0, 0
    with path.open(newline="") as ledger:
        rows = [row for row in csv.reader(ledger) if row[:2] == [name, engine]]
    return sum(int(row[3]) for row in rows if row[4] == "0"), len(rows)


def fuzz(name: str, options: argparse.Namespace, environment: dict[str, str]) -> int:
    """Run one parser in processes of its own and print a line; the number of findings."""
    before, seed = 0, options.seed
    if options.go_on:
        before, rounds = done_before(options.ledger, name, options.engine)
        seed += rounds
        if before >= options.runs:
            print(f"{name:12} {options.engine:10} {before:>9} cases in {rounds} runs before", flush=True)
            return 0
    cases = findings = most_mib = more_mib = 0
    began = time.monotonic()
    while before + cases < options.runs and time.monotonic() - began < options.seconds:
        runs = min(CASES_OF_A_PROCESS, options.runs - before - cases)
        left_s = math.ceil(options.seconds - (time.monotonic() - began))
        given = [str(value) for value in (options.engine, runs, left_s, seed)]
        command = [sys.executable, __file__, "--child", name, *given]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=environment)
        result = re.search(r"^RESULT (\d+) (\d+) (\d+) (\d+)$", done.stderr, re.M)
        if result is None:
            tail = "\n".join(done.stderr.splitlines()[-30:])
            print(f"{name:12} stopped with status {done.returncode}\n{tail}", flush=True)
            return findings + 1
        did, found, peak, base = map(int, result.groups())
        with options.ledger.open("a", newline="") as ledger:
            csv.writer(ledger).writerow([name, options.engine, seed, did, found])
        if found:
            print(done.stderr[done.stderr.index("FINDING") :][:4000], file=sys.stderr)
        cases, findings, seed = cases + did, findings + found, seed + 1
        most_mib, more_mib = max(most_mib, peak), max(more_mib, peak - base)
    print(
        f"{name:12} {options.engine:10} {cases:>9} cases, {findings} distinct findings, peak memory {most_mib} MiB "
        f"({more_mib} over sound input), {time.monotonic() - began:.0f} s"
        + (f"; {before + cases} with those before" if before else ""),
        flush=True,
    )
    return findings


if __name__ == "__main__":
    sys.exit(main())
