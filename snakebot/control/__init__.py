"""The run loop: set-points out on absolute deadlines, readings back, and a safe end whatever happens."""

from __future__ import annotations

from snakebot.control.faults import JointFault, parse_fault
from snakebot.control.loop import RunLoop, RunResult
from snakebot.control.progress import Progress

__all__ = ["JointFault", "Progress", "RunLoop", "RunResult", "parse_fault"]
