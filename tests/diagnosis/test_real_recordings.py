"""Verdicts on recordings of real servos, where they are at hand."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from snakebot.diagnosis import Diagnosis, diagnose
from snakebot.runlog import read_session

DATA = Path(__file__).parents[2].parent / "shared" / "realdata"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="../shared/realdata is not here")


def verdict(name: str) -> Diagnosis:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return diagnose(read_session(DATA / name), quick=True)


@pytest.mark.slow
def test_a_servo_without_weight_is_rate_limited_and_late() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = diagnose(read_session(DATA / "pwm_servo_pendulum" / "without_weight"))
    names = {c.effect for c in found.causes}
    assert names & {"rate_limit", "voltage_sag", "torque_speed"}
    assert names & {"command_delay", "servo_lag", "second_order"}
    assert np.degrees(found.closure.joint_angle.rms_after) < 7
    assert np.degrees(found.closure.joint_angle.rms_before) > 40


@pytest.mark.slow
def test_with_weight_nothing_is_claimed_with_confidence_that_leaves_the_load_out() -> None:
    found = verdict("pwm_servo_pendulum/with_weight")
    assert found.verdict == "unexplained" or all(c.probability < 0.85 for c in found.causes)
    assert found.unexplained.significant


@pytest.mark.slow
def test_position_gains_of_four_folders_show() -> None:
    gains, off = [], []
    for kp in (100, 200, 400, 800):
        found = verdict(f"xl330_pendulum/kp_{kp}")
        (cause,) = [c for c in found.causes if c.effect == "command_gain"]
        gains.append(cause.parameters["gain"].estimate)
        off += [w for w in found.warnings if "servo is off" in w]
        assert cause.probability < 0.7
    assert gains == sorted(gains)
    assert gains[3] > 2 * gains[0]
    assert len(off) == 4
