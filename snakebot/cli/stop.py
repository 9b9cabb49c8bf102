"""``snakebot stop``: the emergency stop from a second terminal."""

from __future__ import annotations

import click

from snakebot.errors import BadInputError, SnakebotError


@click.command(
    name="stop",
    epilog="""\b
Examples:
  snakebot stop                               every run on this computer
  snakebot stop --port serial:/dev/ttyUSB0    and whatever board is on that port
  snakebot stop --port can:socketcan/can0     a board on a bus that another computer drives
""",
)
@click.option("--port", help="Also send the emergency stop on this port.")
def command(port: str | None) -> None:
    """Cut the power of all joints now.

    Without --port, every run on this computer is told to stop. With --port, the emergency stop is also sent on that
    port: a board obeys it from anyone, in any state. It stays stopped until the next run disarms it.
    """
    from snakebot.control import registry

    runs = registry.running()
    stopped = 0
    for run in runs:
        try:
            registry.stop(run)
        except OSError as error:
            click.echo(f"snakebot: process {run.pid} on {run.port}: {error.strerror}", err=True)
            continue
        stopped += 1
        click.echo(f"stopped the run on {run.port} (process {run.pid})")
    if port is not None:
        _stop_port(port, anything_else=stopped > 0)
    elif not stopped:
        raise BadInputError("no run is going on on this computer; give --port to stop a board directly")


def _stop_port(port: str, anything_else: bool) -> None:
    from snakebot.board import Board
    from snakebot.clock import MonotonicClock
    from snakebot.links import open_link

    if port.startswith("sim:"):
        raise BadInputError("sim: lives inside its run; `snakebot stop` without --port stops it")
    try:
        link = open_link(port)
    except SnakebotError:
        if anything_else:  # the run that we have just stopped holds the port
            return
        raise
    try:
        Board(link, MonotonicClock()).emergency_stop()
        link.receive(0.05)  # let the last bytes leave before the port closes
    finally:
        link.close()
    click.echo(f"sent the emergency stop on {port}")
