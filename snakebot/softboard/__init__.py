"""A board in software: the same protocol in front of simulated joints and body, or of servos on a bus.

``SoftBoard`` is the board without a wire; ``InProcessLink`` is a wire to it in this process; ``serve`` puts it on a
real one (``PtyEnd``, ``TcpEnd``, or any other link).
"""

from __future__ import annotations

from snakebot.softboard.board import SoftBoard
from snakebot.softboard.ends import PtyEnd, TcpEnd
from snakebot.softboard.inprocess import InProcessLink
from snakebot.softboard.serve import serve

__all__ = ["InProcessLink", "PtyEnd", "SoftBoard", "TcpEnd", "serve"]
