#!/usr/bin/env python3
"""Branch coverage of the firmware's hand-written core by its tests; ends with status 1 below 95 %.

Runs what drives the core in this process: tests/firmware, and the conformance suite on the core. Needs cc and gcovr.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FIRMWARE = ROOT / "firmware_protocol/firmware"
OUT = ROOT / "build/firmware/coverage"
WANTED_PERCENT = 95.0


def main() -> int:
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    for program in ("cc", "gcovr"):
        if shutil.which(program) is None:
            print(f"{program} is not installed: apt-get install gcc gcovr", file=sys.stderr)
            return 2
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    sources = [
        *FIRMWARE.glob("core/*.c"),
        *FIRMWARE.glob("core/generated/*.c"),
        *FIRMWARE.glob("port/model/*.c"),
    ]
    sources.append(FIRMWARE / "port/bench/bench.c")
    for source in sources:
        flags = ["-std=c11", "-O0", "-g", "--coverage", "-fPIC", f"-I{FIRMWARE}", f"-I{FIRMWARE / 'core'}"]
        flags += [f"-I{FIRMWARE / 'port'}", "-c", str(source), "-o", str(OUT / f"{source.stem}.o")]
        subprocess.run(["cc", *flags], check=True)
    library = OUT / "bench.so"
    subprocess.run(
        ["cc", "--coverage", "-shared", "-o", str(library), *map(str, OUT.glob("*.o")), "-lm"], check=True
    )
    tests = [
        "tests/firmware",
        "tests/conformance/test_conformance.py",
        "-k",
        "core or both_boards or limiter_in_c",
    ]
    pytest = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests]
    subprocess.run(pytest, cwd=ROOT, env={**os.environ, "SNAKEBOT_CORE_LIBRARY": str(library)}, check=True)

    report = OUT / "coverage.json"
    gcovr = ["gcovr", "--root", str(FIRMWARE), "--filter", f"{FIRMWARE}/core/[a-z]+\\.c", str(OUT)]
    subprocess.run([*gcovr, "--branches", "--json-summary", str(report), "--txt"], check=True)
    found = json.loads(report.read_text(encoding="utf-8"))
    covered, total = found["branch_covered"], found["branch_total"]
    percent = 100.0 * covered / total
    print(
        f"core: {percent:.1f} % of {total} branches, {found['line_percent']:.1f} % of {found['line_total']} lines"
    )
    return 0 if percent > WANTED_PERCENT else 1


if __name__ == "__main__":
    sys.exit(main())
