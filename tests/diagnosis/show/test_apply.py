"""What ``diagnose --apply`` writes into a robot's description."""

from __future__ import annotations

import pytest
from answers import LIMIT, made

from snakebot.diagnosis.result import SpeedClosure, StatedNumber
from snakebot.diagnosis.show.apply import calibrated
from snakebot.robot import SERVO_LAG, load_robot


def told(joint: int, lag_s: float) -> StatedNumber:
    return StatedNumber(
        number=SERVO_LAG, joints=(joint,), stated=0.03, tolerance=0.0018, estimate=lag_s, ci95=(lag_s, lag_s)
    )


def test_the_lag_becomes_the_mean_of_those_that_the_runs_tell() -> None:
    found = made("explained", LIMIT).model_copy(update={"nominal": (told(1, 0.032), told(2, 0.034))})
    robot = calibrated(load_robot("penn_state"), found)
    assert robot.servo.time_constant_s == pytest.approx(0.033)
    assert robot.provenance[SERVO_LAG].status == "fitted"
    assert robot.effects == (LIMIT.specification,)


def test_a_lag_that_is_not_told_is_the_stated_one() -> None:
    found = made("explained", LIMIT).model_copy(update={"nominal": ()})
    assert calibrated(load_robot("penn_state"), found).servo == load_robot("penn_state").servo


@pytest.mark.parametrize("verdict", ["partly", "no_gap"])
def test_a_lag_beside_a_rest_or_without_a_gap_is_the_stated_one(verdict: str) -> None:
    speed = SpeedClosure(error_before=0.01, error_after=0.01, floor=0.003, closed=None)
    causes = (LIMIT,) if verdict == "partly" else ()
    found = made(verdict, *causes, speed=speed).model_copy(update={"nominal": (told(1, 0.034),)})
    assert calibrated(load_robot("penn_state"), found).servo == load_robot("penn_state").servo
