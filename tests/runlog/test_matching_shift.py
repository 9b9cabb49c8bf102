"""Two recordings of one motion are brought together to a fraction of a sample."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from snakebot.arrays import Floats
from snakebot.runlog.matching.shift import find_shift, shifted


def times(duration_s: float = 20.0, rate_hz: float = 100.0, jitter_s: float = 0.0, seed: int = 0) -> Floats:
    t = np.arange(0, duration_s, 1 / rate_hz)
    return np.sort(t + np.random.default_rng(seed).uniform(-jitter_s, jitter_s, len(t)))


def motion(t: Floats, joints: int = 2) -> Floats:
    ramp = np.clip(t / 2, 0, 1) * np.clip((14 - t) / 2, 0, 1)
    return ramp[:, None] * np.sin(2.3 * t[:, None] + np.arange(joints))


@settings(deadline=None, max_examples=10)
@given(shift=st.floats(-4, 4), rate=st.sampled_from([50.0, 73.0, 100.0]), seed=st.integers(0, 3))
def test_recovers_a_fractional_shift_between_different_beats(shift: float, rate: float, seed: int) -> None:
    t_a, t_b = times(14, 50, jitter_s=0.003, seed=seed), times(14, rate)
    b = motion(t_b - shift)
    b[np.random.default_rng(seed).random(b.shape) < 0.05] = np.nan
    found = find_shift(t_a, motion(t_a), t_b, b)
    assert found is not None
    assert found.shift_s == pytest.approx(shift, abs=2e-3)  # a tenth of a sample
    assert found.shift_samples == pytest.approx(found.shift_s / np.median(np.diff(t_a)))
    assert found.misfit < 0.02


def test_offset_between_clocks_does_not_matter() -> None:
    t = times(14, 50)
    found = find_shift(t, motion(t), t + 1000.0, motion(t))
    assert found is not None
    assert found.shift_s == pytest.approx(1000, abs=1e-3)


def test_a_motion_that_repeats_takes_the_smallest_shift() -> None:
    t = times(30, 50)
    found = find_shift(t, np.sin(3 * t)[:, None], t, np.sin(3 * (t - 0.05))[:, None])
    assert found is not None
    assert found.shift_s == pytest.approx(0.05, abs=1e-3)


def test_an_offset_of_a_joint_is_not_taken_for_time() -> None:
    t = times(14, 50)
    found = find_shift(t, motion(t), t, motion(t - 0.3) + np.array([0.4, -0.2]))
    assert found is not None
    assert found.shift_s == pytest.approx(0.3, abs=2e-3)


def test_different_motions_leave_a_misfit() -> None:
    t = times(14, 50)
    found = find_shift(t, motion(t), t, np.sign(np.sin(7 * t))[:, None] * np.ones((1, 2)))
    assert found is not None
    assert found.misfit > 0.5


def test_nothing_to_align() -> None:
    t = times(5, 50)
    assert find_shift(t, np.zeros((len(t), 2)), t, motion(t)) is None
    assert find_shift(t, np.full((len(t), 2), np.nan), t, motion(t)) is None


def test_shifted_does_not_invent_data() -> None:
    t = times(4, 50)
    y = np.sin(t)[:, None]
    y[50:80] = np.nan
    seen = shifted(t, t, y, 0.0)
    assert np.isnan(seen[52:78]).all()
    assert np.isnan(shifted(t, t, y, 10.0)).all()
