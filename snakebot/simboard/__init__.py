"""A board that is not there: the same protocol in front of simulated joints and a simulated body."""

from __future__ import annotations

from snakebot.simboard.board import SimBoard

__all__ = ["SimBoard"]
