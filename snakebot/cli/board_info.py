"""The work of ``snakebot board info``."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import click

from snakebot.cli.ports import open_port
from snakebot.control.ports import port_clock

_LISTEN_S = 1.2  # counters and supply come once a second


def ask(port: str, robot_source: str) -> dict[str, Any]:
    """What the board says of itself within a second.

    Raises:
        NoBoardError: the port cannot be opened, or nobody answers.
    """
    from snakebot.board import Board
    from snakebot.robot import load_robot

    clock = port_clock(port)
    with open_port(port, clock, load_robot(robot_source)) as link:
        board = Board(link, clock)
        info = board.connect()
        end = clock.now_s() + _LISTEN_S
        while clock.now_s() < end:
            board.poll(0.05)
        reading = board.last_reading
        assert reading is not None
        assert board.mode is not None
        return {
            "port": port,
            **asdict(info),
            "catalogue_hash": f"{info.catalogue_hash:08x}",
            "boot_id": f"{info.boot_id:04x}",
            "mode": board.mode.name.lower(),
            "fault": board.fault.name.lower(),
            "holder": f"{board.holder:08x}" if board.holder else None,
            "measured_rad": [round(angle, 6) for angle in reading.measured_rad],
            "applied_rad": [round(angle, 6) for angle in reading.applied_rad],
            "supply": None if board.supply is None else asdict(board.supply),
            "counters": None if board.counters is None else asdict(board.counters),
        }


def show(found: dict[str, Any]) -> None:
    """One line a fact."""
    from math import degrees

    text = dict(found)
    for name in ("measured", "applied"):
        text[f"{name}_deg"] = " ".join(f"{degrees(angle):.2f}" for angle in text.pop(f"{name}_rad"))
    for name in ("supply", "counters"):
        values = text[name]
        text[name] = values and ", ".join(f"{key} {value:g}" for key, value in values.items())
    for name, value in text.items():
        click.echo(f"{name.replace('_', ' '):16} {'-' if value is None else value}")
