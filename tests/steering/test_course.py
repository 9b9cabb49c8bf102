"""A course as it is typed, and where a point lies beside it."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.errors import BadInputError
from snakebot.steering import Course, parse_line
from snakebot.steering.course import course_of

NUMBERS = st.floats(-100, 100)


@pytest.mark.parametrize(
    ("text", "heading_deg", "through"),
    [
        ("y=0", 0, (0, 0)),
        ("y=-0.5", 0, (0, -0.5)),
        ("y=1@180", 180, (0, 1)),
        ("x=1.5", 90, (1.5, 0)),
        ("x=2@-90", -90, (2, 0)),
        ("0.5,1@30", 30, (0.5, 1)),
    ],
)
def test_a_line_as_it_is_typed(text: str, heading_deg: float, through: tuple[float, float]) -> None:
    course = parse_line(text)
    assert math.degrees(course.heading_rad) == pytest.approx(heading_deg)
    assert course.through_m == through


@pytest.mark.parametrize(
    "text", ["", "y", "y=", "z=1", "y=0@45", "1,2", "1,2@", "y=nan", "1e9,0@0", "y=99999", "0,0@999"]
)
def test_what_is_no_line_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(BadInputError) as refused:
        parse_line(text)
    assert str(refused.value).startswith("--line")
    assert "\n" not in str(refused.value)


@given(st.text(max_size=30))
def test_any_text_is_a_line_or_refused(text: str) -> None:
    try:
        course = parse_line(text)
    except BadInputError:
        return
    assert course.through_m is not None


@given(NUMBERS, NUMBERS, st.floats(-180, 180), NUMBERS, NUMBERS)
def test_along_and_aside_are_a_point_in_the_lines_own_frame(
    x0: float, y0: float, deg: float, along: float, aside: float
) -> None:
    course = Course(math.radians(deg), (x0, y0))
    x = x0 + along * math.cos(course.heading_rad) - aside * math.sin(course.heading_rad)
    y = y0 + along * math.sin(course.heading_rad) + aside * math.cos(course.heading_rad)
    assert course.cross_track_m(x, y) == pytest.approx(aside, abs=1e-9)
    assert course.along_m(x, y) == pytest.approx(along, abs=1e-9)


@pytest.mark.parametrize("course", [Course.of_heading(30), parse_line("0.5,1@30"), parse_line("x=1")])
def test_a_log_says_its_course(course: Course) -> None:
    again = course_of(course.about())
    assert again is not None
    assert again.heading_rad == pytest.approx(course.heading_rad)
    assert again.through_m == course.through_m


@pytest.mark.parametrize(
    "about", [None, 3, {}, {"heading_deg": "0"}, {"heading_deg": math.nan}, {"heading_deg": True}]
)
def test_what_a_stranger_wrote_is_no_course(about: object) -> None:
    assert course_of(about) is None


def test_a_heading_is_within_half_a_turn() -> None:
    assert math.degrees(Course.of_heading(370).heading_rad) == pytest.approx(10)
    with pytest.raises(BadInputError, match="--heading"):
        Course.of_heading(math.inf)
