"""From a ``--port`` to an open link."""

from __future__ import annotations

from snakebot.errors import BadInputError
from snakebot.links.base import Link
from snakebot.links.port import Port, SerialPort, SimPort, parse_port


def open_link(port: str | Port) -> Link:
    """Open what a port names.

    ``sim:`` is not for this function: the simulated board lives above the links (``snakebot.cli.ports`` makes it).

    Raises:
        BadInputError: the port is not in the grammar, or is ``sim:``.
        NoBoardError: it cannot be opened; the message says what to do.
    """
    parsed = parse_port(port) if isinstance(port, str) else port
    if isinstance(parsed, SimPort):
        raise BadInputError(
            "sim: lives inside the program that uses it; `snakebot board sim --serial` starts one to open"
        )
    if isinstance(parsed, SerialPort):
        from snakebot.links.serial_link import open_serial

        return open_serial(parsed)
    from snakebot.links.can_link import open_can

    return open_can(parsed)
