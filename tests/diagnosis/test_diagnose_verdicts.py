"""From a session with a known truth to a verdict."""

from __future__ import annotations

import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
from sessions import GAITS, bench, lossy_session, make_session, snake

from snakebot.diagnosis import Diagnosis, diagnose, json_schema
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.show.page import page
from snakebot.diagnosis.show.words import summary
from snakebot.diagnosis.sizes import SURE
from snakebot.diagnosis.verdict.noise import noisy_encoders
from snakebot.effects import predict
from snakebot.runlog import Session


@pytest.fixture(scope="module")
def limited() -> tuple[Session, Diagnosis]:
    session = make_session(bench(), ["rate_limit:limit_rad_s=1.3,joints=2"])
    return session, diagnose(session)


def test_a_rate_limit_is_found_with_joint_and_value(limited: tuple[Session, Diagnosis]) -> None:
    _, found = limited
    assert found.verdict == "explained"
    assert found.where.stage == "servo"
    assert found.where.joints == (2,)
    (cause,) = found.causes
    assert cause.effect == "rate_limit"
    assert cause.joints == (2,)
    value = cause.parameters["limit_rad_s"]
    assert value.estimate == pytest.approx(1.3, rel=0.01)
    assert value.ci95 is not None
    assert value.ci95[0] <= 1.3 <= value.ci95[1]
    assert found.closure.joint_angle.closed == pytest.approx(1.0, abs=0.02)
    assert found.where.joint_shares[1] > 0.9
    assert sum(found.where.joint_shares) == pytest.approx(1.0, abs=1e-3)


def test_the_output_meets_the_published_schema(limited: tuple[Session, Diagnosis]) -> None:
    data = limited[1].to_mapping()
    assert data["schema"] == "snakebot.diagnosis/2"
    jsonschema.validate(json.loads(json.dumps(data, allow_nan=False)), json_schema())


def test_same_input_and_seed_same_answer(limited: tuple[Session, Diagnosis]) -> None:
    session, first = limited
    assert diagnose(session).to_mapping() == first.to_mapping()


def test_joints_that_each_have_an_offset_of_their_own() -> None:
    offsets = (1.2, -0.8, 2.0, 0.5)
    session = make_session(
        bench(4), [f"servo_offset:offset_deg={v},joints={j}" for j, v in enumerate(offsets, 1)]
    )
    found = diagnose(session, only=["servo_offset"])
    assert found.verdict == "explained"
    (cause,) = found.causes
    assert cause.joints == (1, 2, 3, 4)
    each = [joint.estimate for joint in cause.parameters["offset_deg"].by_joint]
    assert each == pytest.approx(offsets, abs=0.02)


def test_no_gap_is_no_gap() -> None:
    found = diagnose(make_session(bench()))
    assert found.verdict == "no_gap"
    assert found.causes == ()
    assert found.where.stage == "none"
    assert found.closure.joint_angle.closed is None
    assert found.closure.joint_angle.reason


def test_a_lag_within_the_tolerance_of_the_nominal_one_is_no_gap() -> None:
    assert diagnose(make_session(bench(), ["servo_lag:time_constant_s=0.031"])).verdict == "no_gap"


def test_a_delay_is_told_from_a_lag_by_several_frequencies() -> None:
    found = diagnose(make_session(bench(1), ["command_delay:delay_s=0.06"]), quick=True)
    assert [cause.effect for cause in found.causes] == ["command_delay"]
    assert found.causes[0].parameters["delay_s"].estimate == pytest.approx(0.06, abs=0.002)
    assert found.where.stage == "link"


def test_offsets_of_servo_and_encoder_tie_without_a_pose() -> None:
    found = diagnose(make_session(bench(), ["encoder_offset:offset_deg=4,joints=1"]))
    (cause,) = found.causes
    assert {cause.effect, *cause.indistinguishable_from} == {"servo_offset", "encoder_offset"}
    assert found.next_experiment is None
    assert any("a second look at the joint" in warning for warning in found.warnings)


def test_a_pose_separates_the_offsets() -> None:
    session = make_session(snake(), ["encoder_offset:offset_deg=4,joints=3"], pose=True)
    found = diagnose(session, quick=True, only=["servo_offset", "encoder_offset", "command_gain", "backlash"])
    assert found.causes[0].effect == "encoder_offset"
    assert found.causes[0].joints == (3,)
    assert "servo_offset" not in found.causes[0].indistinguishable_from


