"""Client of a board: handshake, modes, set-points out, samples in, clock, faults."""

from __future__ import annotations

from snakebot.board.client import Board
from snakebot.board.limits import check_limits
from snakebot.board.readings import BoardInfo, Pose, Reading, Received

__all__ = ["Board", "BoardInfo", "Pose", "Reading", "Received", "check_limits"]
