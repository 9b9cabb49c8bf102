"""How often a set-point is sent at once: rarely too few, never more than the line carries."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from snakebot.control.copies import Copies, needed, ticks_to_trip
from snakebot.errors import BadInputError


@pytest.mark.parametrize(("rate_hz", "ticks"), [(20, 1), (25, 2), (40, 3), (50, 4), (100, 9), (1000, 99)])
def test_ticks_until_the_watchdog_trips(rate_hz: float, ticks: int) -> None:
    assert ticks_to_trip(1 / rate_hz, 0.1) == ticks
    assert ticks_to_trip(2 / rate_hz, 0.2) == ticks  # what counts is the watchdog of this board


def test_a_board_with_an_impatient_watchdog_gets_more_copies() -> None:
    copies = [Copies(0.01, 5, 7700, watchdog_s) for watchdog_s in (0.03, 0.1)]
    for each in copies:
        each.lost(0.0)
    impatient, usual = (each.number(0.0) for each in copies)
    assert impatient > usual


@settings(deadline=None)
@given(st.floats(0.001, 0.3), st.integers(2, 7), st.integers(1, 99))
def test_the_watchdog_trips_rarely_and_no_copy_is_too_many(share: float, frames: int, ticks: int) -> None:
    def trips(copies: int) -> float:
        return float((1 - (1 - share**copies) ** frames) ** ticks)

    copies = needed(share, frames, ticks)
    assert trips(copies) < 1e-6 or copies == 12
    assert copies == 1 or trips(copies - 1) >= 1e-6


def test_more_copies_for_a_while_after_a_loss() -> None:
    copies = Copies(0.01, 5, 7700, 0.1)
    assert copies.number(0.0) == 1
    copies.lost(1.0)
    assert [copies.number(t_s) for t_s in (1.0, 2.9, 3.1)] == [2, 2, 1]


@settings(deadline=None)
@given(st.floats(20, 1000), st.integers(1, 16), st.floats(80, 10_000))
def test_set_points_keep_within_half_of_the_line_or_are_refused(
    rate_hz: float, joints: int, line_frames_per_s: float
) -> None:
    try:
        copies = Copies(1 / rate_hz, joints, line_frames_per_s, 0.1)
    except BadInputError:
        assume(False)
    copies.lost(0.0)
    frames = -(-joints // 3) + 1
    assert copies.number(0.0) * frames * rate_hz <= 0.5 * line_frames_per_s * (1 + 1e-6)


def test_a_bus_of_125_kbit_gets_as_many_copies_as_fit() -> None:
    """135 bit times a frame: 926 frames/s, of which 463 are for set-points; two copies of 3 frames would be 600."""
    copies = Copies(0.01, 5, 125_000 / 135, 0.1)
    copies.lost(0.0)
    assert (copies.number(0.0), copies.wanted_on_a_bad_line) == (1, 2)
    wide = Copies(0.01, 5, 1_000_000 / 135, 0.1)
    wide.lost(0.0)
    assert wide.number(0.0) == 2


def test_a_line_that_is_too_slow_is_refused_with_the_figures_and_a_rate_that_fits() -> None:
    with pytest.raises(BadInputError) as refused:
        Copies(1 / 200, 5, 125_000 / 135, 0.1, "can:socketcan/can0")
    text = str(refused.value)
    assert "--rate 200: set-points of 5 joints take 600 frames/s, and can:socketcan/can0 carries 926" in text
    assert "give 154 Hz or less" in text
    Copies(1 / 154, 5, 125_000 / 135, 0.1)
    with pytest.raises(BadInputError, match="needs a faster line"):
        Copies(1 / 20, 5, 9600 / 150, 0.1)


def test_a_line_without_a_limit_limits_nothing() -> None:
    copies = Copies(0.05, 16, math.inf, 0.1)
    copies.lost(0.0)
    assert copies.number(0.0) == copies.wanted_on_a_bad_line > 1
