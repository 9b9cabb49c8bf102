"""Speed over whole cycles, and the link's figures."""

from __future__ import annotations

import math

import numpy as np
import pytest
from signals import times

from snakebot.analysis.link_quality import link_quality
from snakebot.analysis.speed import forward_speed, speed_error_percent


def test_sway_does_not_change_the_speed() -> None:
    t = times(10, 100)
    omega, heading = 2.0, 0.6
    along, across = 0.2 * t + 0.05 * np.sin(2 * omega * t), 0.1 * np.sin(omega * t)
    x = along * math.cos(heading) - across * math.sin(heading)
    y = along * math.sin(heading) + across * math.cos(heading)
    pose = np.stack([x, y, heading + 0.3 * np.sin(omega * t)], axis=1)
    pose[200:230] = np.nan
    found = forward_speed(t, pose, 1.0, 1.0 + 2 * math.pi, math.pi)
    assert found is not None
    assert found.forward_m_s == pytest.approx(0.2, abs=2e-3)
    assert abs(found.lateral_m_s) < 2e-3


def test_a_snake_that_turns_still_goes_forward() -> None:
    t = times(20, 100)
    turn = 0.2
    pose = np.stack([np.sin(turn * t), 1 - np.cos(turn * t), turn * t], axis=1) * [0.1 / turn, 0.1 / turn, 1]
    found = forward_speed(t, pose, 0, 19, 1.0)
    assert found is not None
    assert found.forward_m_s == pytest.approx(0.1, rel=5e-3)
    assert found.turn_rad_s == pytest.approx(turn, rel=1e-3)


def test_no_pose_no_speed() -> None:
    t = times(5, 10)
    assert forward_speed(t, np.full((len(t), 3), np.nan), 0, 5) is None


def test_speed_error_is_equation_36() -> None:
    assert speed_error_percent(0.24, 0.32) == pytest.approx(-25)
    assert math.isnan(speed_error_percent(0.1, 0.0))


def test_link_figures() -> None:
    t = times(10, 100)
    measured = np.zeros((len(t), 2))
    measured[::10] = np.nan
    latency = np.full(len(t), 0.004)
    latency[5] = 0.05
    late = np.zeros(len(t), dtype=bool)
    late[[3, 7]] = True
    command = np.sin(2 * t)[:, None] * np.ones((1, 2))
    applied = np.sin(2 * (t - 0.013))[:, None] * np.ones((1, 2))
    found = link_quality(t, measured, command, applied, latency, late)
    assert found.lost == pytest.approx(0.1)
    assert found.late_ticks == 2
    assert found.latency_median_s == pytest.approx(0.004)
    assert found.latency_max_s == pytest.approx(0.05)
    assert found.delay_to_board_s == pytest.approx(0.013, abs=1e-3)
    assert found.jitter_std_s < 1e-9


def test_jitter_is_departure_from_the_beat_and_a_missing_tick_is_none() -> None:
    t = times(20, 100, jitter_s=0.002, seed=4)
    t = np.delete(t, [100, 101, 500])
    found = link_quality(t, np.zeros((len(t), 1)))
    # the difference of two uniform departures of half width a has standard deviation a sqrt(2/3)
    assert found.jitter_std_s == pytest.approx(0.002 * math.sqrt(2 / 3), rel=0.1)
    assert math.isnan(found.latency_median_s)


def test_without_a_heading_the_speed_is_that_of_the_way() -> None:
    t = times(10, 100)
    x = 0.2 * t + 0.05 * np.sin(4 * t)
    pose = np.stack([-0.6 * x, 0.8 * x, np.full(len(t), np.nan)], axis=1)
    found = forward_speed(t, pose, 1.0, 1.0 + 2 * math.pi, math.pi / 2)
    assert found is not None
    assert found.forward_m_s == pytest.approx(0.2, abs=2e-3)
    assert math.isnan(found.lateral_m_s)
    assert math.isnan(found.turn_rad_s)
