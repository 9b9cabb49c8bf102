#!/usr/bin/env python3
"""Break the wire between host and board, at set rates and from a seed.

    tools/bad_wire.py runs --flip 0.01 --drop 0.05
        runs in virtual time over such a wire, serial and CAN: how each ended and its tracking error
    tools/bad_wire.py proxy --board /dev/ttyUSB0 --flip 0.001 --drop 0.02
        stands between a real host and a real board: prints the pseudo-terminal to give to `snakebot run --port`
    tools/bad_wire.py proxy --board socket://127.0.0.1:5555 --tcp 5556
        the same with a TCP port, on this computer only
    tools/bad_wire.py bus --board udp_multicast/239.74.163.2 --host udp_multicast/239.74.163.2?port=43114
        between two CAN channels (any python-can interface; multicast groups are kept apart by their port alone)

Ctrl-C ends a proxy and prints what it did to each direction. With --awful-after a proxy loses half of everything from
so many seconds after the host's first word on.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import select
import signal
import socket
import statistics
import sys
import time
import tty
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "wire"))

from wire_bench import Bench  # noqa: E402

from snakebot.errors import SnakebotError  # noqa: E402
from snakebot.links.can_link import Role, open_can  # noqa: E402
from snakebot.links.port import CanPort, parse_port  # noqa: E402
from snakebot.softboard.disturbance import BadBus, BadStream, Rates  # noqa: E402

_CHUNK = 65536
_POLL_S = 0.0005  # a bus has no end that one could wait for together with another


def runs(options: argparse.Namespace, rates: Rates) -> int:
    """Runs of eight seconds in virtual time, and the same without disturbance."""
    clean = Bench(duration_s=8, rate_hz=options.rate)
    clean.run()
    reference = clean.tracking_error(2, 6)
    print(f"rates: {asdict(rates)}; {options.rate:g} Hz; tracking error on a clean wire: {reference:.4f}")
    safe = True
    for can in (False, True):
        ends: Counter[str] = Counter()
        errors: list[float] = []
        lost = ticks = 0
        for seed in range(options.seed, options.seed + options.runs):
            bench = Bench(rates, seed, can=can, duration_s=8, rate_hz=options.rate)
            try:
                ends[bench.run().ended] += 1
                errors.append(bench.tracking_error(2, 6))
            except SnakebotError as error:
                ends[f"{type(error).__name__} (status {error.exit_status})"] += 1
                bench.rest_of_life(3)
                safe = safe and not any(bench.joints.powered)
            lost += bench.loop.progress.lost
            ticks += bench.loop.progress.ticks
        name = "CAN   " if can else "serial"
        print(f"{name} {options.runs} runs: {', '.join(f'{n} {end}' for end, n in ends.items())}", end="")
        if errors:
            print(
                f"; tracking error mean {statistics.fmean(errors):.4f}, worst {max(errors):.4f} "
                f"(+{100 * (max(errors) / reference - 1):.1f} %)",
                end="",
            )
        print(f"; {lost} of {ticks} set-points without an answer")
    print(f"boards without power after runs that ended early: {'all' if safe else 'NOT ALL'}")
    return 0 if safe else 1


class Worsening:
    """Makes both directions lose half of everything, some time after the host has first spoken; never with None."""

    def __init__(self, after_s: float | None, ways: Sequence[BadStream | BadBus]) -> None:
        self._after_s = after_s
        self._ways = ways
        self._due_s: float | None = None

    def look(self, host_spoke: bool) -> None:
        if self._after_s is None:
            return
        if self._due_s is None and host_spoke:
            self._due_s = time.monotonic() + self._after_s
        if self._due_s is not None and time.monotonic() >= self._due_s:
            self._after_s = None
            for way in self._ways:
                way.rates = replace(way.rates, flip=0.5, drop=0.5)
            print("from now on half of everything is lost", flush=True)


def _host_end(options: argparse.Namespace) -> tuple[int, Any]:
    """A descriptor that the host's bytes come from, and what must stay open with it."""
    if options.tcp is not None:
        door = socket.create_server(("127.0.0.1", options.tcp))
        print(f"--port serial:socket://127.0.0.1:{door.getsockname()[1]} (this computer only)", flush=True)
        host, _ = door.accept()
        host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        host.setblocking(False)
        return host.fileno(), (door, host)
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    print(f"--port serial:{os.ttyname(slave)}", flush=True)
    return master, slave


