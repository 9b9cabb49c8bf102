"""A course held: where the robot is to go, what its gait's offset does to it, and the law between the two.

Poses come in, offsets go out; nothing here knows a board or a run. ``snakebot.control.guiding`` joins them to a run.
"""

from __future__ import annotations

from snakebot.steering.course import Course, parse_line

__all__ = ["Course", "parse_line"]
