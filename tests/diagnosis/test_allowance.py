"""What the nominal numbers may be off by is taken off a residual, within bounds; noise is taken off a signal."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sessions import bench, make_session

from snakebot.diagnosis.allowance import bounded_share, rate_of, shift_limit_s, shifts_s
from snakebot.diagnosis.context import make_context
from snakebot.diagnosis.data import prepare
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.hypothesis import Hypothesis, Term
from snakebot.diagnosis.smoothing import smoothed
from snakebot.diagnosis.trial import nominal_trial
from snakebot.effects import parse_effect

T_S = np.arange(400) / 100


def motion(shift_s: float) -> np.ndarray:
    t = T_S - shift_s
    return np.column_stack([np.sin(3 * t), 0.5 * np.cos(2 * t)])


@given(st.floats(-0.02, 0.02))
def test_a_shift_in_time_is_found_up_to_its_limit(late_s: float) -> None:
    limit = np.array([0.005, 0.0])
    residual = motion(late_s) - motion(0.0)
    block = np.repeat(np.arange(8), 50)[:, None] + np.array([0, 8])
    found = shifts_s(residual, rate_of(motion(0.0), T_S), block, np.full(16, 1e-6), limit)
    assert found[0] == pytest.approx(np.clip(-late_s, -0.005, 0.005), abs=2e-4)
    assert found[1] == 0.0


def test_rates_are_those_of_uneven_samples() -> None:
    t = np.sort(np.random.default_rng(0).uniform(0, 4, 3000))
    rate = rate_of(np.sin(t)[:, None], t)[:, 0]
    assert np.abs(rate - np.cos(t)).max() < 0.02


@settings(deadline=None)  # the first call imports an optimiser
@given(st.floats(-3, 3), st.floats(-3, 3))
def test_shares_of_the_tolerances_stay_within_them(a: float, b: float) -> None:
    rng = np.random.default_rng(1)
    marks = rng.normal(size=(80, 2))
    found = bounded_share(marks @ [a, b], marks, np.array([-1.0, 0.0]), np.full(80, 1e-8))
    assert np.all(found >= [-1.0, 0.0])
    assert np.all(found <= 1.0)
    if -1 < a < 1 and 0 < b < 1:
        assert found == pytest.approx([a, b], rel=0.12, abs=0.03)  # held towards zero a little


def test_a_tolerance_that_leaves_no_mark_is_not_made_use_of() -> None:
    marks = np.full((20, 1), 1e-9)
    assert abs(bounded_share(np.full(20, 1e-3), marks, np.array([-1.0]), np.full(20, 1e-6))[0]) < 1e-3


@pytest.mark.parametrize(("late_s", "gap"), [(0.0015, False), (0.008, True)])
def test_a_robot_a_little_late_has_no_gap(late_s: float, gap: bool) -> None:
    robot = bench(1)
    assert 0.0015 < shift_limit_s(robot.servo.time_constant_s) < 0.008
    delay = (parse_effect(f"command_delay:delay_s={late_s}"),)
    context = make_context(prepare(make_session(robot, delay)), {}, 0)
    assert gap_of(context, nominal_trial(context)).any is gap


def test_who_sets_the_delay_gets_no_shift_besides() -> None:
    context = make_context(prepare(make_session(bench(2))), {}, 0)
    plain = context.shift_limits_s(Hypothesis((Term("rate_limit", None),)))
    assert np.all(plain == shift_limit_s(0.03))
    assert list(context.shift_limits_s(Hypothesis((Term("servo_lag", (2,)),))) > 0) == [True, False]
    assert not context.shift_limits_s(Hypothesis((Term("command_delay", None),))).any()


def test_smoothing_keeps_a_cubic_and_halves_noise() -> None:
    cubic = np.column_stack([T_S**3 - 4 * T_S, 2 * T_S])
    assert smoothed(T_S, cubic) == pytest.approx(cubic, abs=1e-9)
    noise = np.random.default_rng(2).normal(size=(400, 1))
    assert smoothed(T_S, noise)[20:-20].std() < 0.5 * noise.std()
    broken = np.where(np.arange(400)[:, None] == 7, np.nan, cubic)
    assert smoothed(T_S, broken) is broken
