"""Options of the commands that serve a board: where hosts reach it, and what it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import click

from snakebot.cli.typed_options import given


@dataclass(frozen=True)
class BoardOptions:
    """What ``wire_options`` and the further options of every such command say, as they are typed."""

    as_serial: bool
    tcp: str | None
    can: str | None
    symlink: str | None
    robot_source: str
    as_json: bool


@dataclass(frozen=True)
class SimOptions(BoardOptions):
    """What the options of ``snakebot board sim`` say; ``effects``, ``faults`` and ``damage`` in their grammars."""

    feetech: bool
    dynamixel: bool
    model: str | None
    damage: str | None
    effects: tuple[str, ...]
    faults: tuple[str, ...]
    seed: int
    watchdog_ms: int | None


_WIRE_OPTIONS = (
    click.option("--serial", "as_serial", is_flag=True, help="Serve on a serial line (a pseudo-terminal)."),
    click.option(
        "--tcp",
        is_flag=False,
        flag_value="127.0.0.1:0",
        metavar="[HOST:]PORT",
        help="Serve on a TCP port; 0 takes a free one. This computer only, unless HOST says otherwise.",
    ),
    click.option(
        "--can", metavar="INTERFACE/CHANNEL", help="Serve on a CAN bus, or `slcan` on a pseudo-terminal."
    ),
)

symlink_option = click.option(
    "--symlink", type=click.Path(dir_okay=False), help="Also make the pseudo-terminal known by this name."
)


def wire_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options that say where hosts reach the board."""
    return given(command, _WIRE_OPTIONS)
