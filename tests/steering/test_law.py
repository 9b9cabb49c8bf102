"""The law on a robot that turns, undulates and slips: errors vanish, limits are kept, nothing winds up."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from wheel import MODEL, ROOM, Wheel

from snakebot.steering import Course, parse_line
from snakebot.steering.authority import Authority

Y0 = parse_line("y=0")
TURNED = (0.0, 0.0, math.radians(20))
BODY_M = MODEL.body_m


@pytest.mark.parametrize(
    "wheel",
    [
        Wheel(),
        Wheel(bias_rad_s=math.radians(2)),
        Wheel(slip_rad=math.radians(8)),
        Wheel(turn_share=0.6, speed_share=0.8),
        Wheel(turn_share=1.4),
        Wheel(model=replace(MODEL, turn_per_offset_1_s=-1.15, speed_m_s=-0.17)),
        Wheel(model=replace(MODEL, period_s=1.0, speed_m_s=0.3), ramp_s=2.0),
    ],
    ids=["as modelled", "turns by itself", "slips", "weak", "strong", "backwards", "fast"],
)
def test_it_comes_to_the_line_and_stays(wheel: Wheel) -> None:
    seen, _ = wheel.run(Y0, TURNED, cycles=25)
    assert np.abs(seen[-8:, 1]).max() < 0.03 * BODY_M
    assert np.abs(seen[:, 1]).max() < 0.3 * BODY_M


def test_a_robot_as_modelled_is_back_within_a_tenth_of_its_body_at_once() -> None:
    seen, decisions = Wheel().run(Y0, TURNED)
    assert np.abs(seen[4:, 1]).max() < 0.1 * BODY_M
    assert not any(decision.saturated for decision in decisions)


def test_a_heading_is_held_although_the_robot_turns_by_itself() -> None:
    for bias_deg in (-2.0, 0.0, 2.0):
        seen, _ = Wheel(bias_rad_s=math.radians(bias_deg)).run(Course.of_heading(30), (0, 0, 0), cycles=14)
        assert np.degrees(seen[-4:, 2]) == pytest.approx(30, abs=0.5)


def test_it_turns_the_shorter_way_round() -> None:
    seen, _ = Wheel().run(Course.of_heading(-170), (0, 0, math.radians(170)), cycles=10)
    assert np.degrees(seen[-1, 2]) == pytest.approx(190, abs=1)
    assert np.diff(seen[:, 2]).min() > math.radians(-3)


def test_a_narrow_limit_is_told_and_winds_nothing_up() -> None:
    narrow = Authority(-math.radians(3), math.radians(3), math.radians(6), 1.0)
    seen, decisions = Wheel(bias_rad_s=math.radians(0.8)).run(
        Course.of_heading(60), (0, 0, 0), cycles=30, room=narrow
    )
    assert decisions[0].saturated
    assert not decisions[-1].saturated
    assert all(abs(decision.offset_rad) <= math.radians(3) + 1e-12 for decision in decisions)
    assert np.degrees(seen[:, 2]).max() < 63  # no overshoot after many cycles at the limit
    assert np.degrees(seen[-1, 2]) == pytest.approx(60, abs=0.5)


def test_an_offset_changes_by_no_more_than_a_step() -> None:
    slow = Authority(-math.radians(30), math.radians(30), math.radians(2), 1.0)
    _, decisions = Wheel().run(Course.of_heading(120), (0, 0, 0), room=slow)
    steps = np.abs(np.diff([decision.offset_rad for decision in decisions]))
    assert steps.max() <= math.radians(2) + 1e-12
    assert ROOM.step_rad > steps.max()
