#!/usr/bin/env python3
"""Fuzz the firmware's core with libFuzzer, with address and undefined-behaviour sanitizers and its invariants checked.

    tools/fuzz_firmware.py                     10 million executions
    tools/fuzz_firmware.py --runs 100000       fewer
    tools/fuzz_firmware.py --keep              also keep what was found in the corpus

Needs clang. The corpus is tests/firmware/corpus.tar.xz, unpacked to build/firmware/corpus. A finding is left in
build/firmware and ends with status 1.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from corpus import pack, unpack

ROOT = Path(__file__).resolve().parent.parent
FIRMWARE = ROOT / "firmware_protocol/firmware"
ARCHIVE = ROOT / "tests/firmware/corpus.tar.xz"
OUT = ROOT / "build/firmware"
CORPUS = OUT / "corpus"


def build() -> Path:
    OUT.mkdir(parents=True, exist_ok=True)
    program = OUT / "fuzz_board"
    objects = OUT / "fuzz"
    objects.mkdir(exist_ok=True)
    checks = "address,undefined"
    flags = ["-std=c11", "-O2", "-gline-tables-only", "-fno-sanitize-recover=all"]
    flags += [f"-I{FIRMWARE}", f"-I{FIRMWARE / 'core'}", f"-I{FIRMWARE / 'port'}"]
    core = [*FIRMWARE.glob("core/*.c"), *FIRMWARE.glob("core/generated/*.c")]
    for source in (*core, *FIRMWARE.glob("port/model/*.c"), FIRMWARE / "port/fuzz/fuzz_board.c"):
        # Coverage of the checksums' inner loops tells the fuzzer nothing and costs half its speed.
        guided = source in core and source.name not in ("crc.c", "snakebot.c")
        sanitize = f"-fsanitize={'fuzzer-no-link,' if guided else ''}{checks}"
        command = ["clang", *flags, sanitize, "-c", str(source), "-o", str(objects / f"{source.stem}.o")]
        subprocess.run(command, check=True)
    link = ["clang", f"-fsanitize=fuzzer,{checks}", "-o", str(program), *map(str, objects.glob("*.o")), "-lm"]
    subprocess.run(link, check=True)
    return program


def start(program: Path, runs: int, seed: int, found: Path) -> subprocess.Popen[str]:
    """One fuzzer; what it finds new goes to ``found``, what it says to a file beside it."""
    command = [str(program), f"-runs={runs}", f"-seed={seed}", "-max_len=64", "-print_final_stats=1"]
    command += [f"-artifact_prefix={OUT}/finding-", str(found), str(CORPUS)]
    with found.with_suffix(".log").open("w") as log:
        return subprocess.Popen(command, stderr=log, text=True)


def report(process: subprocess.Popen[str], log: Path) -> int:
    """Wait for one fuzzer; how many inputs it has executed, or 0 after a finding."""
    status = process.wait()
    lines = log.read_text(encoding="utf-8").splitlines()
    if status != 0:
        print("\n".join(lines[-40:]), file=sys.stderr)
        return 0
    for line in lines:
        if "DONE" in line:
            print(line)
    (executed,) = (
        int(line.split()[1]) for line in lines if line.startswith("stat::number_of_executed_units")
    )
    return executed


def main() -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=10_000_000)
    parser.add_argument("--jobs", type=int, default=2, help="processes that share the executions")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", action="store_true", help="merge what was found into the corpus")
    options = parser.parse_args()
    if shutil.which("clang") is None:
        print("clang is not installed: apt-get install clang libclang-rt-14-dev", file=sys.stderr)
        return 2
    program = build()
    unpack(ARCHIVE, CORPUS)
    with tempfile.TemporaryDirectory() as folder:
        found = [Path(folder) / str(job) for job in range(options.jobs)]
        fuzzers = []
        for job, place in enumerate(found):
            place.mkdir()
            fuzzers.append(start(program, options.runs // options.jobs, options.seed + job, place))
        executed = [
            report(fuzzer, place.with_suffix(".log")) for fuzzer, place in zip(fuzzers, found, strict=True)
        ]
        if all(executed) and options.keep:
            merged = Path(folder) / "merged"
            merged.mkdir()
            command = [str(program), "-merge=1", "-max_len=64", str(merged), str(CORPUS), *map(str, found)]
            subprocess.run(command, check=True, capture_output=True)
            shutil.rmtree(CORPUS)
            shutil.copytree(merged, CORPUS)
            pack(CORPUS, ARCHIVE)
    print(f"executions: {sum(executed)}, findings: {executed.count(0)}")
    files = list(CORPUS.iterdir())
    print(f"corpus: {len(files)} files, {sum(file.stat().st_size for file in files)} bytes")
    return 0 if all(executed) else 1


if __name__ == "__main__":
    sys.exit(main())
