"""``snakebot view``: a recorded run, or a board that another program drives, in the browser."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import click

from snakebot.cli import names
from snakebot.cli.robot_option import robot_option
from snakebot.errors import BadInputError, NoBoardError
from snakebot.resources import DEFAULT_ROBOT
from snakebot.view import DEFAULT_PORT, LOOPBACK

EPILOG = """\b
Examples:
  snakebot view runs/REAL.mcap                               a recording
  snakebot view --port serial:socket://127.0.0.1:5555        look on at a board that another program drives
  snakebot view --port can:socketcan/can0
  snakebot run --alpha 66 --beta 80 --omega 2 --view         a run while it goes on

\b
A serial device belongs to one program: on one, look at a run with `snakebot run --view`.
"""

Show = Callable[[Callable[[str], None]], Coroutine[Any, Any, None]]


@click.command(epilog=EPILOG)
@click.argument("log", type=click.Path(path_type=Path), required=False)
@click.option(
    "--port", shell_complete=names.ports, help="Look on at the board there in place of a LOG; STOP stops it."
)
@robot_option("With --port: robot description [penn_state].", default=None)
@click.option(
    "--view-address", "address", default=LOOPBACK, show_default=True, help="Where the page is served."
)
@click.option(
    "--view-port",
    "page_port",
    type=click.IntRange(0, 65535),
    default=DEFAULT_PORT,
    show_default=True,
    help="Port of the page; 0 takes a free one.",
)
def command(
    log: Path | None, port: str | None, robot_source: str | None, address: str, page_port: int
) -> None:
    """Play LOG in a page like that of a live run, or look on at the board on --port, until Ctrl-C.

    Looking on sends nothing: the program that drives the robot does not notice it. STOP in the page is the emergency
    stop, which a board obeys from anyone.
    """
    if (log is None) == (port is None):
        raise BadInputError("give a LOG to play, or --port of a board to look on at")
    token = secrets.token_urlsafe(12)
    if log is not None:
        if robot_source is not None:
            raise BadInputError("--robot goes with --port: a log holds its robot")
        _serve(_recording(log, address, page_port, token), address, page_port)
    else:
        assert port is not None
        _look_on(port, robot_source or DEFAULT_ROBOT, address, page_port, token)


def _recording(log: Path, address: str, page_port: int, token: str) -> Show:
    from snakebot.cli.log import existing
    from snakebot.runlog import read_log
    from snakebot.view.recording import show

    recorded = read_log(existing(log))
    if not len(recorded.t_s):
        raise BadInputError(f"{log}: holds no ticks: there is nothing to show")
    return lambda told: show(recorded, address, page_port, token, told)


def _look_on(port: str, robot_source: str, address: str, page_port: int, token: str) -> None:
    from snakebot.board.onlooker import Onlooker
    from snakebot.clock import MonotonicClock
    from snakebot.links import open_link
    from snakebot.links.port import SimPort, parse_port
    from snakebot.robot import load_robot
    from snakebot.view.onlooking import look_on

    robot = load_robot(robot_source)
    if isinstance(parse_port(port), SimPort):
        raise BadInputError("sim: lives inside its run: `snakebot run --view` shows it")
    try:
        link = open_link(port, onlooker=True)
    except NoBoardError as error:
        if "in use by another program" in str(error):
            raise NoBoardError(
                f"{port}: a run has this port, and no second program can open it: "
                "start that run with `snakebot run --view`"
            ) from None
        raise
    with link:
        board = Onlooker(link, MonotonicClock())
        board.connect()
        board.check_robot(robot)
        _serve(lambda told: look_on(board, robot, address, page_port, token, told), address, page_port)


def _serve(show: Show, address: str, page_port: int) -> None:
    """Serve the page until Ctrl-C."""

    def told(url: str) -> None:
        click.echo(f"page: {url} (Ctrl-C ends)", err=True)

    with contextlib.suppress(KeyboardInterrupt):
        try:
            asyncio.run(show(told))
        except OSError as error:
            raise BadInputError(
                f"{address} port {page_port}: {error.strerror or error}; give another with --view-port"
            ) from None
