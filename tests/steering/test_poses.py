"""Means over a cycle, and which poses are believed."""

from __future__ import annotations

import math

import pytest

from snakebot.steering.poses import STALE_S, PoseWindow, TimedPose

PERIOD_S = 2.0


def window(until_s: float = 5.0, step_s: float = 0.01) -> PoseWindow:
    """A robot that goes at 0.2 m/s along 0.5 rad and swings by 10 degrees and 2 cm."""
    made = PoseWindow(PERIOD_S)
    for number in range(round(until_s / step_s) + 1):
        made.add(swinging(number * step_s))
    return made


def swinging(t: float) -> TimedPose:
    swing = math.sin(math.tau * t / PERIOD_S)
    return TimedPose(
        t, 0.2 * t * math.cos(0.5) + 0.02 * swing, 0.2 * t * math.sin(0.5) - 0.02 * swing,
        0.5 + math.radians(10) * swing,
    )  # fmt: skip


@pytest.mark.parametrize("step_s", [0.01, 0.033, 0.1])
def test_the_mean_over_a_cycle_does_not_swing(step_s: float) -> None:
    for until_s in (4.0, 4.3, 4.9, 5.5):
        mean = window(until_s, step_s).mean()
        assert mean is not None
        assert mean.whole
        assert mean.heading_rad == pytest.approx(0.5, abs=math.radians(0.4))
        middle_s = mean.end_s - PERIOD_S / 2
        assert mean.x_m == pytest.approx(0.2 * middle_s * math.cos(0.5), abs=0.002)
        assert mean.y_m == pytest.approx(0.2 * middle_s * math.sin(0.5), abs=0.002)
        assert math.hypot(mean.dx_m, mean.dy_m) == pytest.approx(0.2 * PERIOD_S, rel=0.02)


def test_less_than_a_cycle_says_so() -> None:
    mean = window(1.0).mean()
    assert mean is not None
    assert not mean.whole
    assert (mean.dx_m, mean.dy_m) == (0.0, 0.0)
    assert PoseWindow(PERIOD_S).mean() is None


def test_the_heading_is_averaged_across_the_half_turn() -> None:
    made = PoseWindow(PERIOD_S)
    for number in range(401):
        t = number * 0.01
        made.add(
            TimedPose(t, 0, 0, math.remainder(math.pi + 0.2 * math.sin(math.tau * t / PERIOD_S), math.tau))
        )
    mean = made.mean()
    assert mean is not None
    assert math.remainder(mean.heading_rad - math.pi, math.tau) == pytest.approx(0, abs=0.01)


def test_one_damaged_pose_counts_for_nothing() -> None:
    made, clean = window(), window()
    for number in range(1, 50):
        t = 5.0 + number * 0.01
        if number % 10 == 0:
            assert not made.add(TimedPose(t, 81.3, 0.1, 0.5))
            assert not made.add(TimedPose(t, swinging(t).x_m, swinging(t).y_m, 3.0))
        made.add(swinging(t))
        clean.add(swinging(t))
    assert made.mean() == clean.mean()
    assert made.doubted == 8


def test_a_robot_that_was_put_elsewhere_is_believed_and_averaged_anew() -> None:
    made = window()
    for number in range(1, 4):
        pose = swinging(5 + 0.01 * number)
        believed = made.add(pose._replace(x_m=pose.x_m + 3))
        assert believed is (number == 3)
    mean = made.mean()
    assert mean is not None
    assert not mean.whole
    assert mean.x_m == pytest.approx(swinging(5.03).x_m + 3)


def test_poses_that_stop_are_stale_and_what_comes_after_begins_a_new_cycle() -> None:
    made = window()
    assert not made.stale(5.0 + STALE_S)
    assert made.stale(5.01 + STALE_S)
    assert PoseWindow(PERIOD_S).stale(0.0)
    assert made.add(swinging(9.0))
    mean = made.mean()
    assert mean is not None
    assert not mean.whole


def test_a_time_that_goes_back_is_left_out() -> None:
    made = window()
    before = made.mean()
    assert not made.add(swinging(3.0))
    assert made.mean() == before


def test_a_fast_source_is_thinned() -> None:
    made = PoseWindow(60.0)
    for number in range(13000):
        made.add(TimedPose(number * 0.01, 0, 0, 0))
    assert len(made._poses) < 140
