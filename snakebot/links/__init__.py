"""Links to a board: serial, CAN; one small interface."""

from __future__ import annotations

from snakebot.links.base import Link, LinkStatistics
from snakebot.links.opening import open_link
from snakebot.links.port import CanPort, Port, SerialPort, SimPort, parse_port

__all__ = [
    "CanPort",
    "Link",
    "LinkStatistics",
    "Port",
    "SerialPort",
    "SimPort",
    "open_link",
    "parse_port",
]
