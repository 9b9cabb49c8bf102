"""No run is predicted from itself: what a fold says nothing of is absent there, and a cause seen once is untested."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, make_session, snake

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.fit.fit_runs import fit_runs
from snakebot.diagnosis.fit.fold_fits import _without_unmet
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.least_squares import SOME_STEPS
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.search.search import only_fitted
from snakebot.diagnosis.show.words import headline
from snakebot.robot import Robot
from snakebot.runlog import Run, Session

ONE_FAST = ((30, 80, 1.0), (40, 80, 4.0), (20, 80, 0.5))


def tried(robot: Robot, effect: str, term: Term, start: float, **options: object) -> tuple[Evidence, Trial]:
    """One explanation with one parameter, cross-validated on a session that has it."""
    evidence = gather(prepare(make_session(robot, [effect], **options)))  # type: ignore[arg-type]
    return evidence, run_trial(evidence, Hypothesis((term,)), [np.array([start])])


@pytest.fixture(scope="module")
def seen_once() -> Session:
    return make_session(bench(), ["rate_limit:limit_rad_s=1.5"], gaits=ONE_FAST)


def test_a_limit_that_one_run_reaches_is_absent_where_that_run_is_left_out() -> None:
    evidence, trial = tried(
        bench(1), "rate_limit:limit_rad_s=1.5", Term("rate_limit", None), 1.3, gaits=ONE_FAST
    )
    (fast,) = (i for i, run in enumerate(evidence.data.runs) if run.name == "run_02.csv")
    assert trial.theta == pytest.approx([1.5], rel=1e-3)
    assert np.isnan(trial.run_theta[fast]).all()
    assert trial.readings[fast] == pytest.approx(evidence.predictor.nominal[fast], abs=1e-12)
    mine = evidence.scoring.run == fast
    assert trial.held_square[mine].mean() > 100 * trial.fitted_square[mine].mean()
    others = [theta for i, theta in enumerate(trial.run_theta) if i != fast]
    assert np.concatenate(others) == pytest.approx(1.5, rel=1e-3)


@pytest.mark.parametrize(
    ("limit_rad_s", "found_rad_s", "stays"),
    [
        (5.0, 0.51, False),  # the fastest of the runs turns at 0.52 rad/s: it just does not meet it
        (5.0, 0.2, False),  # without it they are likelier
        (0.3, 0.3, True),
    ],
)
def test_a_limit_that_was_searched_for_stays_where_the_runs_are_less_likely_without_it(
    limit_rad_s: float, found_rad_s: float, stays: bool
) -> None:
    robot, hypothesis = bench(1), Hypothesis((Term("rate_limit", None),))
    evidence = gather(prepare(make_session(robot, [f"rate_limit:limit_rad_s={limit_rad_s}"], gaits=ONE_FAST)))
    slow = tuple(i for i, run in enumerate(evidence.data.runs) if run.name != "run_02.csv")
    found, searched = np.array([found_rad_s]), np.array([True])
    left = _without_unmet(evidence, hypothesis, found, searched, slow)
    assert np.array_equal(left, found if stays else [np.nan], equal_nan=True)
    assert np.array_equal(_without_unmet(evidence, hypothesis, found, ~searched, slow), found)


def test_joint_angles_say_nothing_of_what_is_over_ground() -> None:
    evidence = gather(prepare(make_session(snake(), ["slope:angle_deg=2"], duration_s=3.0)))
    hypothesis, found = Hypothesis((Term("slope", None),)), np.array([2.0])
    left = _without_unmet(evidence, hypothesis, found, np.array([True]), (0, 1))
    assert np.array_equal(left, found)


def test_where_every_fold_sees_a_parameter_its_fit_stands() -> None:
    evidence, trial = tried(bench(1), "rate_limit:limit_rad_s=0.3", Term("rate_limit", None), 0.3)
    for fold in evidence.split.folds:
        fit = fit_runs(evidence, trial.hypothesis, [trial.theta], fold.fit, SOME_STEPS)
        assert all(np.array_equal(trial.run_theta[i], fit.theta) for i in fold.score)


def test_the_same_where_the_whole_body_is_simulated() -> None:
    gaits = ((4, 80, 0.4), (66, 80, 4.0), (4, 60, 0.5))
    term = Term("torque_limit", None)
    _, trial = tried(snake(), "torque_limit:limit_nm=2.5", term, 2.5, gaits=gaits, duration_s=3.0)
    assert [bool(np.isnan(theta).any()) for theta in trial.run_theta] == [False, True, False, False]


def test_a_dead_band_that_swallows_whole_runs_is_there_but_its_width_is_not_known() -> None:
    gaits = ((4, 80, 2.0), (40, 80, 2.0), (5, 60, 1.0))
    term = Term("deadband", None, (("hard", 0.0),))
    _, trial = tried(bench(1), "deadband:width_deg=8", term, 8.0, gaits=gaits)
    assert trial.theta == pytest.approx([8.0], abs=0.05)
    assert (
        4.0 < trial.run_theta[1][0] < 6.0
    )  # what keeps 5 deg still; not the 8 that only the run left out tells


def test_a_body_effect_is_absent_where_no_other_run_has_a_pose() -> None:
    session = make_session(snake(), ["ground_friction:ct_scale=3"], pose=True, duration_s=4.0)
    runs = [run if run.name == "run_02.csv" else _blindfold(run) for run in session.runs]
    evidence = gather(prepare(Session(session.robot, tuple(runs))))
    fixed = tuple((f"{name}_scale", 1.0) for name in ("cn", "ct0", "cn0"))
    hypothesis = Hypothesis((Term("ground_friction", None, fixed),))
    trial = run_trial(evidence, hypothesis, [np.array([2.0])])
    assert [bool(np.isnan(theta).any()) for theta in trial.run_theta] == [False, True, False, False]


def _blindfold(run: Run) -> Run:
    return replace(run, pose=None)


def test_what_predicts_the_motion_left_out_worse_than_nothing_is_refuted_and_not_untested(
    seen_once: Session,
) -> None:
    evidence = gather(prepare(seen_once))
    nominal = run_trial(evidence, Hypothesis(()), [])
    shown = run_trial(evidence, Hypothesis((Term("rate_limit", None),)), [np.array([1.3])])
    assert only_fitted(evidence.scoring, nominal, [shown]) is shown
    refuted = replace(shown, held_square=10.0 * nominal.held_square)
    assert only_fitted(evidence.scoring, nominal, [refuted]) is nominal


def test_a_cause_that_one_motion_shows_is_a_guess_and_no_closure_is_told(seen_once: Session) -> None:
    found = diagnose(seen_once, quick=True)
    assert [cause.effect for cause in found.causes] == ["rate_limit"]
    (cause,) = found.causes
    assert cause.parameters["limit_rad_s"].estimate == pytest.approx(1.5, rel=0.01)
    assert cause.probability <= 0.5
    assert cause.closure_alone is None
    assert found.closure.held_out_runs == ()
    angle = found.closure.joint_angle
    assert angle.closed is None
    assert angle.reason is not None
    assert "one motion only may be fitted or shows it" in angle.reason
    assert angle.rms_after < 0.1 * angle.rms_before
    assert any("shows in one motion only, so nothing tests it" in warning for warning in found.warnings)
    assert headline(found).startswith("Explained (a guess): No joint can turn faster than 1.50 rad/s")


def test_delay_and_lag_that_few_runs_tell_apart_are_left_out_alike_with_the_body_and_under_its_torques(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside a torque limit the whole body would have to be simulated for each step of such a fit."""
    each = (1, 2, 3, 4, 5)
    terms = (Term("torque_limit", None), *(Term(n, each, own=True) for n in ("servo_lag", "command_delay")))
    start = np.array([2.5, *5 * [0.04], *5 * [0.01]])
    gaits = ((60, 80, 2.0), (66, 80, 3.0), (10, 60, 0.5))
    effects = ["torque_limit:limit_nm=2.5", "servo_lag:time_constant_s=0.045", "command_delay:delay_s=0.01"]
    evidence = gather(prepare(make_session(snake(), effects, gaits=gaits, duration_s=3.0)))
    refitted = []

    def kept(*args: object, **options: object) -> object:
        refitted.append(options.get("loads_of") is not None)
        return fit_runs(*args, **options)  # type: ignore[arg-type]

    def by_the_body(*args: object, loads_of: object = None, **options: object) -> object:
        return fit_runs(*args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("snakebot.diagnosis.fit.fold_fits.CLEAR", 150.0)  # as if the runs said little of any
    monkeypatch.setattr("snakebot.diagnosis.fit.fold_fits.fit_runs", kept)
    under_torques = run_trial(evidence, Hypothesis(terms), [start])
    assert any(refitted)
    monkeypatch.setattr("snakebot.diagnosis.fit.fold_fits.fit_runs", by_the_body)
    whole = run_trial(evidence, Hypothesis(terms), [start])
    score = evidence.scoring
    assert under_torques.score(score) == pytest.approx(whole.score(score), abs=0.02)


def test_what_every_motion_shows_a_little_of_does_not_hide_a_cause_that_one_motion_shows() -> None:
    """An offset is confirmed on motions left out, and closes next to nothing; the limit leaves next to nothing."""
    effects = ["rate_limit:limit_rad_s=1.5", "servo_offset:offset_deg=1,joints=1"]
    found = diagnose(make_session(bench(), effects, gaits=ONE_FAST), quick=True)
    assert [cause.effect for cause in found.causes] == ["rate_limit"]
    assert found.causes[0].probability <= 0.5
    assert any("shows in one motion only" in warning for warning in found.warnings)
