"""Verdicts on recordings of real servos, where they are at hand."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from recordings import AT_HAND, REAL, Answers

from snakebot.diagnosis import diagnose
from snakebot.runlog import read_session

pytestmark = AT_HAND


@pytest.mark.slow
def test_a_servo_without_weight_is_rate_limited_and_late() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = diagnose(read_session(REAL / "pwm_servo_pendulum" / "without_weight"))
    names = {c.effect for c in found.causes}
    assert names & {"rate_limit", "voltage_sag", "torque_speed"}
    assert names & {"command_delay", "servo_lag", "second_order"}
    assert np.degrees(found.closure.joint_angle.rms_after) < 7
    assert np.degrees(found.closure.joint_angle.rms_before) > 40


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_with_weight_nothing_is_claimed_with_confidence_that_leaves_the_load_out(answers: Answers) -> None:
    found = answers.about("pwm_servo_pendulum/with_weight")
    assert found["verdict"] == "unexplained" or all(c["probability"] < 0.85 for c in found["causes"])
    assert found["unexplained"]["significant"]


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_position_gains_of_four_folders_show(answers: Answers) -> None:
    """The same servo and arm at four position gains: a loop that is four times as stiff and more, of eight."""
    stiffness, off = [], []
    for kp in (100, 200, 400, 800):
        found = answers.about(f"xl330_pendulum/kp_{kp}")
        (cause,) = [c for c in found["causes"] if c["effect"] == "position_loop"]
        stiffness.append(cause["parameters"]["stiffness_nm_rad"]["estimate"])
        off += [w for w in found["warnings"] if "servo is off" in w]
        assert cause["probability"] < 0.7
        angle = found["closure"]["joint_angle"]
        assert angle["rms_after"] < 0.5 * angle["rms_before"]
    assert stiffness == sorted(stiffness)
    assert stiffness[3] > 4 * stiffness[0]
    assert len(off) == 4