def test_an_excluded_effect_is_never_named_and_its_case_is_not_explained_with_confidence() -> None:
    session = make_session(bench(1), ["rate_limit:limit_rad_s=1.0"])
    found = diagnose(session, exclude=["rate_limit", "voltage_sag"], quick=True)
    assert all(c.effect not in ("rate_limit", "voltage_sag") for c in found.causes)
    assert found.verdict == "unexplained" or all(c.probability < 0.7 for c in found.causes)


def test_what_was_left_out_and_looks_the_same_is_told() -> None:
    session = make_session(bench(1), ["encoder_offset:offset_deg=4"])
    found = diagnose(session, only=["servo_offset"], exclude=["encoder_offset"], quick=True)
    assert [cause.effect for cause in found.causes] == ["servo_offset"]
    assert [w for w in found.warnings if w.startswith("encoder_offset was left out")]
    assert not [w for w in diagnose(session, only=["servo_offset"], quick=True).warnings if "left out" in w]


def test_noise_that_may_not_be_named_is_told_all_the_same() -> None:
    session = make_session(bench(), noise_deg=0.6)
    assert [c.effect for c in diagnose(session).causes] == ["encoder_noise"]
    without = diagnose(session, exclude=("encoder_noise",))
    assert (without.verdict, without.causes, without.where.joints) == ("unexplained", (), (1, 2))
    assert any("scatter" in warning for warning in without.warnings)


def test_what_no_effect_can_do_is_unexplained_and_located() -> None:
    session = make_session(bench())
    runs = []
    for run in session.runs:
        measured = run.measured_rad.copy()
        neighbour = np.interp(run.t_s - 0.25, run.t_s, run.command_rad[:, 1])
        measured[:, 0] += 0.3 * neighbour**3 / 0.4 + 0.15 * np.sin(6 * run.command_rad[:, 0])
        runs.append(replace(run, measured_rad=measured))
    found = diagnose(replace(session, runs=tuple(runs)), quick=True)
    assert found.verdict == "unexplained"
    assert found.where.joints == (1,)
    assert found.unexplained.significant
    assert "joint 1" in found.unexplained.where


def test_known_values_are_not_fitted() -> None:
    session = make_session(bench(1), ["rate_limit:limit_rad_s=1.3"])
    found = diagnose(session, known={"rate_limit.limit_rad_s": 1.25}, only=["rate_limit"], quick=True)
    value = found.causes[0].parameters["limit_rad_s"]
    assert value.fixed
    assert value.estimate == 1.25
    assert value.ci95 is None


def test_held_out_runs_are_the_ones_closure_is_taken_on() -> None:
    session = make_session(bench(1), ["rate_limit:limit_rad_s=1.3"])
    runs = tuple(replace(run, hold_out=run.name == "run_02.csv") for run in session.runs)
    found = diagnose(replace(session, runs=runs), quick=True)
    assert found.closure.held_out_runs == ("run_02.csv",)
    assert found.closure.joint_angle.closed == pytest.approx(1.0, abs=0.02)


def test_closure_is_never_taken_on_runs_that_were_fitted() -> None:
    """One motion and its repeat: both are fitted, so before and after are told, and no closure."""
    session = make_session(bench(1), ["rate_limit:limit_rad_s=1.3"], gaits=GAITS[:1])
    found = diagnose(session, quick=True)
    assert found.closure.held_out_runs == ()
    angle = found.closure.joint_angle
    assert angle.closed is None
    assert angle.ci95 is None
    assert angle.reason is not None
    assert "no run is held out" in angle.reason
    assert angle.rms_after < 0.1 * angle.rms_before
    assert found.causes[0].closure_alone is None
    told = "\n".join(summary(found))
    assert "the error on the runs it was fitted to falls" in told
    assert "not fitted to" not in told
    html = page(session, found)
    assert angle.reason in html
    assert "Runs: none held out." in html
    assert "no parameter was fitted to" not in html
    jsonschema.validate(json.loads(json.dumps(found.to_mapping(), allow_nan=False)), json_schema())


def test_one_motion_over_ground_has_no_closure_of_speed() -> None:
    session = make_session(snake(), ["ground_friction:ct_scale=3"], gaits=GAITS[:1], pose=True)
    found = diagnose(session, quick=True, only=["ground_friction"])
    assert found.causes[0].effect == "ground_friction"
    speed = found.closure.forward_speed
    assert speed is not None
    assert speed.closed is None
    assert speed.reason is not None
    assert "no run is held out" in speed.reason
    assert found.closure.ground is None
    assert speed.error_after < speed.error_before
    assert any(
        "the error of the forward speed on the runs it was fitted to" in line for line in summary(found)
    )


