"""Joints that have a little of everything: effects that only help together, joints with values of their own."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import bench, make_session, snake

from snakebot.diagnosis import Diagnosis, diagnose
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import against_nominal
from snakebot.diagnosis.search.candidates import kinds
from snakebot.diagnosis.search.everyday import everyday_terms, is_worn, other_kinds
from snakebot.diagnosis.search.library import usable_effects
from snakebot.effects.registry import find_effect
from snakebot.robot import Robot, robot_from_mapping

GAITS = ((66, 80, 2.0), (30, 80, 4.0), (50, 60, 1.0), (20, 80, 6.0))
OFFSETS_DEG, PLAYS_DEG = (1.5, -2.0, 0.8), (2.0, 1.2, 3.0)
WORN = (
    "servo_lag:time_constant_s=0.05+0.065+0.042,joints=1+2+3",
    f"servo_offset:offset_deg={'+'.join(map(str, OFFSETS_DEG))},joints=1+2+3",
    f"backlash:width_deg={'+'.join(map(str, PLAYS_DEG))},joints=1+2+3",
)


def values(found: Diagnosis, effect: str, parameter: str) -> list[float]:
    (cause,) = [c for c in found.causes if c.effect == effect]
    assert cause.joints == (1, 2, 3)
    return [joint.estimate for joint in cause.parameters[parameter].by_joint]


@pytest.mark.slow
def test_three_effects_that_differ_from_joint_to_joint_are_three_causes() -> None:
    found = diagnose(make_session(bench(3), WORN, gaits=GAITS), quick=True)
    assert found.verdict == "explained"
    assert {c.effect for c in found.causes} == {"servo_lag", "servo_offset", "backlash"}
    assert np.allclose(values(found, "servo_lag", "time_constant_s"), (0.05, 0.065, 0.042), rtol=0.05)
    assert np.allclose(values(found, "servo_offset", "offset_deg"), OFFSETS_DEG, atol=0.1)
    assert np.allclose(values(found, "backlash", "width_deg"), PLAYS_DEG, rtol=0.1)
    (offset,) = [c for c in found.causes if c.effect == "servo_offset"]
    assert offset.specification.endswith(",joints=1+2+3")
    closed = found.closure.joint_angle.closed
    assert closed is not None
    assert closed > 0.95


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_play_that_the_load_takes_up_leaves_the_lag_to_the_lag() -> None:
    """Play that friction holds would be told as half of that, and half of the lag as a delay."""
    robot, play = snake(), (0.7, 0.5, 0.9, 0.6, 0.8)
    lag_s = robot.servo.time_constant_s * np.array([1.3, 1.2, 1.4, 1.25, 1.35])
    every = "joints=1+2+3+4+5"
    worn = (
        f"servo_lag:time_constant_s={'+'.join(f'{lag:.5f}' for lag in lag_s)},{every}",
        f"servo_offset:offset_deg=0.6+-0.5+0.4+-0.7+0.5,{every}",
        f"backlash:width_deg={'+'.join(map(str, play))},loaded=1,{every}",
    )
    found = diagnose(make_session(robot, worn, gaits=GAITS), quick=True)
    causes = {cause.effect: cause for cause in found.causes if len(cause.joints) > 1}
    assert set(causes) == {"servo_lag", "servo_offset", "backlash"}
    lags = [joint.estimate for joint in causes["servo_lag"].parameters["time_constant_s"].by_joint]
    assert np.allclose(lags, lag_s, rtol=0.05)
    widths = [joint.estimate for joint in causes["backlash"].parameters["width_deg"].by_joint]
    assert np.allclose(widths, play, rtol=0.15)


@pytest.mark.slow
def test_a_fault_beside_the_wear_is_found() -> None:
    fault = "rate_limit:limit_rad_s=1.2,joints=2"
    found = diagnose(make_session(bench(3), (*WORN, fault), gaits=GAITS), quick=True)
    (limit,) = [c for c in found.causes if c.effect == "rate_limit"]
    assert limit.joints == (2,)
    assert abs(limit.parameters["limit_rad_s"].estimate - 1.2) < 0.1
    assert found.verdict in ("explained", "partly")


@pytest.mark.slow
def test_a_dead_band_of_another_kind_is_told_as_what_it_is_beside_the_wear() -> None:
    """Soft bands and other lags on every joint explain it nearly as well."""
    small = "servo_offset:offset_deg=0.4+-0.5+0.3,joints=1+2+3"
    found = diagnose(
        make_session(bench(3), (WORN[0], small, "deadband:width_deg=4,hard=1"), gaits=GAITS), quick=True
    )
    (band,) = [c for c in found.causes if c.effect == "deadband"]
    assert "hard=1" in band.specification
    assert band.parameters["width_deg"].estimate == pytest.approx(4, abs=0.1)
    assert found.verdict == "explained"


@pytest.mark.slow
def test_hard_bands_of_all_joints_leave_the_delay_to_the_delay() -> None:
    """Soft bands take half of the delay into their width."""
    worn = (
        "command_delay:delay_s=0.012+0.02+0.016,joints=1+2+3",
        "servo_offset:offset_deg=0.4+-0.5+0.3,joints=1+2+3",
        "deadband:width_deg=1.6+1.2+2,hard=1,joints=1+2+3",
    )
    found = diagnose(make_session(bench(3), worn, gaits=GAITS), quick=True)
    (band,) = [c for c in found.causes if c.effect == "deadband"]
    assert "hard=1" in band.specification
    assert np.allclose(values(found, "deadband", "width_deg"), (1.6, 1.2, 2), atol=0.1)
    assert np.allclose(values(found, "command_delay", "delay_s"), (0.012, 0.02, 0.016), atol=0.002)
    assert found.verdict == "explained"


def on_an_arm() -> Robot:
    return robot_from_mapping({"joints": 2, "servo": {"arm": {"mass_kg": 0.3, "length_m": 0.1}}}, "arm")


@pytest.mark.parametrize(
    ("robot", "kinds_of_play"),
    [(snake(), 1), (bench(), 0), (on_an_arm(), 1)],
)
def test_everyday_effects_have_other_kinds_where_torques_are_known(robot: Robot, kinds_of_play: int) -> None:
    nominal, evidence = against_nominal(gather(prepare(make_session(robot))))
    assert nominal.hypothesis == Hypothesis()
    library = usable_effects(evidence.data, over_ground=False)
    others = {term.effect: other_kinds(evidence, library, term) for term in everyday_terms(library)}
    (band,) = others.pop("deadband")
    assert ("hard", 1.0) in band.fixed
    assert len(others.pop("backlash")) == kinds_of_play
    assert not any(others.values())
    hard = library.of_kinds([band])
    assert band in everyday_terms(hard)
    assert is_worn(hard, Hypothesis((band,)))
    assert not is_worn(library, Hypothesis((band,)))


def test_play_that_the_load_takes_up_is_a_fault_and_plain_play_is_wear() -> None:
    library = usable_effects(prepare(make_session(snake())), over_ground=False)
    plain, loaded = (Term("backlash", None, kind) for kind in kinds(library, find_effect("backlash")))
    late = Term("command_delay", (2,), own=True)
    assert is_worn(library, Hypothesis((plain, late)))
    assert not is_worn(library, Hypothesis((loaded,)))
    assert not is_worn(library, Hypothesis((late, loaded)))


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_second_fault_of_all_joints_is_not_hidden_by_what_every_joint_has_a_little_of() -> None:
    faults = ("backlash:width_deg=4,loaded=1", "compliance:stiffness_nm_rad=15")
    gaits = ((66, 80, 2.0), (30, 80, 4.0), (50, 60, 1.0), (20, 80, 3.0))
    found = diagnose(make_session(snake(), faults, gaits=gaits, pose=True, duration_s=8.0))
    assert found.verdict == "explained"
    assert {c.effect for c in found.causes} == {"backlash", "compliance"}
