"""What a page is made of: facts, notes, tables, charts, an animation. Data only; ``page`` turns them into
HTML.

Colours are names of the theme (``command``, ``applied``, ``measured``, ``predicted``, ``error``, ``muted``
and ``series1`` ... ``series8``), so that they fit light and dark.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.report.answer import Answer
from snakebot.report.decimate import bridge_short_gaps, bucket_starts, decimate

NOT_KNOWN = "–"


@dataclass(frozen=True)
class Axis:
    """Name and unit of an axis. ``digits`` is the decimals its data is stored with; ``log`` a logarithmic
    scale."""

    name: str
    unit: str = ""
    digits: int = 3
    log: bool = False

    @property
    def label(self) -> str:
        return f"{self.name} ({self.unit})" if self.unit else self.name

    def spec(self) -> dict[str, Any]:
        return {"label": self.label, "unit": self.unit, "digits": self.digits, "log": self.log}


@dataclass(frozen=True)
class Column:
    """A table column: numbers to so many significant ``digits``, but no more than so many ``decimals``."""

    name: str
    unit: str = ""
    digits: int = 4
    help: str = ""
    decimals: int = 6

    def text(self, value: object) -> str:
        """One cell. What is not known shows as a dash, never as a zero."""
        if value is None or (isinstance(value, float) and not math.isfinite(value)):
            return NOT_KNOWN
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, float):
            return significant(value, self.digits, self.decimals)
        return str(value)


def significant(value: float, digits: int, decimals: int = 6) -> str:
    """``value`` to so many significant digits, but no more decimals than its unit needs."""
    if value == 0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if exponent > 6:
        return f"{value:.{digits - 1}e}"
    text = f"{value:.{min(max(digits - 1 - exponent, 0), decimals)}f}"
    return text.replace("-", "−") if float(text) else "0"


@dataclass(frozen=True)
class Table:
    """Rows of cells under named columns with units. A cell is a number, a text, or ``None`` (not known).

    The first ``keys`` columns say what a row is about: a narrow terminal shows them with every block of the others.
    """

    columns: Sequence[Column]
    rows: Sequence[Sequence[object]]
    caption: str = ""
    keys: int = 1
    kind: str = field(default="table", init=False)

    def texts(self) -> list[list[str]]:
        return [[c.text(v) for c, v in zip(self.columns, row, strict=True)] for row in self.rows]

    def legend(self) -> list[str]:
        """What the abbreviations among the columns' names are; a name in words explains itself, with its tooltip."""
        short = {c.name.split()[0]: c.help for c in self.columns if c.help and c.name.split()[0].isupper()}
        return [f"{name}: {text}" for name, text in short.items() if len(name) > 1]

    def numeric(self) -> list[bool]:
        """Which columns hold numbers, and are set flush right."""
        return [not any(isinstance(row[i], str) for row in self.rows) for i in range(len(self.columns))]


@dataclass(frozen=True)
class Facts:
    """A row of tiles: (name, value with its unit, remark)."""

    tiles: Sequence[tuple[str, str, str]]
    kind: str = field(default="facts", init=False)


@dataclass(frozen=True)
class Note:
    """A paragraph. ``level`` is ``info`` or ``warning``."""

    text: str
    level: str = "info"
    kind: str = field(default="note", init=False)


@dataclass(frozen=True)
class Line:
    """One signal of a line chart, (N,) like the chart's ``x``; ``nan`` breaks the line."""

    name: str
    y: Floats
    color: str = "series1"
    dash: bool = False
    width: float = 1.6
    points: bool = False


@dataclass(frozen=True)
class Band:
    """A stretch of the x axis shown shaded."""

    start: float
    end: float
    label: str = ""


@dataclass(frozen=True)
class LineChart:
    """Signals over one axis: zoom by dragging, all charts of one ``sync`` group together.

    Signals longer than ``points`` are thinned so that the extremes of each stay.
    """

    title: str
    x_values: Floats
    lines: Sequence[Line]
    x: Axis
    y: Axis
    bands: Sequence[Band] = ()
    sync: str = ""
    height: int = 220
    points: int = 2000
    kind: str = field(default="line", init=False)

    def spec(self) -> dict[str, Any]:
        keep = decimate(self.x_values, [line.y for line in self.lines], self.points)
        thinned = len(self.x_values) // max(
            len(bucket_starts(len(self.x_values), len(self.lines), self.points)), 1
        )
        return {
            "kind": self.kind,
            "title": self.title,
            "x": np.round(self.x_values[keep], self.x.digits),
            "lines": [
                {
                    "name": line.name,
                    "y": np.round(bridge_short_gaps(line.y, thinned - 1)[keep], self.y.digits),
                    "color": line.color,
                    "dash": line.dash,
                    "width": line.width,
                    "points": line.points,
                }
                for line in self.lines
            ],
            "xAxis": self.x.spec(),
            "yAxis": self.y.spec(),
            "bands": [{"start": b.start, "end": b.end, "label": b.label} for b in self.bands],
            "sync": self.sync,
            "height": self.height,
        }


