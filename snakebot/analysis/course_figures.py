"""The figures of a run that held a course: path and line, heading error, offset."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from snakebot.analysis.figures import TIME, steady_band
from snakebot.report import Axis, Curve, Line, LineChart, XYChart
from snakebot.steering.course import course_of

if TYPE_CHECKING:
    from snakebot.analysis.run_analysis import RunAnalysis

_BEYOND_M = 0.2  # that the line is drawn beyond both ends of the path; chosen


def charts(run: RunAnalysis, points: int) -> list[LineChart | XYChart]:
    """Path beside the line, and what the steering saw and did; nothing of a run without a course."""
    course = course_of(run.run.metadata.get("course"))
    if course is None:
        return []
    found: list[LineChart | XYChart] = []
    pose = run.run.pose
    if pose is not None and np.isfinite(pose[:, :2]).all(axis=1).any():
        known = np.isfinite(pose[:, :2]).all(axis=1)
        x, y = pose[known, 0], pose[known, 1]
        curves = [Curve("centre of mass", x, y, "measured")]
        if course.through_m is not None:
            along = np.array([course.along_m(a, b) for a, b in zip(x.tolist(), y.tolist(), strict=True)])
            ends = np.array([along.min() - _BEYOND_M, along.max() + _BEYOND_M])
            x0, y0 = course.through_m
            line = x0 + ends * np.cos(course.heading_rad), y0 + ends * np.sin(course.heading_rad)
            curves.append(Curve("line", *line, "command", dash=True))
        found.append(XYChart("Path", curves, Axis("x", "m"), Axis("y", "m"), equal=True, points=points))
    extra = run.run.extra
    for title, name, axis, scale in (
        ("Heading error", "heading_error_rad", Axis("error", "deg", 2), 180 / np.pi),
        ("Distance from the line", "cross_track_m", Axis("left of it", "m", 4), 1.0),
        ("Steering offset", "steering_offset_rad", Axis("offset", "deg", 2), 180 / np.pi),
    ):
        if name in extra:
            values = scale * np.asarray(extra[name], dtype=np.float64)
            found.append(
                LineChart(title, run.run.t_s, [Line(title.lower(), values)], TIME, axis, steady_band(run),
                          sync=run.name, points=points)
            )  # fmt: skip
    return found
