"""From a ``--port`` to an open link."""

from __future__ import annotations

from snakebot.errors import BadInputError
from snakebot.links.base import Link
from snakebot.links.port import Port, SerialPort, ServoPort, SimPort, parse_port


def open_link(port: str | Port, *, onlooker: bool = False) -> Link:
    """Open what a port names.

    ``sim:`` and servo buses are not for this function: the board in front of them lives above the links
    (``snakebot.control.ports`` makes it).

    Args:
        onlooker: who opens it sends no set-points, and wants to hear those of another host.

    Raises:
        BadInputError: the port is not in the grammar, is ``sim:`` or a servo bus.
        NoBoardError: it cannot be opened; the message says what to do.
    """
    parsed = parse_port(port) if isinstance(port, str) else port
    if isinstance(parsed, SimPort):
        raise BadInputError(
            "sim: lives inside the program that uses it; `snakebot board sim --serial` starts one to open"
        )
    if isinstance(parsed, ServoPort):
        raise BadInputError(
            f"{parsed}: servos have no board; `snakebot board serve {parsed} --tcp` puts one in front of them"
        )
    if isinstance(parsed, SerialPort):
        from snakebot.links.serial_link import open_serial

        return open_serial(parsed)
    from snakebot.links.can_link import open_can

    return open_can(parsed, "Onlooker" if onlooker else "Host")
