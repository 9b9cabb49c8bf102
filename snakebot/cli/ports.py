"""Opening what ``--port`` names: the simulated board in this process, or a link to a board elsewhere."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.clock import Clock
    from snakebot.links import Link
    from snakebot.robot import Robot

SIM = "sim:"
_PATIENCE_S = 2.0


@contextlib.contextmanager
def _patience() -> Iterator[None]:
    """Say what is going on when the simulation is compiled: that happens once, and takes some seconds."""
    note = threading.Timer(
        _PATIENCE_S,
        lambda: click.echo("compiling the simulation (only the first start takes this long) ...", err=True),
    )
    note.start()
    try:
        yield
    finally:
        note.cancel()


def open_port(
    port: str,
    clock: Clock,
    robot: Robot,
    effects: Sequence[str] = (),
    seed: int = 0,
    *,
    virtual: bool = False,
) -> Link:
    """A link to the board that ``port`` names; ``sim:`` is one in this process, made for ``robot``.

    Raises:
        BadInputError: the port is not in the grammar, an effect is unknown, or an option that only the simulated
            board understands was given for another one.
        NoBoardError: the port cannot be opened.
    """
    if port == SIM:
        from snakebot.effects import parse_effects
        from snakebot.simboard import InProcessLink, SimBoard

        specs = parse_effects(effects)
        with _patience():
            board = SimBoard(robot, specs, seed)
        return InProcessLink(board, clock)
    if effects:
        raise BadInputError(
            f"--effect changes the simulated board, not the one on {port}: "
            "give it to `snakebot board sim`, or run on --port sim:"
        )
    if virtual:
        raise BadInputError(f"--fast needs virtual time, which only --port sim: has, not {port}")
    from snakebot.links import open_link

    return open_link(port)
