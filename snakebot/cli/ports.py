"""``--port`` on the command line: as ``snakebot.control.ports``, and a word where the first start takes long."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from snakebot.control.ports import SIM

if TYPE_CHECKING:
    from snakebot.clock import Clock
    from snakebot.links import Link
    from snakebot.robot import Robot

__all__ = ["SIM", "open_port", "patience"]

_PATIENCE_S = 2.0  # before it is told why nothing happens; chosen
_LOOK_S = 0.1  # then so long between two looks whether anything is compiled


@contextlib.contextmanager
def patience(port: str) -> Iterator[None]:
    """Say what is going on when the simulation is compiled: that happens once, and takes some seconds.

    A start that takes as long for another reason, as on a busy computer, is not told of.
    """
    done = threading.Event()

    def watch() -> None:
        wait_s = _PATIENCE_S
        while not done.wait(wait_s):
            wait_s = _LOOK_S
            if _compiles():
                click.echo("compiling the simulation (only the first start takes this long) ...", err=True)
                return

    if port == SIM:
        threading.Thread(target=watch, name="patience", daemon=True).start()
    try:
        yield
    finally:
        done.set()


def _compiles() -> bool:
    compiled = sys.modules.get("snakebot.physics.compiled")  # who compiles has imported it
    return compiled is not None and bool(getattr(compiled, "compiles", bool)())


def open_port(port: str, clock: Clock, robot: Robot) -> Link:
    """``snakebot.control.ports.open_port``, which raises the same."""
    from snakebot.control import ports

    with patience(port):
        return ports.open_port(port, clock, robot)
