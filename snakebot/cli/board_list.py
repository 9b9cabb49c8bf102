"""The work of ``snakebot board list``."""

from __future__ import annotations

from typing import Any

import click

from snakebot.errors import SnakebotError
from snakebot.links.port import SERVO_FAMILIES

_PROBE_S = 0.6  # for one port to answer; chosen: several round trips of a slow adapter
MULTICAST = "can:udp_multicast/239.74.163.2"


def find(probe: bool) -> list[dict[str, Any]]:
    """Every port with what is known of it; with ``probe`` also the board that answers there, or why none does."""
    from snakebot.control import registry
    from snakebot.links.discover import can_ports, serial_ports

    simulated = {
        run.port: f"simulated board (process {run.pid})" for run in registry.running(registry.BOARDS)
    }
    found: list[dict[str, Any]] = [
        {"port": port, "what": what, "usable": True} for port, what in sorted(simulated.items())
    ]
    found += [
        {"port": each.port, "what": each.what, "usable": each.usable}
        for each in [*serial_ports(), *can_ports()]
        if each.port not in simulated
    ]
    if probe:
        if MULTICAST not in simulated:
            found.append({"port": MULTICAST, "what": "CAN over the network", "usable": True})
        for each in found:
            if each["port"].partition(":")[0] in SERVO_FAMILIES:
                each["board"], each["answer"] = None, _servos(each["port"]) or "no servo answers"
                continue
            each["board"], each["answer"] = _probe(each["port"])
            if each["board"] is None and each["usable"] and each["port"].startswith("serial:/"):
                _look_for_servos(each)
    return found


def _look_for_servos(each: dict[str, Any]) -> None:
    """No board answers on this serial line: perhaps it is an adapter to bus servos."""
    device = each["port"].removeprefix("serial:").partition("?")[0]
    for family in SERVO_FAMILIES:
        answer = _servos(f"{family}:{device}")
        if answer:
            each["answer"] = answer
            return


def _servos(port: str) -> str:
    """The servos that answer on a line, at the usual bit rates; empty: nobody."""
    from snakebot.clock import MonotonicClock
    from snakebot.links.port import ServoPort, parse_port
    from snakebot.servobus.scan import find_servos

    parsed = parse_port(port)
    assert isinstance(parsed, ServoPort)
    try:
        at, found = find_servos(parsed, MonotonicClock())
    except SnakebotError:
        return ""
    who = ", ".join(f"{each.id} ({each.name}, firmware {each.firmware_text})" for each in found)
    return f"servos {who}: --port {at}" if found else ""


def _probe(port: str) -> tuple[dict[str, Any] | None, str]:
    from dataclasses import asdict

    from snakebot.board import Board
    from snakebot.clock import MonotonicClock
    from snakebot.links import open_link

    try:
        with open_link(port) as link:
            info = Board(link, MonotonicClock()).connect(_PROBE_S)
    except SnakebotError as error:
        return None, str(error).removeprefix(f"{port}: ")
    kind = "simulated board" if info.simulated else "board"
    return asdict(info), f"{kind} {info.serial_number}, {info.joints} joints, firmware {info.firmware}"


def show(found: list[dict[str, Any]], probe: bool) -> None:
    """A table for people."""
    if not found:
        click.echo(
            "no serial port and no CAN interface found; `snakebot board sim --serial` simulates a board"
        )
        return
    width = max(len(each["port"]) for each in found)
    for each in found:
        locked = "" if each["usable"] else " (no permission: see `snakebot doctor`)"
        click.echo(f"{each['port']:{width}}  {each['what']}{locked}")
        if probe:
            click.echo(f"{'':{width}}  -> {each['answer']}")
    if not probe:
        click.echo("--probe asks each of them for a board")
