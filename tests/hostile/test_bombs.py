"""Ten kilobytes that ask for gigabytes: read or refused, within a bound on the memory of a real process."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest
from bombs import BOUND_MIB
from parsers import PARSERS

LARGE = {
    "csv_gz": 6,
    "parquet": 500,
    "log": 15,
    "dbc": 4,
    "robot": 10,
    "session": 10,
}  # at least so many bombs


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.skipif(not Path("/proc/self/clear_refs").exists(), reason="peak memory is asked of Linux")
@pytest.mark.parametrize("kind", [kind for kind in PARSERS if kind in LARGE])
def test_no_bomb_goes_off(kind: str) -> None:
    program = Path(__file__).with_name("bombs.py")
    done = subprocess.run([sys.executable, program, kind], capture_output=True, text=True)
    assert done.returncode == 0, f"after {done.stdout.splitlines()[-1:]}: {done.stderr[-2000:]}"
    results = [json.loads(line) for line in done.stdout.splitlines()]
    print(max(results, key=lambda result: result[4]))
    assert len(results) >= LARGE[kind]
    assert [result for result in results if result[3] not in ("read", "refused")] == []
    assert [result for result in results if result[4] > BOUND_MIB] == []


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.skipif(not Path("/proc/self/clear_refs").exists(), reason="peak memory is asked of Linux")
def test_no_bomb_of_the_small_parsers_goes_off() -> None:
    program = Path(__file__).with_name("bombs.py")
    small = [kind for kind in PARSERS if kind not in LARGE]
    done = subprocess.run([sys.executable, program, *small], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    results = [json.loads(line) for line in done.stdout.splitlines()]
    assert {result[1] for result in results} >= {
        "effect",
        "fault",
        "port",
        "stream",
        "slcan",
        "plug_in",
        "csv",
    }
    assert [
        result for result in results if result[3] not in ("read", "refused") or result[4] > BOUND_MIB
    ] == []


def test_the_measure_sees_a_bomb() -> None:
    """What would have to be refused is seen: in a process whose parser builds all that it is told."""
    code = (
        "import sys, parsers, bombs; parsers.PARSERS['bomb'] = lambda data: bytearray(int(data));"
        "print(bombs.let_off('bomb', b'600000000'))"
    )
    folder = str(Path(__file__).parent)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=folder, check=True
    )
    said, mib = ast.literal_eval(done.stdout)
    assert said == "read"
    assert mib > BOUND_MIB
