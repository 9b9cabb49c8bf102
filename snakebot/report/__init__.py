"""Pages people look at: one self-contained HTML file with figures, tables and an animation, that opens
offline.

    page = Page("Run 12", subtitle="penn_state, 2026-11-20") section = page.section("Joints", "Angles over
    the whole run") section.add(Table([Column("joint"), Column("TE", digits=3)], [[1, 0.031], [2, 0.029]]))
    section.add(LineChart("Joint 1", t_s, [Line("measured", angle_deg)], x=Axis("time", "s"),
    y=Axis("angle", "deg"))) page.write(Path("report.html"))

Nothing in here knows a robot, a log or a run. Text and data may come from strangers: it is escaped, and the
page allows no script but its own (content security policy by hash).
"""

from __future__ import annotations

from snakebot.report.answer import Answer, Fall, ToDo
from snakebot.report.blocks import (
    Axis,
    Band,
    BarChart,
    Bars,
    Block,
    Column,
    Curve,
    Explain,
    Facts,
    Line,
    LineChart,
    Note,
    SnakeAnimation,
    SnakeMotion,
    Table,
    XYChart,
)
from snakebot.report.drawing import Drawing
from snakebot.report.page import Page, Section

__all__ = [
    "Answer",
    "Axis",
    "Band",
    "BarChart",
    "Bars",
    "Block",
    "Column",
    "Curve",
    "Drawing",
    "Explain",
    "Facts",
    "Fall",
    "Line",
    "LineChart",
    "Note",
    "Page",
    "Section",
    "SnakeAnimation",
    "SnakeMotion",
    "Table",
    "ToDo",
    "XYChart",
]
