"""Options of every command that moves a robot: what disturbs it, what is written down, what is asked for first."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])

_OPTIONS = (
    click.option("--frames", is_flag=True, help="Also log every frame of the wire."),
    click.option(
        "--fault",
        "faults",
        multiple=True,
        help="Joint fault, e.g. free:3, rigid:4+5, rigid:4@12s, clear@20s.",
    ),
    click.option(
        "--effect",
        "effects",
        multiple=True,
        help="Unmodelled effect on the simulated board: NAME:param=value.",
    ),
    click.option(
        "--speed", type=float, help="Forward speed that you measured, m/s; stored with the new log."
    ),
    click.option("--note", help="Anything worth remembering; stored with the new log."),
    click.option(
        "--seed",
        type=click.IntRange(min=0),
        default=0,
        show_default=True,
        help="Of the simulated board's randomness.",
    ),
    click.option("--fast", is_flag=True, help="Simulated board only: virtual time, as fast as it computes."),
    click.option(
        "--dry-run", is_flag=True, help="Check the limits and say what would be done; open nothing."
    ),
    click.option(
        "--keep-stop",
        is_flag=True,
        help="Move nothing where the board is found stopped or in a fault (for scripts).",
    ),
    click.option("--yes", is_flag=True, help="Do not ask before a real robot moves."),
    click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object."),
)


def run_options(command: Command) -> Command:
    """Give a command these options, in this order in its help."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command
