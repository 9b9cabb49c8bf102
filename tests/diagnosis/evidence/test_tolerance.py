"""What the nominal numbers may be off by is taken off a residual, within bounds; noise is taken off a signal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sessions import bench, make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.evidence.tolerance import (
    ShiftLimits,
    StackedTimes,
    bounded_share,
    shift_limit_s,
    shifts_s,
)
from snakebot.diagnosis.fit.fit_runs import shift_limits
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import nominal_trial
from snakebot.diagnosis.sizes import BEYOND_CHANCE
from snakebot.smoothing import smoothed

T_S = np.arange(400) / 100


def motion(shift_s: float) -> np.ndarray:
    t = T_S - shift_s
    return np.column_stack([np.sin(3 * t), 0.5 * np.cos(2 * t)])


@given(st.floats(-0.02, 0.02))
def test_a_shift_in_time_is_found_up_to_its_limit(late_s: float) -> None:
    limits = ShiftLimits(np.array([0.005, 0.0]), np.array([-1, -1]))
    residual = motion(late_s) - motion(0.0)
    block = np.repeat(np.arange(8), 50)[:, None] + np.array([0, 8])
    found = shifts_s(
        residual, StackedTimes.of([T_S], 0.0).rates(motion(0.0)), block, np.full(16, 1e-6), limits
    )
    assert found[0] == pytest.approx(np.clip(-late_s, -0.005, 0.005), abs=2e-4)
    assert found[1] == 0.0


def test_all_servos_may_be_as_late_as_each() -> None:
    """A number stated for all servos of a robot is mostly off for all of them alike."""
    limits = ShiftLimits.of(bench(9))
    most = shift_limit_s(bench(9))
    assert limits.within(np.full(9, 0.9 * most)) == pytest.approx(np.full(9, 0.9 * most))
    assert limits.within(np.full(9, 2 * most)) == pytest.approx(np.full(9, most))


def test_the_mark_of_a_lag_is_what_a_slower_servo_does_to_a_reading() -> None:
    robot = bench(1)
    slower = robot.model_copy(update={"servo": robot.servo.model_copy(update={"time_constant_s": 0.0305})})
    runs = [prepare(make_session(r)) for r in (robot, slower)]
    a, b = (gather(data).predictor.nominal[0] for data in runs)
    t_s = runs[0].runs[0].t_s
    mark = StackedTimes.of([t_s], 0.03).lag_marks(a)
    assert (b - a)[50:] == pytest.approx(-0.0005 * mark[50:], abs=0.1 * 0.0005 * np.abs(mark).max())


def test_rates_are_those_of_uneven_samples() -> None:
    t = np.sort(np.random.default_rng(0).uniform(0, 4, 3000))
    rate = StackedTimes.of([t], 0.0).rates(np.sin(t)[:, None])[:, 0]
    assert np.abs(rate - np.cos(t)).max() < 0.02


@settings(deadline=None)  # the first call may compile a kernel
@given(st.floats(-3, 3), st.floats(-3, 3))
def test_shares_of_the_tolerances_stay_within_them(a: float, b: float) -> None:
    rng = np.random.default_rng(1)
    marks = rng.normal(size=(80, 2))
    found = bounded_share(
        marks @ [a, b], marks, np.array([-1.0, 0.0]), np.ones(2), np.full(2, 0.5), np.full(80, 1e-8)
    )
    assert np.all(found >= [-1.0, 0.0])
    assert np.all(found <= 1.0)
    if -1 < a < 1 and 0 < b < 1:
        assert found == pytest.approx([a, b], rel=0.12, abs=0.03)  # held towards zero a little


@settings(deadline=None)  # the first call may compile a kernel
@given(st.lists(st.floats(-10, 10), min_size=12, max_size=12))
@pytest.mark.slow
def test_together_the_tolerances_are_no_further_off_than_one_may_be(size: list[float]) -> None:
    """Each of many numbers at the edge of what is credible is not credible at all."""
    spread = np.linspace(0.01, 0.1, 12)
    marks = np.tile(np.eye(12) / spread, (100, 1))
    most = BEYOND_CHANCE * spread
    found = bounded_share(np.tile(size, 100), marks, -most, most, spread, np.full(1200, 1e-8)) / spread
    assert np.linalg.norm(found) <= BEYOND_CHANCE * (1 + 1e-9)
    if np.linalg.norm(size) < BEYOND_CHANCE:
        assert found == pytest.approx(size, abs=0.1)
    else:
        assert np.linalg.norm(found) == pytest.approx(BEYOND_CHANCE, abs=0.1)


@pytest.mark.parametrize(("ct_scale", "gap"), [(1.05, False), (2.0, True)])
def test_many_tolerances_at_once_do_not_hide_what_the_ground_does(ct_scale: float, gap: bool) -> None:
    session = make_session(snake(), [f"ground_friction:ct_scale={ct_scale}"], pose=True)
    evidence = gather(prepare(session))
    assert gap_of(evidence.scoring, nominal_trial(evidence).held_square).any is gap


def test_a_tolerance_that_leaves_no_mark_is_not_made_use_of() -> None:
    marks = np.full((20, 1), 1e-9)
    one = np.ones(1)
    assert abs(bounded_share(np.full(20, 1e-3), marks, -one, one, 0.5 * one, np.full(20, 1e-6))[0]) < 1e-3


@pytest.mark.parametrize(("late_s", "gap"), [(0.004, False), (0.012, True)])
def test_a_robot_a_little_late_has_no_gap(late_s: float, gap: bool) -> None:
    robot = bench(1)
    assert 0.004 < shift_limit_s(robot) < 0.012
    delay = [f"command_delay:delay_s={late_s}"]
    evidence = gather(prepare(make_session(robot, delay)))
    assert gap_of(evidence.scoring, nominal_trial(evidence).held_square).any is gap


def test_who_sets_the_delay_gets_no_shift_besides() -> None:
    evidence = gather(prepare(make_session(bench(2))))

    def limits(term: Term) -> np.ndarray:
        return shift_limits(evidence.angles, Hypothesis((term,))).each_s

    plain = limits(Term("rate_limit", None))
    assert np.all(plain == shift_limit_s(bench(2)))
    assert list(limits(Term("servo_lag", (2,))) > 0) == [True, False]
    assert not limits(Term("servo_lag", (1, 2), own=True)).any()


def test_servos_that_are_late_together_still_differ_from_each_other() -> None:
    robot = bench(3)
    limits = ShiftLimits.of(robot, [[0, 1, 2]])
    assert limits.within(np.array([0.003, 0.001, 0.002])) == pytest.approx([0.001, -0.001, 0.0])
    assert not ShiftLimits.of(robot, [[0], [1], [2]]).any
    assert list(ShiftLimits.of(robot, [[0, 1, 2], [1]]).each_s > 0) == [True, False, True]


def test_smoothing_keeps_a_cubic_and_halves_noise() -> None:
    cubic = np.column_stack([T_S**3 - 4 * T_S, 2 * T_S])
    assert smoothed(T_S, cubic) == pytest.approx(cubic, abs=1e-9)
    noise = np.random.default_rng(2).normal(size=(400, 1))
    assert smoothed(T_S, noise)[20:-20].std() < 0.5 * noise.std()
    broken = np.where(np.arange(400)[:, None] == 7, np.nan, cubic)
    assert smoothed(T_S, broken) is broken


@pytest.mark.parametrize(
    ("stated", "side"),
    [("lag_shape", "angles"), ("sag_rad_per_nm", "angles"), ("pose_m", "ground"), ("heading_rad", "ground")],
)
def test_what_the_description_states_is_allowed(stated: str, side: str) -> None:
    session = make_session(snake(), pose=True)
    wider = session.robot.tolerance.model_copy(update={stated: 3 * getattr(session.robot.tolerance, stated)})
    other = session.robot.model_copy(update={"tolerance": wider})
    before, after = (
        gather(prepare(replace(session, robot=robot))).scoring for robot in (session.robot, other)
    )
    changed = after.allowed_square > 1.01 * before.allowed_square
    assert (after.allowed_square >= before.allowed_square * (1 - 1e-9)).all()
    assert changed.any()
    assert not changed[before.of_ground if side == "angles" else before.of_angles].any()
