"""How often a set-point is sent at once: rarely too few, never more than the line carries."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from snakebot.control.copies import Copies, needed, ticks_to_trip


@pytest.mark.parametrize(("rate_hz", "ticks"), [(20, 1), (25, 2), (40, 3), (50, 4), (100, 9), (1000, 99)])
def test_ticks_until_the_watchdog_trips(rate_hz: float, ticks: int) -> None:
    assert ticks_to_trip(1 / rate_hz) == ticks


@settings(deadline=None)
@given(st.floats(0.001, 0.3), st.integers(2, 7), st.integers(1, 99))
def test_the_watchdog_trips_rarely_and_no_copy_is_too_many(share: float, frames: int, ticks: int) -> None:
    def trips(copies: int) -> float:
        return float((1 - (1 - share**copies) ** frames) ** ticks)

    copies = needed(share, frames, ticks)
    assert trips(copies) < 1e-6 or copies == 12
    assert copies == 1 or trips(copies - 1) >= 1e-6


def test_more_copies_for_a_while_after_a_loss() -> None:
    copies = Copies(0.01, 5, 7700)
    assert copies.number(0.0) == 1
    copies.lost(1.0)
    assert [copies.number(t_s) for t_s in (1.0, 2.9, 3.1)] == [2, 2, 1]


@settings(deadline=None)
@given(st.floats(20, 1000), st.integers(1, 16), st.floats(80, 10_000))
def test_copies_do_not_fill_the_line(rate_hz: float, joints: int, line_frames_per_s: float) -> None:
    copies = Copies(1 / rate_hz, joints, line_frames_per_s)
    copies.lost(0.0)
    frames = -(-joints // 3) + 1
    assert copies.number(0.0) == 1 or copies.number(0.0) * frames * rate_hz < 0.7 * line_frames_per_s
