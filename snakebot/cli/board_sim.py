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
from typing import TYPE_CHECKING, Any

import click

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.links import Link
    from snakebot.robot import Robot
    from snakebot.simboard import SimBoard
    from snakebot.simboard.broken import Breakage


def serve_board(options: dict[str, Any]) -> None:
    """Make the board, open the wire, say which, and answer until Ctrl-C or SIGTERM."""
    from snakebot.clock import MonotonicClock
    from snakebot.control import registry
    from snakebot.effects import parse_effects
    from snakebot.robot import load_robot
    from snakebot.simboard import serve

    _check_wires(options)
    robot = load_robot(options["robot_source"])
    specs = parse_effects(options["effects"], robot)
    breakages = [_breakage(text, robot) for text in options["faults"]]
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: stop.set())
    with contextlib.ExitStack() as stack:
        end = stack.enter_context(contextlib.closing(_open_end(options)))
        port = stack.enter_context(_named(end, options["symlink"]))
        board = _board(robot, specs, breakages, options["seed"])
        stack.enter_context(registry.registered(port, registry.BOARDS))
        _announce(port, robot, options)
        serve(board, end, MonotonicClock(), stop)


def _check_wires(options: dict[str, Any]) -> None:
    chosen = [name for name, given in _wires(options).items() if given]
    if len(chosen) != 1:
        what = "say where" if not chosen else f"{' and '.join(chosen)}: choose one"
        raise BadInputError(
            f"{what}: --serial, --tcp [HOST:]PORT or --can INTERFACE/CHANNEL, for example: snakebot board sim --serial"
        )
    if options["symlink"] and not (options["as_serial"] or options["can"] == "slcan"):
        raise BadInputError("--symlink names a pseudo-terminal: it goes with --serial or --can slcan")


def _wires(options: dict[str, Any]) -> dict[str, Any]:
    return {"--serial": options["as_serial"], "--tcp": options["tcp"], "--can": options["can"]}


def _open_end(options: dict[str, Any]) -> Link:
    """The board's end of the wire."""
    from snakebot.simboard import PtyEnd, TcpEnd
    from snakebot.simboard.slcan_end import SlcanEnd

    if options["as_serial"]:
        return PtyEnd()
    if options["tcp"]:
        host, number = _address(options["tcp"])
        end = TcpEnd(host, number)
        if not ipaddress.ip_address(end.address[0]).is_loopback:
            click.echo(
                f"snakebot: listening on {host}: whoever reaches this computer can drive the board", err=True
            )
        return end
    if options["can"] == "slcan":
        return SlcanEnd()
    from snakebot.links.can_link import open_can
    from snakebot.links.port import CanPort, parse_port

    port = parse_port("can:" + options["can"].removeprefix("can:"))
    assert isinstance(port, CanPort)
    return open_can(port, role="Board")


def _address(text: str) -> tuple[str, int]:
    host, _, number = text.rpartition(":")
    if not re.fullmatch(r"[0-9]{1,5}", number) or int(number) > 65535:
        raise BadInputError(f"--tcp {text!r}: must be HOST:PORT or a port, for example --tcp 127.0.0.1:5555")
    return host.strip("[]") or "127.0.0.1", int(number)


@contextlib.contextmanager
def _named(end: Link, symlink: str | None) -> Iterator[str]:
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
    from snakebot.simboard.broken import Breakage

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


def _board(robot: Robot, specs: Any, breakages: list[Breakage], seed: int) -> SimBoard:
    from snakebot.simboard import SimBoard
    from snakebot.simboard.board import make_plant
    from snakebot.simboard.broken import BreakingPlant

    if not breakages:
        return SimBoard(robot, specs, seed)
    return SimBoard(robot, plant=BreakingPlant(make_plant(robot, specs, seed, None), breakages))


def _announce(port: str, robot: Robot, options: dict[str, Any]) -> None:
    """One line on standard output, for people and for programs that wait for it."""
    if options["as_json"]:
        click.echo(
            json.dumps({"port": port, "robot": robot.name, "joints": robot.joints, "pid": os.getpid()})
        )
    else:
        click.echo(f"--port {port}")
        click.echo(f"simulated board: {robot.name}, {robot.joints} joints; Ctrl-C ends it", err=True)
