#!/usr/bin/env python3
"""Fuzz the parsers of everything that comes from outside with atheris (libFuzzer), guided by coverage.

    tools/fuzz_parsers.py                       every parser, 10 000 cases each
    tools/fuzz_parsers.py port csv --runs 1000000

Needs the extra `fuzz` (pip install 'snakebot[fuzz]'). A finding is left in build/fuzz and ends with status 1.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "build" / "fuzz"
sys.path.insert(0, str(ROOT / "tests" / "hostile"))


def child(name: str, runs: int, seed: int) -> None:
    """One parser in this process; libFuzzer does not come back."""
    import atheris

    with atheris.instrument_imports(include=["snakebot", "firmware_protocol"]):
        from parsers import DOCUMENTED, PARSERS, seeds

    corpus = OUT / name
    corpus.mkdir(parents=True, exist_ok=True)
    for number, data in enumerate(seeds()[name]):
        (corpus / f"seed-{number}").write_bytes(data)
    parser = PARSERS[name]

    def one(data: bytes) -> None:
        try:
            parser(data)
        except DOCUMENTED:
            return

    flags = [f"-runs={runs}", f"-seed={seed}", "-rss_limit_mb=2048", "-timeout=20", "-print_final_stats=1"]
    atheris.Setup([sys.argv[0], *flags, f"-artifact_prefix={OUT}/finding-{name}-", str(corpus)], one)
    atheris.Fuzz()


def main() -> int:
    from parsers import PARSERS

    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("parsers", nargs="*", help=", ".join(PARSERS))
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    unknown = set(options.parsers) - set(PARSERS)
    if unknown:
        parser.error(f"no parser {', '.join(sorted(unknown))}; there are {', '.join(PARSERS)}")
    if options.child:
        child(options.parsers[0], options.runs, options.seed)
        return 0
    try:
        import atheris  # noqa: F401
    except ImportError:
        parser.error("atheris is not installed: pip install 'snakebot[fuzz]'")
    OUT.mkdir(parents=True, exist_ok=True)
    findings = 0
    for name in options.parsers or PARSERS:
        command = [
            sys.executable,
            __file__,
            name,
            "--child",
            f"--runs={options.runs}",
            f"--seed={options.seed}",
        ]
        done = subprocess.run(command, capture_output=True, text=True)
        stats = dict(
            line.removeprefix("stat::").split(":", 1)
            for line in done.stderr.splitlines()
            if line.startswith("stat::")
        )
        cases = stats.get("number_of_executed_units", "?").strip()
        peak = stats.get("peak_rss_mb", "?").strip()
        print(
            f"{name:12} {cases:>9} cases, peak memory {peak} MB, {'ok' if done.returncode == 0 else 'FINDING'}",
            flush=True,
        )
        if done.returncode != 0:
            findings += 1
            print("\n".join(done.stderr.splitlines()[-30:]), file=sys.stderr)
    print(f"findings: {findings}")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
