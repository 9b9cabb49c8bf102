"""The live panel in terminals of every width: keys first and whole, a line a joint, the body drawn whole."""

from __future__ import annotations

import io
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from firmware_protocol.catalogue import Mode
from snakebot.board import PoseReading
from snakebot.cli.keys import shown
from snakebot.cli.panel import draw_snake, panel
from snakebot.control.progress import Progress, SteeringSoFar, TrackingSoFar
from snakebot.gait import Gait

GAIT = Gait.from_degrees(66, 80, 2)
BLANK = "\u2800"


def moving(joints: int, *, pose: bool) -> Progress:
    progress = Progress(600.0, TrackingSoFar(joints, 1.0), t_s=123.4, mode=Mode.ARMED)
    progress.setpoint_rad = [math.sin(joint) for joint in range(joints)]
    progress.measured_rad = [math.sin(joint - 0.2) for joint in range(joints)]
    progress.tracking.add(progress.setpoint_rad, progress.measured_rad)
    progress.late, progress.skipped, progress.lost = 12, 3, 44
    progress.round_trips_s.append(0.00123)
    if pose:
        progress.pose = PoseReading(0, 12.1, -3.3, 1.57, 0.1)
        progress.steering = SteeringSoFar(0.1, 0.02, 0.1, 100, 50, True)
    return progress


def lines_of(progress: Progress, columns: int) -> list[str]:
    joints = len(progress.measured_rad)
    console = Console(file=io.StringIO(), width=columns, force_terminal=False)
    console.print(panel(progress, str(GAIT), "sim:", shown(GAIT), [1.6] * joints, columns))
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue().splitlines()


@pytest.mark.parametrize("joints", [1, 5, 16])
@pytest.mark.parametrize("pose", [True, False])
@pytest.mark.parametrize("columns", [60, 72, 80, 99, 120])
def test_the_panel_is_as_wide_as_the_terminal_and_nothing_in_it_is_cut(
    columns: int, pose: bool, joints: int
) -> None:
    lines = lines_of(moving(joints, pose=pose), columns)
    assert {len(line) for line in lines} == {columns}
    assert "space bar EMERGENCY STOP   q ramp down" in lines[1]
    assert "a/A alpha down/up   b/B beta   w/W omega   o/O offset" in lines[2]
    assert "armed" in lines[3]
    assert "123.4 s of 600.0 s" in lines[3]
    text = "\n".join(lines)
    assert "…" not in text
    assert "TE: rms/amplitude" in text  # the legend, in one line
    rows = [line.split() for line in lines[5 : 5 + joints]]
    assert [row[1] for row in rows] == [str(joint + 1) for joint in range(joints)]
    assert all("o" in row[4] for row in rows)
    assert any(BLANK < character <= "\u28ff" for character in text)  # the body


@pytest.mark.parametrize("rows", [18, 20, 24, 30])
def test_in_a_low_terminal_the_body_gives_way_and_every_line_stays(rows: int) -> None:
    progress = moving(5, pose=True)
    progress.note = "joints powered where they are"
    console = Console(file=io.StringIO(), width=80, force_terminal=False)
    foot = "page: http://127.0.0.1:8040/   sim:"
    console.print(panel(progress, str(GAIT), foot, shown(GAIT), [1.6] * 5, 80, rows))
    assert isinstance(console.file, io.StringIO)
    lines = console.file.getvalue().splitlines()
    assert len(lines) <= rows
    text = "\n".join(lines)
    assert "heading error" in text
    assert progress.note in text
    assert foot in lines[-1]
    assert any(BLANK < character <= "\u28ff" for character in text) == (rows > 19)


def test_beyond_the_widest_it_stays_so_and_in_a_narrow_one_the_stop_is_still_read() -> None:
    assert {len(line) for line in lines_of(moving(5, pose=True), 200)} == {120}
    assert "space bar EMERGENCY STOP" in lines_of(moving(5, pose=True), 40)[1]


@given(st.lists(st.floats(-1.6, 1.6) | st.just(math.nan), min_size=1, max_size=16), st.floats(-7, 7))
def test_any_body_is_drawn_in_its_place(angles: list[float], heading_rad: float) -> None:
    rows = draw_snake(angles, heading_rad).split("\n")
    assert {len(row) for row in rows} == {44}
    assert len(rows) == 9
    assert any(row.strip(BLANK) for row in rows)


@pytest.mark.parametrize("bent", ["first", "last"])
@pytest.mark.parametrize("joints", [2, 5, 16])
def test_a_body_that_lies_upright_is_seen_to_both_ends(joints: int, bent: str) -> None:
    """Its first or last link lies across: at the end of the drawing there is a stroke from side to side."""
    angles = [0.0] * joints
    angles[0 if bent == "first" else -1] = math.pi / 2
    links = [sum(angles[:link]) for link in range(joints + 1)]
    upright = math.pi / 2 - links[joints // 2]
    rows = draw_snake(angles, upright + sum(links) / len(links), columns=60, rows=12).split("\n")
    strokes = [len(row.replace(BLANK, "")) for row in rows]
    assert strokes[-1 if bent == "first" else 0] > 1
    assert min(strokes) > 0
