"""The work of ``snakebot board sim``: a simulated board on the wire that was asked for."""

from __future__ import annotations

import contextlib
import ipaddress
import json
import os
import re
import signal
import threading
from collections.abc import Iterator
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

import click

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.cli.board_options import BoardOptions, SimOptions
    from snakebot.links import Link
    from snakebot.robot import Robot
    from snakebot.softboard import SoftBoard
    from snakebot.softboard.broken import Breakage


def serve_board(options: SimOptions) -> None:
    """Make the board, open the wire, say which, and answer until Ctrl-C or SIGTERM."""
    for name, value in (("model", options.model), ("damage", options.damage)):
        if value is not None:
            raise BadInputError(f"--{name} is for --feetech and --dynamixel")
    from snakebot.clock import MonotonicClock
    from snakebot.control import registry
    from snakebot.effects import parse_effects
    from snakebot.robot import load_robot
    from snakebot.softboard import serve

    check_wires(options)
    watchdog_ms = _watchdog_ms(options.watchdog_ms)
    robot = load_robot(options.robot_source)
    specs = parse_effects(options.effects, robot)
    breakages = [_breakage(text, robot) for text in options.faults]
    stop = until_told()
    with contextlib.ExitStack() as stack:
        end = stack.enter_context(contextlib.closing(open_end(options)))
        port = stack.enter_context(named(end, options.symlink))
        board = _board(robot, specs, breakages, options.seed, watchdog_ms)
        stack.enter_context(registry.registered(port, registry.BOARDS))
        announce(port, robot, options, "simulated board")
        serve(board, end, MonotonicClock(), stop)


def check_wires(options: BoardOptions, example: str = "snakebot board sim --serial") -> None:
    """
    Raises:
        BadInputError: not one wire, or a name for one that has none.
    """
    wires = {"--serial": options.as_serial, "--tcp": options.tcp, "--can": options.can}
    chosen = [name for name, given in wires.items() if given]
    if len(chosen) != 1:
        what = "say where" if not chosen else f"{' and '.join(chosen)}: choose one"
        raise BadInputError(
            f"{what}: --serial, --tcp [HOST:]PORT or --can INTERFACE/CHANNEL, for example: {example}"
        )
    if options.symlink and not (options.as_serial or options.can == "slcan"):
        raise BadInputError("--symlink names a pseudo-terminal: it goes with --serial or --can slcan")


def open_end(options: BoardOptions) -> Link:
    """The board's end of the wire."""
    from snakebot.softboard import PtyEnd, TcpEnd
    from snakebot.softboard.slcan_end import SlcanEnd

    if options.as_serial:
        return PtyEnd()
    if options.tcp:
        host, number = _address(options.tcp)
        end = TcpEnd(host, number)
        if not ipaddress.ip_address(end.address[0]).is_loopback:
            _warn_of_others(host)
        return end
    if options.can == "slcan":
        return SlcanEnd()
    from snakebot.links.can_link import open_can
    from snakebot.links.multicast import OPTION as NETWORK
    from snakebot.links.port import CanPort, parse_port

    assert options.can is not None  # check_wires
    port = parse_port("can:" + options.can.removeprefix("can:"))
    assert isinstance(port, CanPort)
    link = open_can(port, role="Board")
    if port.interface == "udp_multicast" and dict(port.options).get(NETWORK, "0") != "0":
        _warn_of_others(str(port))
    return link


def _warn_of_others(where: str) -> None:
    click.echo(f"snakebot: listening on {where}: whoever reaches this computer can drive the board", err=True)


def _address(text: str) -> tuple[str, int]:
    host, _, number = text.rpartition(":")
    if not re.fullmatch(r"[0-9]{1,5}", number) or int(number) > 65535:
        raise BadInputError(f"--tcp {text!r}: must be HOST:PORT or a port, for example --tcp 127.0.0.1:5555")
    return host.strip("[]") or "127.0.0.1", int(number)


@contextlib.contextmanager
def named(end: Link, symlink: str | None) -> Iterator[str]:
    """The port to use: the wire's own, or under the name that was asked for."""
    if symlink is None:
        yield end.port
        return
    device: str = end.path  # type: ignore[attr-defined]  # _check_wires: it is a pseudo-terminal
    path = Path(symlink).absolute()
    try:
        if path.is_symlink():
            path.unlink()
        path.symlink_to(device)
    except OSError as error:
        raise BadInputError(f"--symlink {symlink}: {error.strerror}") from None
    try:
        yield end.port.replace(device, str(path))
    finally:
        with contextlib.suppress(OSError):
            if os.readlink(path) == device:
                path.unlink()


def _breakage(text: str, robot: Robot) -> Breakage:
    from firmware_protocol.catalogue import JointMode
    from snakebot.control import parse_fault
    from snakebot.softboard.broken import Breakage

    fault = parse_fault(text, robot.joints)
    match fault.mode:
        case JointMode.ACTIVE:
            return Breakage(fault.at_s, fault.joints, "active")
        case JointMode.FREE:
            return Breakage(fault.at_s, fault.joints, "free")
        case JointMode.RIGID:
            return Breakage(fault.at_s, fault.joints, "rigid", fault.angle_rad)
        case JointMode.RIGID_HERE:
            return Breakage(fault.at_s, fault.joints, "rigid")


def _watchdog_ms(given: int | None) -> int:
    from snakebot.softboard.buildable import MAX_WATCHDOG_MS, MIN_WATCHDOG_MS
    from snakebot.softboard.modes import WATCHDOG_MS

    if given is None:
        return WATCHDOG_MS
    if not MIN_WATCHDOG_MS <= given <= MAX_WATCHDOG_MS:
        raise BadInputError(f"--watchdog-ms {given}: give {MIN_WATCHDOG_MS} to {MAX_WATCHDOG_MS} ms")
    return given


def _board(robot: Robot, specs: Any, breakages: list[Breakage], seed: int, watchdog_ms: int) -> SoftBoard:
    from snakebot.softboard import SoftBoard
    from snakebot.softboard.broken import BreakingPlant
    from snakebot.softboard.plant import make_plant

    if not breakages:
        return SoftBoard(robot, specs, seed, watchdog_ms=watchdog_ms)
    plant = BreakingPlant(make_plant(robot, specs, seed, None), breakages)
    return SoftBoard(robot, plant=plant, watchdog_ms=watchdog_ms)


def until_told() -> threading.Event:
    """An event that Ctrl-C, SIGTERM and a closed terminal set.

    A thread sets it: a handler comes in the middle of whatever the main thread does, and where that is a call of the
    event itself, as in the handler of a signal just before, it would wait for a lock that only the main thread frees.
    """
    stop = threading.Event()
    told: SimpleQueue[int] = SimpleQueue()  # its ``put`` may be called in the middle of another

    def wait_and_stop() -> None:
        told.get()
        stop.set()

    threading.Thread(target=wait_and_stop, name="told", daemon=True).start()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, _: told.put(number))
    return stop


def announce(port: str, robot: Robot, options: BoardOptions, what: str, **more: Any) -> None:
    """One line on standard output, for people and for programs that wait for it; these get ``more``."""
    if options.as_json:
        about = {"port": port, "robot": robot.name, "joints": robot.joints, "pid": os.getpid()}
        click.echo(json.dumps({**about, **more}))
    else:
        click.echo(f"--port {port}")
        click.echo(f"{what}: {robot.name}, {robot.joints} joints; Ctrl-C ends it", err=True)
