"""A board that is not there: the same protocol in front of simulated joints and a simulated body.

``SimBoard`` is the board without a wire; ``InProcessLink`` is a wire to it in this process; ``serve`` puts it on a real
one (``PtyEnd``, ``TcpEnd``, or any other link).
"""

from __future__ import annotations

from snakebot.simboard.board import SimBoard
from snakebot.simboard.ends import PtyEnd, TcpEnd
from snakebot.simboard.inprocess import InProcessLink
from snakebot.simboard.serve import serve

__all__ = ["InProcessLink", "PtyEnd", "SimBoard", "TcpEnd", "serve"]
