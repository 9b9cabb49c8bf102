#!/usr/bin/env python3
"""`snakebot run` on `snakebot board sim` through the proxy of tools/bad_wire.py: three real processes, in real time.

    tools/bad_wire_run.py --wire pty --flip 0.01 --drop 0.05
        the proxy offers a pseudo-terminal (tcp: a TCP port; bus: it joins two CAN buses over multicast, in a network
        namespace of its own)
    tools/bad_wire_run.py --wire bus --awful-after 4
        half of everything is lost from 4 s on

The same run without a wire, in virtual time, is what it is compared with. Prints how both ended and their tracking
error, and what the board says afterwards. Status 1 if the board still has a run or powered joints 2.5 s later.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from firmware_protocol.catalogue import BoardHeartbeat, Mode, decode
from firmware_protocol.frame import ProtocolError
from snakebot.links.opening import open_link

TOOLS = Path(__file__).resolve().parent
SNAKEBOT = [sys.executable, "-m", "snakebot.cli.main"]
BUS = "udp_multicast/239.74.163.2"
NETWORK = "ip link set lo up && ip route add 239.0.0.0/8 dev lo"
INSIDE = "SNAKEBOT_INSIDE_NAMESPACE"
RELAXED_S = 2.5  # watchdog, two seconds frozen, and some


@dataclass(frozen=True)
class Outcome:
    """How one run of the command line ended."""

    status: int
    said: str
    summary: dict[str, Any] | None

    @property
    def tracking_error(self) -> float:
        """(37), the mean of the joints."""
        assert self.summary is not None
        return statistics.fmean(self.summary["tracking_error"])

    def __str__(self) -> str:
        if self.summary is None:
            return f"status {self.status}: {self.said}"
        counts = ", ".join(f"{self.summary[name]} {name}" for name in ("ticks", "lost", "late", "skipped"))
        return f"{self.summary['ended']}, {counts}, tracking error {self.tracking_error:.4f}"


@contextlib.contextmanager
def program(*command: str) -> Iterator[str]:
    """A process that lives as long as the block; the first line that it prints is the port that it offers."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        line = process.stdout.readline()
        if not line:
            assert process.stderr is not None
            raise SystemExit(f"{command[1]}: {process.stderr.read()}")
        yield line.split()[1]
    finally:
        process.terminate()
        print(process.communicate()[0], end="", file=sys.stderr)


def run(where: Sequence[str], seconds: float, log: Path) -> Outcome:
    gait = ["--alpha", "66", "--beta", "80", "--omega", "2", "--duration", f"{seconds:g}"]
    done = subprocess.run(
        [*SNAKEBOT, "run", *where, *gait, "--json", "--log", str(log)], capture_output=True, text=True
    )
    return Outcome(done.returncode, done.stderr.strip(), json.loads(done.stdout) if done.stdout else None)


def beat(port: str) -> BoardHeartbeat:
    """The board's next heartbeat, on its own port."""
    with contextlib.closing(open_link(port)) as link:
        deadline_s = time.monotonic() + 2
        while time.monotonic() < deadline_s:
            for frame in link.receive(0.2):
                with contextlib.suppress(ProtocolError):
                    message = decode(frame)
                    if isinstance(message, BoardHeartbeat):
                        return message
    raise SystemExit(f"{port}: the board does not beat")


def compare(wire: str, seconds: float, watchdog_ms: int, rates: Sequence[str]) -> dict[str, Any]:
    board = ["--can", BUS] if wire == "bus" else ["--tcp", "0"]
    board += ["--watchdog-ms", f"{watchdog_ms}"]
    with tempfile.TemporaryDirectory() as folder, program(*SNAKEBOT, "board", "sim", *board) as direct:
        if wire == "bus":
            ends = ["bus", "--board", BUS, "--host", f"{BUS}?port=43114"]
        else:
            ends = ["proxy", "--board", direct.removeprefix("serial:")]
            ends += ["--tcp", "0"] if wire == "tcp" else []
        clean = run(["--fast"], seconds, Path(folder) / "clean.mcap")
        with program(sys.executable, str(TOOLS / "bad_wire.py"), *ends, *rates) as through:
            bad = run(["--port", through], seconds, Path(folder) / "bad.mcap")
        at_end = beat(direct)
        time.sleep(RELAXED_S)
        later = beat(direct)
    return {
        "clean": asdict(clean),
        "bad": asdict(bad),
        "te_rise": bad.tracking_error - clean.tracking_error if bad.summary and clean.summary else None,
        "clean_text": str(clean),
        "bad_text": str(bad),
        "mode": Mode(at_end.mode).name.lower(),
        "later": {"mode": Mode(later.mode).name.lower(), "powered": bool(later.powered)},
    }


def network() -> list[str]:
    """How to start a command in a network namespace of its own. Raises SystemExit where that cannot be."""
    for how in (["unshare", "-n"], ["unshare", "-rn"]):  # a user namespace may not be urgent
        with contextlib.suppress(OSError):
            if subprocess.run([*how, "sh", "-c", NETWORK], capture_output=True).returncode == 0:
                return how
    raise SystemExit(
        "no network namespace can be made here (unshare, ip, or the right to use them is missing)"
    )


def main() -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--wire", choices=("pty", "tcp", "bus"), required=True)
    parser.add_argument("--seconds", type=float, default=8.0, help="of each run")
    parser.add_argument("--watchdog-ms", type=int, default=100, help="of the board [%(default)s]")
    parser.add_argument("--json", action="store_true")
    options, rates = parser.parse_known_args()  # the rest goes to the proxy
    if options.wire == "bus" and INSIDE not in os.environ:
        command = [*network(), "sh", "-c", f'{NETWORK} && exec "$0" "$@"', sys.executable, *sys.argv]
        return subprocess.run(command, env={**os.environ, INSIDE: "1"}).returncode
    found = compare(options.wire, options.seconds, options.watchdog_ms, rates)
    if options.json:
        print(json.dumps(found))
    else:
        print(f"no wire:    {found['clean_text']}\nbad wire:   {found['bad_text']}")
        if found["te_rise"] is not None:
            print(f"tracking error: {found['te_rise']:+.4f} of the amplitude")
        print(f"board:      {found['mode']} at the end; {RELAXED_S:g} s later {found['later']}")
    safe = found["later"]["mode"] in ("disarmed", "fault", "stopped") and not found["later"]["powered"]
    return 0 if safe else 1


if __name__ == "__main__":
    sys.exit(main())
