"""``snakebot board trim | zero``: what a board stores of each joint."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import click

from snakebot.cli import names
from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.board import Board

_JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
_NEGATIVE = {"ignore_unknown_options": True}  # -2.5 is a number, no option


@click.command(
    "trim",
    context_settings=_NEGATIVE,
    epilog="""\b
Examples:
  snakebot board trim serial:/dev/ttyUSB0 3 1.5
  snakebot board trim serial:/dev/ttyUSB0 3 -2

\b
The joint moves by it when it gets power next. A board keeps its trims over a reset if it can.
""",
)
@click.argument("port", shell_complete=names.ports)
@click.argument("joint", shell_complete=names.joints, type=click.IntRange(min=1))
@click.argument("deg", type=float)
@_JSON
def trim(port: str, joint: int, deg: float, as_json: bool) -> None:
    """Add DEG to every set-point of JOINT before it becomes a servo pulse: a horn that sits beside its middle.

    The board must be disarmed. Angles in commands, logs and readings stay joint angles, without the trim.
    """
    from firmware_protocol.catalogue import MAX_TRIM_RAD

    if not abs(math.radians(deg)) <= MAX_TRIM_RAD:
        raise BadInputError(
            f"{deg:g} deg: a board takes trims of at most {math.degrees(MAX_TRIM_RAD):.1f} deg; turn the horn instead"
        )
    _ask(port, joint, lambda board: board.set_trim(joint, math.radians(deg)))
    _say({"port": port, "joint": joint, "trim_deg": deg}, f"joint {joint}: trim {deg:g} deg", as_json)


@click.command(
    "zero",
    context_settings=_NEGATIVE,
    epilog="""\b
Examples:
  snakebot board zero serial:/dev/ttyUSB0 3 2048
""",
)
@click.argument("port", shell_complete=names.ports)
@click.argument("joint", shell_complete=names.joints, type=click.IntRange(min=1))
@click.argument("counts", type=click.IntRange(-32768, 32767))
@_JSON
def zero(port: str, joint: int, counts: int, as_json: bool) -> None:
    """Make COUNTS of the encoder of JOINT its zero: what it counts when the joint is straight.

    The board must be disarmed. Servos on a bus have their zeros in the robot's description.
    """
    _ask(port, joint, lambda board: board.set_zero(joint, counts))
    _say(
        {"port": port, "joint": joint, "zero_counts": counts}, f"joint {joint}: zero {counts} counts", as_json
    )


def _ask(port: str, joint: int, request: Callable[[Board], None]) -> None:
    """
    Raises:
        BadInputError: no such joint, servos without a board, or a board (sim:) that lives in this command alone and
            would forget it.
        NoBoardError: nobody answers on the port.
        BoardFaultError: the board refuses: it is armed or stopped, or cannot have such a value.
    """
    from snakebot.board import Board
    from snakebot.control.ports import port_clock
    from snakebot.links import open_link
    from snakebot.links.port import ServoPort, parse_port

    if isinstance(parse_port(port), ServoPort):
        raise BadInputError(
            f"{port}: servos on a bus store no trim and no zero; `snakebot robot calibrate {port} --out FILE` writes "
            "where straight is into a copy of the robot's description"
        )
    with open_link(port) as link:
        board = Board(link, port_clock(port))
        info = board.connect()
        if joint > info.joints:
            raise BadInputError(f"{port}: there is no joint {joint}; the board has joints 1 to {info.joints}")
        request(board)


def _say(result: dict[str, object], text: str, as_json: bool) -> None:
    click.echo(json.dumps(result) if as_json else f"{text}, stored by the board on {result['port']}")