def test_stretches_without_power_are_not_fitted() -> None:
    robot = bench(1)
    runs = []
    for run in make_session(robot).runs:
        off = (run.t_s > 2.0) & (run.t_s < 3.5)
        command = np.where(off[:, None], np.nan, run.command_rad)
        hanging = -0.8 * np.sin(9 * run.t_s)[:, None]
        made = predict(
            robot, (), run.t_s, command, measured_rad=np.where(off[:, None], hanging, run.command_rad)
        )
        reading = np.where(off[:, None], hanging, made.encoder_rad)
        runs.append(replace(run, command_rad=command, measured_rad=reading))
    found = diagnose(Session(robot, tuple(runs)), quick=True)
    assert found.verdict == "no_gap"
    assert any("off in 25%" in warning for warning in found.warnings)


@pytest.mark.slow
def test_lost_set_points_say_nothing_of_the_ground() -> None:
    """The readings are samples: between them a servo that misses set-points jumps, and the body with it."""
    robot, runs = snake(), []
    for number, run in enumerate(make_session(robot, pose=True).runs):
        lost = np.random.default_rng(number).random(len(run)) < 0.4
        lost[0] = False
        arrived = run.command_rad[np.maximum.accumulate(np.where(lost, 0, np.arange(len(run))))]
        made = predict(robot, (), run.t_s, arrived)
        assert made.motion is not None
        slower = np.column_stack([0.8 * made.motion.com_m, made.motion.heading_rad])
        runs.append(replace(run, measured_rad=made.encoder_rad, pose=slower))
    found = diagnose(Session(robot, tuple(runs)), quick=True)
    assert [cause.effect for cause in found.causes] == ["command_loss"]
    assert found.verdict == "explained"
    assert found.unexplained.share == 0.0
    (warning,) = (w for w in found.warnings if "motion over ground" in w)
    assert warning.startswith("servos jump between samples too much")
    assert found.closure.forward_speed is not None
    assert found.closure.forward_speed.closed is None
    assert found.closure.forward_speed.reason == warning
    assert [step.forward_speed_closed for step in found.closure.steps] == [None]
    assert "falls from" not in summary(found)


@pytest.mark.parametrize("exclude", [(), ("encoder_noise",)])
def test_noisy_encoders_say_nothing_of_the_ground_whether_they_may_be_named_or_not(
    exclude: tuple[str, ...],
) -> None:
    runs = [
        replace(run, pose=run.pose * [0.8, 0.8, 1.0])
        for run in make_session(snake(), pose=True, noise_deg=1.5).runs
        if run.pose is not None
    ]
    found = diagnose(Session(snake(), tuple(runs)), exclude=exclude, quick=True)
    assert [cause.effect for cause in found.causes] == ([] if exclude else ["encoder_noise"])
    assert found.verdict == ("unexplained" if exclude else "explained")
    assert any(warning.startswith("the encoders are too noisy") for warning in found.warnings)


def test_jumps_of_servos_that_miss_set_points_are_no_noise_of_encoders() -> None:
    """The quicker the servos, the more their readings scatter from sample to sample."""
    robot = bench(2)
    robot = robot.model_copy(update={"servo": robot.servo.model_copy(update={"time_constant_s": 0.005})})
    session = Session(robot, lossy_session(robot, 0.5).runs[:3])
    data = prepare(session)
    assert noisy_encoders(data, gather(data).floor) is not None
    assert [cause.effect for cause in diagnose(session, quick=True).causes] == ["command_loss"]


@pytest.mark.parametrize("probability", [pytest.param(0.1, marks=pytest.mark.slow), 0.4])
def test_lost_set_points_are_found_in_the_scatter(probability: float) -> None:
    robot = bench(3)
    runs = lossy_session(robot, probability).runs
    found = diagnose(Session(robot, runs[:3]), quick=True)
    (cause,) = found.causes
    assert cause.effect == "command_loss"
    assert cause.probability == SURE
    assert cause.parameters["probability"].estimate == pytest.approx(probability, rel=0.25)
    alone = diagnose(Session(robot, (runs[0],)), quick=True)
    assert all(cause.probability <= 0.5 for cause in alone.causes)
