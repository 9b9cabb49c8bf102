"""Robots drawn from a description, and the intervals that a diagnosis writes into it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_result_schema import FOUND

from snakebot.diagnosis.result import SpeedClosure
from snakebot.diagnosis.show.apply import calibrated
from snakebot.effects import parse_effect
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.optimise.posterior import draws, interval, is_known
from snakebot.optimise.promise import OptimiseOptions, promises, row_of
from snakebot.robot import Interval, Provenance, Robot, load_robot

ROBOT = load_robot("penn_state")


def fitted(effect: str, name: str, ci95: tuple[float, float]) -> Robot:
    """A robot with an effect that a diagnosis found."""
    (spec,) = [parse_effect(effect)]
    key = f"effects.{spec.name}"
    known = Interval(number=f"{key}.{name}", joints=spec.joints or (), estimate=spec.value(name), ci95=ci95)
    note = Provenance(status="fitted", source="a fit")
    return ROBOT.model_copy(update={"effects": (effect,), "intervals": (known,), "provenance": {key: note}})


WALKED = FOUND.model_copy(
    update={
        "closure": FOUND.closure.model_copy(
            update={
                "forward_speed": SpeedClosure(
                    error_before=0.05, error_after=0.004, rms_measured=0.2, floor=0.001, closed=0.99
                )
            }
        )
    }
)


def test_draws_have_the_interval_that_is_written() -> None:
    robot = fitted("rate_limit:limit_rad_s=1.5", "limit_rad_s", (1.35, 1.6667))
    drawn = [specs[0].value("limit_rad_s") for _, specs in draws(robot, 4000, 1)]
    assert np.quantile(drawn, [0.025, 0.5, 0.975]) == pytest.approx([1.35, 1.5, 1.6667], rel=0.01)
    assert is_known(robot)
    assert not is_known(robot.model_copy(update={"intervals": ()}))


def test_mass_friction_and_lag_have_the_tolerance() -> None:
    made = [one for one, _ in draws(ROBOT, 2000, 2)]
    assert all(one.body is not None and not one.effects for one in made)
    found = {
        "mass": float(np.std([one.body.link_mass_kg for one in made if one.body])) / 1.43,
        "cn": float(np.std([one.body.friction.cn for one in made if one.body])) / 51.9,
    }
    assert found == pytest.approx({"mass": 0.03, "cn": 0.05}, rel=0.1)
    assert np.std([one.servo.time_constant_s for one in made]) > 0.06 * 0.03 * 0.9


def test_the_same_seed_draws_the_same_robots() -> None:
    assert draws(ROBOT, 3, 5) == draws(ROBOT, 3, 5)
    assert draws(ROBOT, 3, 5) != draws(ROBOT, 3, 6)


def test_what_the_simulation_was_off_by_widens_the_interval() -> None:
    values = np.full(50, 0.2)
    assert interval(values, 0.0) == (0.2, 0.2)
    low, high = interval(values, 0.01)
    assert (high - low) / 2 == pytest.approx(0.0196, rel=0.05)


def test_a_calibrated_robot_keeps_its_intervals_in_a_file(tmp_path: Path) -> None:
    made = calibrated(ROBOT, FOUND)
    path = tmp_path / "calibrated.yaml"
    path.write_text(made.to_yaml())
    again = load_robot(path)
    assert again == made
    assert {found.ci95 for found in again.intervals} == {(0.03, 0.05)}
    assert len({specs[0].values["time_constant_s"] for _, specs in draws(again, 4)}) == 4


def test_what_is_left_of_the_speed_is_the_tolerance_of_the_speed() -> None:
    made = calibrated(ROBOT, WALKED)
    assert (made.tolerance.speed_m_s, made.tolerance.speed_share) == (0.004, 0.02)
    assert made.tolerance.left_of_speed_m_s(0.1) == 0.004
    assert made.tolerance.left_of_speed_m_s(-0.5) == 0.01


def test_a_robot_without_a_gap_is_given_the_tolerance_of_its_speed_alone() -> None:
    found = WALKED.model_copy(update={"verdict": "no_gap", "causes": ()})
    made = calibrated(ROBOT, found)
    assert made == ROBOT.model_copy(update={"tolerance": made.tolerance})
    assert made.tolerance.speed_share == 0.02


@pytest.mark.parametrize("verdict", ["unexplained", "no_gap"])
def test_what_nothing_is_learnt_from_is_refused(verdict: str) -> None:
    speed = WALKED if verdict == "unexplained" else FOUND
    with pytest.raises(BadInputError, match=f"the verdict is {verdict}: there is no effect to add"):
        calibrated(ROBOT, speed.model_copy(update={"verdict": verdict, "causes": ()}))


@pytest.mark.slow
def test_a_faster_gait_may_be_off_by_as_large_a_share_of_its_speed() -> None:
    known = ROBOT.model_copy(update={"tolerance": calibrated(ROBOT, WALKED).tolerance})
    gaits = [("slow", row_of(Gait.from_degrees(20, 80, 0.5))), ("fast", row_of(Gait.from_degrees(40, 60, 3)))]
    options = OptimiseOptions(draws=39)
    wider = []
    for less, more in zip(promises(ROBOT, gaits, options), promises(known, gaits, options), strict=True):
        assert less.speed_ci95
        assert more.speed_ci95
        wider.append(np.ptp(more.speed_ci95) ** 2 - np.ptp(less.speed_ci95) ** 2)
        assert more.power_ci95 == less.power_ci95
    assert 0 < wider[0] < wider[1]
