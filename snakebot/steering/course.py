"""Where a robot is to go: along a heading, or along a line."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from snakebot.errors import BadInputError

_NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)"
_AXIS = re.compile(rf"(?P<axis>[xy])=(?P<at>{_NUMBER})(?:@(?P<towards>{_NUMBER}))?")
_POINT = re.compile(rf"(?P<x>{_NUMBER}),(?P<y>{_NUMBER})@(?P<towards>{_NUMBER})")
_FARTHEST_M = 1e4  # of a line from the origin; a typing error beyond it
_ALIGNED_RAD = math.radians(0.01)  # a direction given for the line y=0 may be 0 or 180 deg, to this


@dataclass(frozen=True, slots=True)
class Course:
    """A heading to hold; with ``through_m`` the line through that point along the heading.

    The heading is the mean link angle, from the x axis towards the y axis. A gait that drives the robot backwards holds
    the same heading, and goes along the line the other way.
    """

    heading_rad: float
    through_m: tuple[float, float] | None = None

    @classmethod
    def of_heading(cls, heading_deg: float) -> Course:
        """
        Raises:
            BadInputError: no finite number.
        """
        if not math.isfinite(heading_deg):
            raise BadInputError(f"--heading {heading_deg}: must be a finite number of degrees")
        return cls(math.radians(math.remainder(heading_deg, 360.0)))

    def cross_track_m(self, x_m: float, y_m: float) -> float | None:
        """How far to the left of the line a point lies; None where there is no line."""
        if self.through_m is None:
            return None
        dx, dy = x_m - self.through_m[0], y_m - self.through_m[1]
        return math.cos(self.heading_rad) * dy - math.sin(self.heading_rad) * dx

    def along_m(self, x_m: float, y_m: float) -> float:
        """How far along the heading a point lies, from the line's point or from the origin."""
        x0, y0 = self.through_m or (0.0, 0.0)
        return math.cos(self.heading_rad) * (x_m - x0) + math.sin(self.heading_rad) * (y_m - y0)

    def about(self) -> dict[str, float]:
        """As it stands in a log's metadata."""
        about = {"heading_deg": round(math.degrees(self.heading_rad), 9)}
        if self.through_m is not None:
            about["through_x_m"], about["through_y_m"] = self.through_m
        return about

    def __str__(self) -> str:
        heading = f"{math.degrees(self.heading_rad):g} deg"
        if self.through_m is None:
            return f"heading {heading}"
        return f"the line through ({self.through_m[0]:g}, {self.through_m[1]:g}) m along {heading}"


def course_of(about: object) -> Course | None:
    """The course that a log's metadata name; None where they name none (a stranger may have written them)."""
    if not isinstance(about, Mapping):
        return None
    numbers = [about.get(key) for key in ("heading_deg", "through_x_m", "through_y_m")]
    heading, x, y = (
        float(value)
        if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _FARTHEST_M * 10
        else None
        for value in numbers
    )
    if heading is None:
        return None
    return Course(math.radians(heading), None if x is None or y is None else (x, y))


def parse_line(text: str) -> Course:
    """A line: ``y=0`` (towards +x), ``x=1.5`` (towards +y), either with ``@180`` (the other way), ``X,Y@DEG``.

    Raises:
        BadInputError: another text.
    """
    if found := _AXIS.fullmatch(text.strip()):
        usual_deg = 0.0 if found["axis"] == "y" else 90.0
        towards_deg = float(found["towards"]) if found["towards"] else usual_deg
        if abs(math.remainder(towards_deg - usual_deg, 180.0)) > math.degrees(_ALIGNED_RAD):
            raise BadInputError(
                f"--line {text}: that line runs along {usual_deg:g} or {usual_deg - 180:g} deg; "
                "another one is X,Y@DEG, a point and a direction"
            )
        at = float(found["at"])
        point = (0.0, at) if found["axis"] == "y" else (at, 0.0)
    elif found := _POINT.fullmatch(text.strip()):
        towards_deg, point = float(found["towards"]), (float(found["x"]), float(found["y"]))
    else:
        raise BadInputError(f"--line {text!r}: must be like y=0, x=1.5, y=0@180 or 0.5,1@30 (X,Y@DEG)")
    if max(abs(point[0]), abs(point[1])) > _FARTHEST_M or abs(towards_deg) > 360:
        raise BadInputError(f"--line {text}: farther than {_FARTHEST_M:g} m, or a direction beyond 360 deg")
    return Course(math.radians(math.remainder(towards_deg, 360.0)), point)
