"""Corrupt packets against the board's own checks: how many are executed, measured and computed.

    python tools/corrupt_frames                    at least 10 million damaged packets
    python tools/corrupt_frames --packets 100000   fewer

The firmware's core (framing, catalogue, set-point assembly) is compiled and fed; needs a C compiler. Status 1 if a
set-point with angles that nobody sent was executed.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
FIRMWARE = HERE.parents[1] / "firmware_protocol" / "firmware"
KINDS = 8
_DAMAGED_SHARE = 3 / 4  # of the ticks have one damaged packet


def measure(packets: int, seed: int) -> list[tuple[str, list[int]]]:
    """(kind of damage, counts) for each kind: damaged, framed, accepted, command, executed, right."""
    compiler = os.environ.get("CC") or shutil.which("cc")
    if compiler is None:
        raise SystemExit("no C compiler: install gcc or clang")
    ticks = -(-packets // KINDS)
    ticks = int(ticks / _DAMAGED_SHARE) + 4
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "corrupt_frames"
        core = [str(FIRMWARE / "core" / name) for name in ("crc.c", "framing.c", "setpoint.c")]
        core += [str(path) for path in FIRMWARE.glob("core/generated/*.c")]
        include = [f"-I{FIRMWARE}", f"-I{FIRMWARE / 'core'}"]
        source = str(HERE / "corrupt_frames.c")
        subprocess.run([compiler, "-std=c11", "-O2", *include, "-o", str(program), source, *core], check=True)
        said = subprocess.run(
            [str(program), str(ticks), str(seed)], check=True, capture_output=True, text=True
        )
    rows = []
    for line in said.stdout.splitlines():
        name, *counts = line.rsplit(",", 6)
        rows.append((name, [int(count) for count in counts]))
    return rows


def main() -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        prog="corrupt_frames", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--packets", type=int, default=10_000_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rows = measure(options.packets, options.seed)
    heads = ("damaged", "pass CRC-16", "catalogue", "commands", "executed", "right")
    print(f"{'damage':20}" + "".join(f"{head:>12}" for head in heads))
    for name, counts in rows:
        print(f"{name:20}" + "".join(f"{count:12}" for count in counts))
    damaged = sum(counts[0] for _, counts in rows)
    wrong = sum(counts[4] for _, counts in rows)
    checked = sum(counts[0] for name, counts in rows if name != "payload, unchecked")
    framed = sum(counts[1] for name, counts in rows if name != "payload, unchecked")
    print(f"\ndamaged packets executed as set-points that nobody sent: {wrong} of {damaged}")
    print("residual rate of one damaged packet       computed     measured")
    print(
        f"  past CRC-16 (random damage)             2^-16 = {2**-16:.1e}   {framed / checked:.1e} (all kinds)"
    )
    print(f"  executed: CRC-16 and the tick's CRC-32  2^-48 = {2**-48:.1e}   < {3 / checked:.1e} (95 %)")
    unchecked = damaged - checked
    print(f"  executed: CRC-32 alone                  2^-32 = {2**-32:.1e}   < {3 / unchecked:.1e} (95 %)")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
