"""The work of ``snakebot board list``."""

from __future__ import annotations

from typing import Any

import click

from snakebot.errors import SnakebotError

_PROBE_S = 0.6
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
            each["board"], each["answer"] = _probe(each["port"])
    return found


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