def _board_end(url: str, baud: int) -> tuple[int, Any]:
    import serial

    try:
        port = serial.serial_for_url(url, baudrate=baud, timeout=0)
    except (serial.SerialException, OSError, ValueError) as error:
        raise SystemExit(f"{url}: {error}") from None
    if not hasattr(port, "_socket"):
        return port.fileno(), port
    port._socket.setsockopt(
        socket.IPPROTO_TCP, socket.TCP_NODELAY, 1
    )  # else a tick waits up to 40 ms for the next
    return port._socket.fileno(), port


def proxy(options: argparse.Namespace, rates: Rates) -> int:
    """Bytes between a board and a host until Ctrl-C, or until one of them has gone."""
    board, _keep_board = _board_end(options.board, options.baud)
    host, _keep_host = _host_end(options)
    delimiter = b"\r" if options.slcan else b"\0"
    now = time.monotonic
    ways = {
        host: (board, BadStream(rates, 2 * options.seed, now, delimiter)),
        board: (host, BadStream(rates, 2 * options.seed + 1, now, delimiter)),
    }
    worsening = Worsening(options.awful_after, [way for _, way in ways.values()])
    with contextlib.suppress(KeyboardInterrupt, OSError):
        while True:
            due = [way.due_s for _, way in ways.values() if way.due_s is not None]
            timeout = min(max(0.0, min(due, default=math.inf) - now()), 0.1)
            ready, _, _ = select.select(list(ways), [], [], timeout)
            worsening.look(host in ready)
            for end, (other, way) in ways.items():
                data = os.read(end, _CHUNK) if end in ready else b""
                if end in ready and not data:
                    raise OSError
                out = way(data)
                with contextlib.suppress(
                    BlockingIOError
                ):  # nobody reads: lost, as on a line without a listener
                    while out:
                        out = out[os.write(other, out) :]
    _report({"to the board": ways[host][1], "to the host": ways[board][1]})
    return 0


def _can_port(where: str) -> CanPort:
    port = parse_port("can:" + where.removeprefix("can:"))
    assert isinstance(port, CanPort)
    return port


def bus(options: argparse.Namespace, rates: Rates) -> int:
    """Frames between two CAN channels until Ctrl-C.

    Each end takes the other side's messages only: some interfaces hand back what we have sent ourselves.
    """
    roles: tuple[tuple[str, Role], ...] = ((options.host, "Board"), (options.board, "Host"))
    ends = [open_can(_can_port(where), role) for where, role in roles]
    ways = [
        BadBus(rates, 2 * options.seed + side, time.monotonic, checked=not options.unchecked)
        for side in (0, 1)
    ]
    worsening = Worsening(options.awful_after, ways)
    print(f"--port can:{options.host}", flush=True)
    with contextlib.suppress(KeyboardInterrupt):
        while True:
            for side, way in enumerate(ways):
                frames = ends[side].receive(_POLL_S)
                worsening.look(bool(frames) and side == 0)
                ends[1 - side].send(way(frames))
    for end in ends:
        end.close()
    _report({"to the board": ways[0], "to the host": ways[1]})
    return 0


def _report(ways: dict[str, BadStream | BadBus]) -> None:
    for name, way in ways.items():
        print(f"{name}: " + ", ".join(f"{count} {what}" for what, count in asdict(way.done).items()))


def main() -> int:
    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("runs", "proxy", "bus"):
        command = commands.add_parser(name)
        for field in fields(Rates):
            command.add_argument(f"--{field.name.replace('_', '-')}", type=float, default=field.default)
        command.add_argument("--seed", type=int, default=0)
        if name == "runs":
            command.add_argument("--runs", type=int, default=20)
            command.add_argument("--rate", type=float, default=100.0, help="ticks a second")
        else:
            command.add_argument("--board", required=True, help="where the board is")
            command.add_argument(
                "--awful-after", type=float, help="seconds after which half of everything is lost"
            )
        if name == "proxy":
            command.add_argument("--baud", type=int, default=1_000_000)
            command.add_argument(
                "--tcp", type=int, help="offer a TCP port (0: any) instead of a pseudo-terminal"
            )
            command.add_argument("--slcan", action="store_true", help="the line carries slcan, not COBS")
        if name == "bus":
            command.add_argument(
                "--host", required=True, help="where the host is: INTERFACE/CHANNEL[?option=...]"
            )
            command.add_argument("--unchecked", action="store_true", help="pass damaged frames on")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        rates = Rates(**{field.name: getattr(options, field.name) for field in fields(Rates)})
    except SnakebotError as error:
        parser.error(str(error))
    try:
        return {"runs": runs, "proxy": proxy, "bus": bus}[options.command](options, rates)
    except SnakebotError as error:
        print(f"bad_wire: {error}", file=sys.stderr)
        return error.exit_status


if __name__ == "__main__":
    sys.exit(main())
