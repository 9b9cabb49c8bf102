"""Links to a board: serial, CAN; one small interface."""

from __future__ import annotations

from snakebot.links.base import Link, LinkStatistics

__all__ = ["Link", "LinkStatistics"]
