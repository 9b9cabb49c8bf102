"""The gait that the paper's robot should have had, where what explains its speeds is known."""

from __future__ import annotations

import json

import pytest

from snakebot.optimise.rechosen import rechosen
from snakebot.robot import load_robot
from snakebot.studies.gap import paper_gait

ROBOT = load_robot("penn_state")


@pytest.mark.slow
def test_a_gait_chosen_for_the_weak_servo_is_faster_than_the_papers_and_keeps_its_omega() -> None:
    (row,) = rechosen(ROBOT, ["torque_limit:limit_nm=0.28"], paper_gait, [5.0], grid=(3, 3, 2))
    assert row.ideal_speed_m_s == pytest.approx(0.41, abs=0.01)  # docs/studies.md, nominal servo
    assert row.paper.speed_m_s < 0.6 * row.ideal_speed_m_s
    assert row.paper.alpha_deg == pytest.approx(40)
    assert {promise.omega_rad_s for promise in (row.paper, row.plain, row.found)} == {5.0}
    assert row.found.speed_m_s >= max(row.paper.speed_m_s, row.plain.speed_m_s)
    assert row.gain == pytest.approx(row.found.speed_m_s / row.paper.speed_m_s - 1)
    assert json.loads(json.dumps(row.summary()))["gain_of_knowing"] == row.gain_of_knowing
