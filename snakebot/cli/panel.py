"""The live panel of a run: one screen with time, joints, tracking error, loop, link, and the snake itself."""

from __future__ import annotations

import itertools
import math
import textwrap
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from snakebot.control.progress import Progress, SteeringSoFar

_NARROWEST, _WIDEST = 60, 120  # columns of the panel
_TABLE = 54  # columns of the joints' table without its bars
_BODY = 9  # rows of the body; as many as are left where the terminal is low, none below the fewest
_FEWEST = 3
_LEGEND = "| set  o measured  rms: error so far  TE: rms/amplitude"


def panel(
    progress: Progress,
    title: str,
    foot: str,
    keys: str,
    angle_limit_rad: Sequence[float],
    columns: int,
    rows: int | None = None,
) -> Panel:
    """The panel as it stands now, as wide as the terminal has columns; the body gives way where it has few rows."""
    width = min(max(columns, _NARROWEST), _WIDEST)
    pose, body = progress.pose, len(progress.measured_rad) > 0
    parts: list[RenderableType] = []
    if keys:
        parts.append(Text(keys, style="bold"))
    parts += [
        _time_line(progress, width),
        _joints(progress, angle_limit_rad, width - _TABLE),
        Text(_LEGEND, style="dim"),
        _loop_line(progress),
    ]
    before = len(parts)
    if body and pose is not None:
        parts.append(
            Text(
                f"x {pose.x_m:6.3f} m   y {pose.y_m:6.3f} m   heading {math.degrees(pose.heading_rad):6.1f} deg"
                f"   speed {pose.speed_m_s:6.3f} m/s"
            )
        )
    if progress.steering is not None:
        parts.append(_steering_line(progress.steering))
    if progress.standstill.matters:
        parts.append(Text(str(progress.standstill), style="yellow"))
    if progress.note:
        parts.append(Text(progress.note, style="dim"))
    others = 2 + sum(_height(part, width - 4) for part in parts) + len(progress.measured_rad)
    free = _BODY if rows is None else min(_BODY, rows - others)
    if body and free >= _FEWEST:
        heading_rad = pose.heading_rad if pose is not None else 0.0
        drawn = draw_snake(progress.measured_rad, heading_rad, columns=width // 2 + 6, rows=free)
        parts.insert(before, Text(drawn, style="green"))
    return Panel(Group(*parts), title=title, subtitle=foot, width=width)


def _height(part: RenderableType, width: int) -> int:
    """Lines of a text, wrapped; of a table the first one."""
    if not isinstance(part, Text):
        return 1
    return sum(max(1, len(textwrap.wrap(line, width))) for line in part.plain.split("\n"))


def _time_line(progress: Progress, width: int) -> Table:
    line = Table.grid(padding=(0, 1))
    mode = progress.mode.name.lower() if progress.mode is not None else "-"
    line.add_row(
        f"{progress.t_s:6.1f} s of {progress.duration_s:.1f} s",
        ProgressBar(total=max(progress.duration_s, 1e-9), completed=progress.t_s, width=width - 42),
        Text(mode, style="bold"),
    )
    return line


def _joints(progress: Progress, angle_limit_rad: Sequence[float], bar: int) -> Table:
    table = Table(box=None, padding=(0, 1), header_style="dim")
    for name in ("joint", "set deg", "measured", "", "rms deg", "TE"):
        table.add_column(name, justify="left" if name == "" else "right")
    rms, errors = progress.tracking.rms_rad, progress.tracking.error
    for joint, (wanted, measured) in enumerate(
        zip(progress.setpoint_rad, progress.measured_rad, strict=True)
    ):
        table.add_row(
            str(joint + 1),
            f"{math.degrees(wanted):7.2f}",
            "-" if math.isnan(measured) else f"{math.degrees(measured):7.2f}",
            _bar(wanted, measured, angle_limit_rad[joint], bar),
            "-" if math.isnan(rms[joint]) else f"{math.degrees(rms[joint]):.2f}",
            "-" if math.isnan(errors[joint]) else f"{errors[joint]:.4f}",
        )
    return table


def _bar(wanted: float, measured: float, limit: float, width: int) -> Text:
    """A scale from -limit to +limit with the set-point (|) and the measured angle (o)."""
    cells = list("·" * width)
    cells[width // 2] = "+"
    for angle, mark in ((wanted, "|"), (measured, "o")):
        if not math.isnan(angle):
            cells[min(max(round((angle / limit + 1) / 2 * (width - 1)), 0), width - 1)] = mark
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


def _steering_line(steering: SteeringSoFar) -> Text:
    text = Text("steering   heading error ")
    text.append("-" if math.isnan(steering.error_rad) else f"{math.degrees(steering.error_rad):6.1f} deg")
    if steering.cross_track_m is not None:
        text.append(f"   off the line {steering.cross_track_m:6.3f} m")
    text.append(f"   offset {math.degrees(steering.offset_rad):6.1f} deg")
    if steering.saturated:
        text.append(f"   at its limit {steering.saturated} of {steering.decisions}", style="yellow")
    if steering.stale:
        text.append("   NO POSE: straight", style="red")
    return text


def draw_snake(
    joint_angle_rad: Sequence[float], heading_rad: float, *, columns: int = 44, rows: int = 9
) -> str:
    """The links as braille dots: as large as the body may become in so many characters, whole whichever way it lies."""
    angles = [0.0]
    for joint_angle in joint_angle_rad:
        angles.append(angles[-1] + (0.0 if math.isnan(joint_angle) else joint_angle))
    turn = heading_rad - sum(angles) / len(angles)
    points = [(0.0, 0.0)]
    for angle in angles:
        x, y = points[-1]
        points.append((x + math.cos(angle + turn), y + math.sin(angle + turn)))
    (left, right), (bottom, top) = ((min(line), max(line)) for line in zip(*points, strict=True))
    wide, high = 2 * columns - 1, 4 * rows - 1  # dots between the first and the last
    # Of a steady size while it moves, but what would not fit is drawn smaller.
    scale = min(
        min(wide, 1.6 * high) / len(angles), wide / max(right - left, 1e-9), high / max(top - bottom, 1e-9)
    )
    dots = [[0] * columns for _ in range(rows)]
    for (x0, y0), (x1, y1) in itertools.pairwise(points):
        for step in range(_DOTS_A_LINK + 1):
            share = step / _DOTS_A_LINK
            px = round(wide / 2 + scale * (x0 + share * (x1 - x0) - (left + right) / 2))
            py = round(high / 2 - scale * (y0 + share * (y1 - y0) - (bottom + top) / 2))
            dots[py // 4][px // 2] |= _DOT[py % 4][px % 2]
    return "\n".join("".join(chr(0x2800 + cell) for cell in row) for row in dots)


_DOTS_A_LINK = 60  # along a link; more than the widest panel has
# Bits of the eight dots of a Braille cell, by row and column (Unicode, U+2800).
_DOT = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
