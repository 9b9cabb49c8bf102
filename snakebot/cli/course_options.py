"""What ``--heading``, ``--line``, ``--pose`` and ``--start`` of ``snakebot run`` say."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.control import RunSettings

MOST_DEG = 360.0  # of a direction that is typed


def steered(
    settings: RunSettings, heading_deg: float | None, line: str | None, pose: str | None
) -> RunSettings:
    """The settings with a course and a pose source, where they are given.

    Raises:
        BadInputError: two courses, or a text that is none.
    """
    if heading_deg is None and line is None and pose is None:
        return settings
    from snakebot.steering import Course, parse_line
    from snakebot.steering.pose_udp import parse_pose_source

    if heading_deg is not None and line is not None:
        raise BadInputError("give --heading or --line, not both")
    course = parse_line(line) if line is not None else None
    if heading_deg is not None:
        if abs(heading_deg) > MOST_DEG:  # a typing error, as in --line and --start
            raise BadInputError(f"--heading {heading_deg:g}: within {MOST_DEG:g} deg")
        course = Course.of_heading(heading_deg)
    return replace(settings, course=course, pose=None if pose is None else parse_pose_source(pose))


def parse_start(text: str | None) -> tuple[float, float, float] | None:
    """``X,Y,DEG`` as m, m, rad.

    Raises:
        BadInputError: no three finite numbers.
    """
    if text is None:
        return None
    try:
        x, y, heading_deg = (float(part) for part in text.split(","))
    except ValueError:
        raise BadInputError(f"--start {text!r}: must be X,Y,DEG, for example 0,0.1,20") from None
    if (
        not all(map(math.isfinite, (x, y, heading_deg)))
        or max(abs(x), abs(y)) > 1e3
        or abs(heading_deg) > MOST_DEG
    ):
        raise BadInputError(f"--start {text}: within 1000 m and {MOST_DEG:g} deg")
    return x, y, math.radians(heading_deg)
