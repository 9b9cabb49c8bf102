"""The board's clock seen from the host."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.board.boardclock import BoardClock

WRAP = 1 << 32


@given(st.integers(0, WRAP - 1), st.lists(st.integers(-1000, 60_000_000), max_size=300))
def test_unwrapped_time_follows_the_true_one_over_wraps(start: int, steps: list[int]) -> None:
    clock = BoardClock()
    true = start
    assert clock.unwrap(true % WRAP) == start
    for step in steps:
        true = max(true + step, start)
        assert clock.unwrap(true % WRAP) == true


@pytest.mark.parametrize("drift_ppm", [-500, 0, 37, 500])
def test_offset_and_drift_are_found_through_asymmetric_delays(drift_ppm: float) -> None:
    """One in eight round trips is quick; the others wait up to 20 ms on one leg. Offset within 50 us, drift 20 ppm."""
    rng = random.Random(3)
    clock = BoardClock()
    rate = 1 + drift_ppm * 1e-6
    for k in range(64):
        sent = 100 + 0.1 * k
        out = 2e-4 if k % 8 == 0 else 2e-4 + rng.uniform(0, 0.02)
        board_us = round((sent + out - 40.0) * rate * 1e6)
        clock.round_trip(sent, sent + out + 2e-4, board_us)
    estimate = clock.estimate()
    assert estimate is not None
    offset, drift = estimate
    assert drift == pytest.approx(drift_ppm, abs=20)
    board_s = (106 - 40.0) * rate  # board time when the host's clock shows 106 s
    assert offset + board_s / (1 + drift * 1e-6) == pytest.approx(106, abs=1e-4)