@dataclass(frozen=True)
class Curve:
    """One curve or cloud of an x-y chart. ``labels`` name its points one by one."""

    name: str
    x: Floats
    y: Floats
    color: str = "series1"
    mode: str = "line"  # or "points"
    dash: bool = False
    labels: Sequence[str] = ()


@dataclass(frozen=True)
class XYChart:
    """Curves in a plane. ``equal`` gives both axes one scale, ``diagonal`` draws y = x."""

    title: str
    curves: Sequence[Curve]
    x: Axis
    y: Axis
    equal: bool = False
    diagonal: bool = False
    height: int = 260
    points: int = 600
    kind: str = field(default="xy", init=False)

    def spec(self) -> dict[str, Any]:
        curves = []
        for curve in self.curves:
            every = max(1, math.ceil(len(curve.x) / self.points))
            curves.append(
                {
                    "name": curve.name,
                    "x": np.round(curve.x[::every], self.x.digits),
                    "y": np.round(curve.y[::every], self.y.digits),
                    "color": curve.color,
                    "mode": curve.mode,
                    "dash": curve.dash,
                    "labels": list(curve.labels[::every]),
                }
            )
        return {
            "kind": self.kind,
            "title": self.title,
            "curves": curves,
            "xAxis": self.x.spec(),
            "yAxis": self.y.spec(),
            "equal": self.equal,
            "diagonal": self.diagonal,
            "height": self.height,
        }


@dataclass(frozen=True)
class Bars:
    """One value a category; ``low`` and ``high`` are the ends of its interval, where there is one."""

    name: str
    values: Sequence[float | None]
    color: str = "series1"
    low: Sequence[float | None] = ()
    high: Sequence[float | None] = ()


@dataclass(frozen=True)
class BarChart:
    """Horizontal bars, a group a category: shares, probabilities, scores."""

    title: str
    categories: Sequence[str]
    bars: Sequence[Bars]
    x: Axis
    kind: str = field(default="bars", init=False)

    @property
    def height(self) -> int:
        return 34 + len(self.categories) * (10 + 18 * max(len(self.bars), 1))

    def spec(self) -> dict[str, Any]:
        return {
            "kind": self.kind,
            "title": self.title,
            "categories": list(self.categories),
            "bars": [
                {
                    "name": bar.name,
                    "values": list(bar.values),
                    "color": bar.color,
                    "low": list(bar.low),
                    "high": list(bar.high),
                }
                for bar in self.bars
            ],
            "xAxis": self.x.spec(),
            "height": self.height,
        }


@dataclass(frozen=True)
class SnakeMotion:
    """One snake of an animation, (T,) and (T, joints): centre of mass in m, mean link angle and joint
    angles in rad."""

    name: str
    x_m: Floats
    y_m: Floats
    heading_rad: Floats
    joint_angle_rad: Floats
    half_length_m: float
    color: str = "measured"


@dataclass(frozen=True)
class SnakeAnimation:
    """Bodies moving over ground, to play, pause and scrub; all at the same times (T,)."""

    title: str
    t_s: Floats
    snakes: Sequence[SnakeMotion]
    caption: str = ""
    frames: int = 1500
    height: int = 340
    kind: str = field(default="snake", init=False)

    def spec(self) -> dict[str, Any]:
        count = min(self.frames, len(self.t_s), max(2, int((self.t_s[-1] - self.t_s[0]) * 30)))
        keep = np.unique(np.searchsorted(self.t_s, np.linspace(self.t_s[0], self.t_s[-1], count)))
        keep = keep[keep < len(self.t_s)]
        return {
            "kind": self.kind,
            "title": self.title,
            "t": np.round(self.t_s[keep], 3),
            "snakes": [
                {
                    "name": s.name,
                    "color": s.color,
                    "halfLength": s.half_length_m,
                    "x": np.round(s.x_m[keep], 4),
                    "y": np.round(s.y_m[keep], 4),
                    "heading": np.round(s.heading_rad[keep], 4),
                    "joints": np.round(s.joint_angle_rad[keep], 3),
                }
                for s in self.snakes
            ],
            "height": self.height,
        }


Chart = LineChart | XYChart | BarChart | SnakeAnimation


@dataclass(frozen=True)
class Explain:
    """A heading and some paragraphs, each perhaps with a name in front."""

    title: str
    parts: Sequence[tuple[str, str]]
    kind: str = field(default="explain", init=False)


Block = Answer | Explain | Facts | Note | Table | Chart
