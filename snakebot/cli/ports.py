"""Opening what ``--port`` names: the simulated board in this process, or a link to a board elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.clock import Clock
    from snakebot.links import Link
    from snakebot.robot import Robot

SIM = "sim:"


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

        return InProcessLink(SimBoard(robot, parse_effects(effects), seed), clock)
    if effects:
        raise BadInputError(
            f"--effect changes the simulated board, not the one on {port}: "
            "give it to `snakebot board sim`, or run on --port sim:"
        )
    if virtual:
        raise BadInputError(f"--fast needs virtual time, which only --port sim: has, not {port}")
    from snakebot.links import open_link

    return open_link(port)
