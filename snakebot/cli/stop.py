"""``snakebot stop``: the emergency stop from a second terminal."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import click

from snakebot.cli import names
from snakebot.errors import (
    BadInputError,
    BoardFaultError,
    LostBoardError,
    NoBoardError,
    SnakebotError,
)

if TYPE_CHECKING:
    from snakebot.control.registry import RunningRun
    from snakebot.links.port import Port, ServoPort

OBEY_S = 3.0  # a run obeys within a tick, but a computer that swaps may take a while to get there
_LOOK_S = 0.02  # between two looks at whether the runs have ended; chosen


@click.command(
    name="stop",
    epilog="""\b
Examples:
  snakebot stop                               every run on this computer
  snakebot stop --port serial:/dev/ttyUSB0    and whatever board is on that port
  snakebot stop --port can:socketcan/can0     a board on a bus that another computer drives
  snakebot stop --port feetech:/dev/ttyUSB0   every servo on a bus loses its torque
  sudo snakebot stop                          runs of other users, too

\b
Exit status: 0 all have stopped, 2 there was nothing to stop, 3 nobody answered on the port,
5 a run or a board did not obey, or belongs to another user.
""",
)
@click.option("--port", shell_complete=names.ports, help="Also send the emergency stop on this port.")
def command(port: str | None) -> None:
    """Cut the power of all joints now.

    Without --port, every run on this computer is told to stop. With --port, the emergency stop is also sent on that
    port: a board obeys it from anyone, in any state. Each of them is waited for until it has obeyed.

    A stopped board stays stopped until it is asked to clear that very stop: the next run asks when it connects, one
    with --keep-stop does not.
    """
    from snakebot.control import registry

    found = registry.look()
    told = [run for run in found.runs if run.ours and _signal(run)]
    trouble = [
        f"process {run.pid} of {run.user} drives {run.port}: `sudo snakebot stop` stops it"
        for run in found.runs
        if not run.ours
    ]
    trouble += [
        f"process {pid} may be a run, but {path} does not tell: end it yourself, or cut the supply"
        for pid, path in found.unclear.items()
    ]
    error: SnakebotError | None = None
    if port is not None:
        try:
            _stop_port(port, told)
            click.echo(f"stopped the board on {port}")
        except SnakebotError as found_error:
            error = found_error
    trouble += _wait(told)
    for line in trouble:
        click.echo(f"snakebot: {line}", err=True)
    if error is not None:
        raise error
    if trouble:
        raise BoardFaultError("not everything has stopped")
    if port is None and not told:
        raise BadInputError("no run is going on on this computer; give --port to stop a board directly")


def _signal(run: RunningRun) -> bool:
    """False where it has ended by itself just now."""
    from snakebot.control import registry

    try:
        registry.stop(run)
    except ProcessLookupError:
        return False
    return True


def _wait(told: list[RunningRun]) -> list[str]:
    """Wait until the runs have obeyed: they are not registered any more. Returns what is wrong with the others."""
    from snakebot.control import registry

    deadline_s = time.monotonic() + OBEY_S
    left = told
    while True:
        going_on = registry.running()
        for run in [run for run in left if run not in going_on]:
            click.echo(f"stopped the run on {run.port} (process {run.pid})")
        left = [run for run in left if run in going_on]
        if not left or time.monotonic() >= deadline_s:
            break
        time.sleep(_LOOK_S)
    return [
        f"process {run.pid} on {run.port} has not obeyed within {OBEY_S:g} s: cut the robot's supply, or end the "
        f"process (`kill -9 {run.pid}`): the board's watchdog then stops the joints"
        for run in left
    ]


def _stop_port(port: str, told: list[RunningRun]) -> None:
    """
    Raises:
        BadInputError: there is no such port.
        NoBoardError: it cannot be opened, or nobody answers on it.
        BoardFaultError: the board does not obey.
    """
    from snakebot.board.stopping import STOPPING_S
    from snakebot.links import parse_port
    from snakebot.links.port import ServoPort, SimPort

    parsed = parse_port(port)
    if isinstance(parsed, SimPort):
        raise BadInputError("sim: lives inside its run; `snakebot stop` without --port stops it")
    # A run that we have stopped may still have the port open while it closes its log.
    deadline_s = time.monotonic() + (OBEY_S if told else STOPPING_S)
    while True:
        try:
            if isinstance(parsed, ServoPort):
                _relax_servos(parsed)
            else:
                _stop_board(parsed)
            return
        except LostBoardError as error:
            failure = NoBoardError(f"{error}")
        except NoBoardError as error:
            failure = error
            if not told:
                raise
        if time.monotonic() >= deadline_s:
            raise failure from None
        time.sleep(_LOOK_S)


def _stop_board(port: Port) -> None:
    from snakebot.board.stopping import stop_board
    from snakebot.clock import MonotonicClock
    from snakebot.links import open_link

    with open_link(port) as link:
        stop_board(link, MonotonicClock())


def _relax_servos(port: ServoPort) -> None:
    """Take the torque of every servo on a bus: nobody else drives it, or the line would not open."""
    from snakebot.clock import MonotonicClock
    from snakebot.servobus.opening import open_master, stop_servos

    clock = MonotonicClock()
    master = open_master(port, clock)
    try:
        stop_servos(master, clock, port.ids)
    finally:
        master.close()
