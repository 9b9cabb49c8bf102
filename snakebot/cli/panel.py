"""The live panel of a run: one screen with time, joints, tracking error, loop, link, and the snake itself."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from snakebot.control.progress import Progress

_BAR = 21  # characters of a joint's bar
_CANVAS = (44, 9)  # characters of the drawing


def panel(progress: Progress, title: str, port: str, angle_limit_rad: Sequence[float]) -> Panel:
    """The panel as it stands now."""
    parts: list[RenderableType] = [
        _time_line(progress),
        _joints(progress, angle_limit_rad),
        _loop_line(progress),
    ]
    if progress.pose is not None and len(progress.measured_rad):
        parts.append(Text(draw_snake(progress.measured_rad, progress.pose.heading_rad), style="green"))
        pose = progress.pose
        parts.append(
            Text(
                f"x {pose.x_m:6.3f} m   y {pose.y_m:6.3f} m   heading {math.degrees(pose.heading_rad):6.1f} deg"
                f"   speed {pose.speed_m_s:6.3f} m/s"
            )
        )
    if progress.note:
        parts.append(Text(progress.note, style="dim"))
    return Panel(Group(*parts), title=title, subtitle=port, width=78)


def _time_line(progress: Progress) -> Table:
    line = Table.grid(padding=(0, 1))
    mode = progress.mode.name.lower() if progress.mode is not None else "-"
    line.add_row(
        f"{progress.t_s:6.1f} s of {progress.duration_s:.1f} s",
        ProgressBar(total=max(progress.duration_s, 1e-9), completed=progress.t_s, width=36),
        Text(mode, style="bold"),
    )
    return line


def _joints(progress: Progress, angle_limit_rad: Sequence[float]) -> Table:
    table = Table(box=None, padding=(0, 1), header_style="dim")
    for name in ("joint", "set deg", "measured", "", "TE"):
        table.add_column(name, justify="left" if name == "" else "right")
    errors = progress.tracking.error
    for joint, (wanted, measured) in enumerate(
        zip(progress.setpoint_rad, progress.measured_rad, strict=True)
    ):
        table.add_row(
            str(joint + 1),
            f"{math.degrees(wanted):7.2f}",
            "-" if math.isnan(measured) else f"{math.degrees(measured):7.2f}",
            _bar(wanted, measured, angle_limit_rad[joint]),
            "-" if math.isnan(errors[joint]) else f"{errors[joint]:.4f}",
        )
    return table


def _bar(wanted: float, measured: float, limit: float) -> Text:
    """A scale from -limit to +limit with the set-point (|) and the measured angle (o)."""
    cells = list("·" * _BAR)
    cells[_BAR // 2] = "+"
    for angle, mark in ((wanted, "|"), (measured, "o")):
        if not math.isnan(angle):
            cells[min(max(round((angle / limit + 1) / 2 * (_BAR - 1)), 0), _BAR - 1)] = mark
    return Text("".join(cells))


def _loop_line(progress: Progress) -> Text:
    rate, trip = progress.rate_hz, progress.round_trip_s
    text = Text()
    text.append("rate " + ("-" if math.isnan(rate) else f"{rate:.1f} Hz"))
    text.append("   round trip " + ("-" if math.isnan(trip) else f"{trip * 1e3:.2f} ms"))
    text.append(f"   late {progress.late}", style="yellow" if progress.late else "")
    text.append(f"   skipped {progress.skipped}", style="red" if progress.skipped else "")
    text.append(f"   lost {progress.lost}", style="red" if progress.lost else "")
    if progress.supply is not None:
        text.append(f"   supply {progress.supply.voltage_v:.2f} V")
    return text


def draw_snake(joint_angle_rad: Sequence[float], heading_rad: float) -> str:
    """The links as braille dots, head to the right of the heading's direction, scaled to the canvas."""
    known = [0.0 if math.isnan(angle) else angle for angle in joint_angle_rad]
    angles = [0.0]
    for joint_angle in known:
        angles.append(angles[-1] + joint_angle)
    turn = heading_rad - sum(angles) / len(angles)
    points = [(0.0, 0.0)]
    for angle in angles:
        x, y = points[-1]
        points.append((x + math.cos(angle + turn), y + math.sin(angle + turn)))
    mean_x = sum(x for x, _ in points) / len(points)
    mean_y = sum(y for _, y in points) / len(points)
    columns, rows = _CANVAS
    scale = min(2 * columns, 4 * rows * 1.6) / (len(angles) + 0.5)
    dots = [[0] * columns for _ in range(rows)]
    for (x0, y0), (x1, y1) in itertools.pairwise(points):
        for step in range(41):
            share = step / 40
            px = round(columns + scale * (x0 + share * (x1 - x0) - mean_x))
            py = round(2 * rows - scale * (y0 + share * (y1 - y0) - mean_y))
            if 0 <= px < 2 * columns and 0 <= py < 4 * rows:
                dots[py // 4][px // 2] |= _DOT[py % 4][px % 2]
    return "\n".join("".join(chr(0x2800 + cell) for cell in row) for row in dots)


_DOT = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
