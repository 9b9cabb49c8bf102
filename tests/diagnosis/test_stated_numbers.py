"""What the recordings say of the numbers that the description states."""

from __future__ import annotations

import pytest
from sessions import bench, make_session, snake

from snakebot.diagnosis import Diagnosis, diagnose
from snakebot.robot import Robot
from snakebot.runlog.run import Session


def with_lag(robot: Robot, time_constant_s: float) -> Robot:
    return robot.model_copy(
        update={"servo": robot.servo.model_copy(update={"time_constant_s": time_constant_s})}
    )


def lags(found: Diagnosis) -> dict[tuple[int, ...], float]:
    return {n.joints: n.estimate for n in found.nominal if n.number == "servo.time_constant_s"}


def test_a_servo_a_little_slower_than_stated_is_told_and_is_no_gap() -> None:
    stated = bench(2)
    recorded = make_session(with_lag(stated, 0.0325))
    found = diagnose(Session(stated, recorded.runs), quick=True)
    assert found.verdict == "no_gap"
    assert lags(found) == {(1,): pytest.approx(0.0325, abs=3e-4), (2,): pytest.approx(0.0325, abs=3e-4)}
    (first, _) = found.nominal
    assert first.stated == 0.03
    assert first.tolerance == pytest.approx(0.0018)
    assert first.ci95[0] < first.estimate < first.ci95[1]


def test_who_states_a_number_more_closely_sees_smaller_gaps() -> None:
    stated = bench(2)
    close = stated.model_copy(
        update={"tolerance": stated.tolerance.model_copy(update={"time_constant_s": 2e-4})}
    )
    recorded = make_session(with_lag(stated, 0.036))
    assert diagnose(Session(stated, recorded.runs), quick=True).verdict == "no_gap"
    found = diagnose(Session(close, recorded.runs), quick=True)
    assert found.verdict == "explained"
    assert found.causes[0].effect in ("servo_lag", "command_delay")


def test_friction_of_the_ground_comes_out_with_its_interval() -> None:
    stated = snake()
    assert stated.body is not None
    friction = stated.body.friction
    rough = stated.model_copy(
        update={
            "body": stated.body.model_copy(
                update={
                    "friction": friction.model_copy(
                        update={"cn": friction.cn * 0.95, "cn0": friction.cn0 * 0.95}  # type: ignore[operator]
                    )
                }
            )
        }
    )
    found = diagnose(Session(stated, make_session(rough).runs), quick=True)
    assert found.verdict == "no_gap"
    told = {n.number: n for n in found.nominal if not n.joints}
    assert set(told) <= {"friction.ct", "friction.cn", "link_mass_kg"}
    across = told.get("friction.cn")
    assert across is None or across.ci95[0] < float(friction.cn) * 0.95 < across.ci95[1]  # type: ignore[arg-type]
