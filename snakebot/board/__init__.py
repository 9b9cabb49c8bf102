"""Client of a board: handshake, modes, set-points out, samples in, clock, faults."""

from __future__ import annotations

from snakebot.board.client import Board
from snakebot.board.faults import LATCHED
from snakebot.board.readings import BoardInfo, OtherHost, PoseReading, Reading, Received
from snakebot.board.setpoints import MadeSetpoint
from snakebot.board.wire_limits import check_limits

__all__ = [
    "LATCHED",
    "Board",
    "BoardInfo",
    "MadeSetpoint",
    "OtherHost",
    "PoseReading",
    "Reading",
    "Received",
    "check_limits",
]
