"""Every board of the project at the end of a link, ready for the suite."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from building import need
from core_bench import CoreBench, CoreLink

from snakebot.clock import MonotonicClock, VirtualClock
from snakebot.conformance import Bench
from snakebot.links import Link, open_link
from snakebot.links.stream_link import StreamLink
from snakebot.robot import load_robot
from snakebot.simboard import InProcessLink, SimBoard

STARTS_S = 20.0


def bytes_of(link: Link) -> Callable[[bytes], None]:
    """Raw bytes onto the stream under a serial link."""
    assert isinstance(link, StreamLink)
    return link.send_bytes


@contextmanager
def ahead_of_others() -> Iterator[None]:
    """Board and bench before whatever else the machine does, where it lets us: a board has its processor to itself."""
    before = os.getpriority(os.PRIO_PROCESS, 0)
    with contextlib.suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, -15)
    try:
        yield
    finally:
        with contextlib.suppress(PermissionError):
            os.setpriority(os.PRIO_PROCESS, 0, before)


@contextmanager
def sim_in_process() -> Iterator[Bench]:
    """The simulated board on a virtual clock."""
    clock = VirtualClock()
    board = SimBoard(load_robot("penn_state"))
    raw: list[bytes] = []
    link = InProcessLink(board, clock, to_board=lambda data: raw.pop() if raw else data)

    def send_bytes(data: bytes) -> None:
        raw.append(data)
        link.send([])

    yield Bench(
        link, clock, send_bytes=send_bytes, reset=lambda: board.reset(clock.now_s()), tolerance_s=0.003
    )


@contextmanager
def core_in_process(
    library: Any, *, can: bool = False, start_us: int = 0, joints: int = 5
) -> Iterator[Bench]:
    """The C core on a virtual clock."""
    clock = VirtualClock()
    bench = CoreBench(library, joints, start_us=start_us, time_constant_s=0.03)
    link = CoreLink(bench, clock, can=can)
    send_bytes = None if can else link.send_bytes
    yield Bench(link, clock, send_bytes=send_bytes, reset=bench.reset, tolerance_s=0.003)


@contextmanager
def _program(*command: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A program that prints the port to use in its first line."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        ready, _, _ = select.select([process.stdout], [], [], STARTS_S)
        assert ready, f"{command[0]} printed no port within {STARTS_S} s"
        yield process, process.stdout.readline().strip()
    finally:
        process.terminate()
        process.wait(10.0)
        if process.stdout is not None:
            process.stdout.close()


@contextmanager
def sim_program(*options: str) -> Iterator[Bench]:
    """The simulated board as its own program: ``--serial`` or ``--can slcan``."""
    program = "from snakebot.cli.main import main; main()"
    command = [sys.executable, "-c", program, "board", "sim", *options, "--json"]
    with _program(*command) as (_, line), open_link(json.loads(line)["port"]) as link:
        yield Bench(link, MonotonicClock(), send_bytes=bytes_of(link) if "--serial" in options else None)


@contextmanager
def host_firmware(program: Path, *options: str) -> Iterator[Bench]:
    """The reference firmware as a Linux program."""
    with _program(str(program), *options) as (process, port), open_link(port) as link:
        send_bytes = None if "--slcan" in options else bytes_of(link)
        yield Bench(
            link,
            MonotonicClock(),
            send_bytes=send_bytes,
            reset=lambda: _press(lambda: process.send_signal(signal.SIGUSR1)),
        )


def _press(reset: Callable[[], None]) -> None:
    reset()
    time.sleep(0.1)  # until it is up again


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as door:
        port: int = door.getsockname()[1]
        return port


@contextmanager
def qemu(image: Path) -> Iterator[tuple[str, Callable[[], None]]]:
    """The Cortex-M image on an emulated MPS2 board; the port to use, and its reset button."""
    need("qemu-system-arm")
    serial, monitor = free_port(), free_port()
    command = [
        "qemu-system-arm", "-M", "mps2-an385", "-display", "none", "-kernel", str(image),
        "-serial", f"tcp:127.0.0.1:{serial},server=on,wait=off,nodelay=on",
        "-monitor", f"tcp:127.0.0.1:{monitor},server=on,wait=off,nodelay=on",
    ]  # fmt: skip
    process = subprocess.Popen(command)
    try:
        _connect(serial).close()  # it listens there too
        buttons = _connect(monitor)
        try:
            yield (
                f"serial:socket://127.0.0.1:{serial}",
                lambda: _press(lambda: buttons.sendall(b"system_reset\n")),
            )
        finally:
            buttons.close()
    finally:
        process.terminate()
        process.wait(10.0)


def _connect(port: int) -> socket.socket:
    deadline = time.monotonic() + STARTS_S
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port))
        except OSError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.02)


@contextmanager
def cortex_m(image: Path) -> Iterator[Bench]:
    """The reference firmware on an emulated Cortex-M3."""
    with qemu(image) as (port, reset), open_link(port) as link:
        yield Bench(link, MonotonicClock(), send_bytes=bytes_of(link), reset=reset, tolerance_s=0.03)
