"""Slopes under the torques of the motion at hand stand in for those that take a simulation of the body each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.fit import fit_runs
from snakebot.diagnosis.fit.fit_runs import angle_problem, specs_from
from snakebot.diagnosis.fit.hypothesis import Box, Hypothesis, Term
from snakebot.diagnosis.fit.step import Problem, from_scale, jacobian_at, to_scale

EACH = (1, 2, 3, 4, 5)
LAGS = Term("servo_lag", EACH, own=True)
OFFSETS = Term("servo_offset", EACH, own=True)
LAG_S, OFFSET_DEG = [0.03, 0.04, 0.03, 0.05, 0.03], [0.5, -0.4, 0.3, 0.2, -0.5]


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return gather(prepare(make_session(snake(), ["compliance:stiffness_nm_rad=30"], duration_s=4.0)))


def problem_of(evidence: Evidence, hypothesis: Hypothesis, theta: list[float]) -> tuple[Problem, np.ndarray]:
    at, every = np.array(theta), np.ones(len(theta), dtype=bool)
    problem = angle_problem(
        evidence.angles, evidence.predictor.simulator, hypothesis,
        specs_from(hypothesis, at, every), evidence.split.free, Box.of(hypothesis.parameters),
        rough=False, mine=every, at=at,
    )  # fmt: skip
    assert problem is not None
    return problem, problem.for_each(at)


def slopes(problem: Problem, at: np.ndarray) -> np.ndarray:
    z = to_scale(at, problem)
    return jacobian_at(problem, z, problem.residual(from_scale(z, problem)))


@pytest.mark.parametrize(
    ("load", "values"),
    [("compliance", [30.0]), ("joint_friction", [0.3, 60.0]), ("torque_speed", [3.0, 5.0])],
)
def test_they_are_those_of_the_whole_body(evidence: Evidence, load: str, values: list[float]) -> None:
    hypothesis = Hypothesis((Term(load, None), LAGS, OFFSETS))
    problem, at = problem_of(evidence, hypothesis, [*values, *LAG_S, *OFFSET_DEG])
    assert problem.near is not None
    cheap, exact = slopes(problem, at), slopes(replace(problem, near=None), at)
    for mine, theirs in zip(cheap, exact, strict=True):
        assert np.vdot(mine, theirs) > 0.9 * np.linalg.norm(mine) * np.linalg.norm(theirs)
        assert np.linalg.norm(mine) == pytest.approx(np.linalg.norm(theirs), rel=0.15)


def test_a_limit_that_makes_a_joint_yield_has_slopes_of_its_own(evidence: Evidence) -> None:
    hypothesis = Hypothesis((Term("torque_limit", None), LAGS, OFFSETS))
    problem, at = problem_of(evidence, hypothesis, [2.0, *LAG_S, *OFFSET_DEG])
    assert problem.near_for is not None
    assert problem.near_for.tolist() == [False] + 10 * [True]
    cheap, exact = slopes(problem, at), slopes(replace(problem, near=None), at)
    assert np.array_equal(cheap[0], exact[0])


def test_few_parameters_beside_a_limit_are_worked_out_exactly(evidence: Evidence) -> None:
    hypothesis = Hypothesis((Term("torque_limit", None), LAGS))
    assert len(LAG_S) < fit_runs.MANY_PARAMETERS
    assert problem_of(evidence, hypothesis, [2.0, *LAG_S])[0].near is None


def test_no_body_is_simulated_for_joints_that_feel_no_load(evidence: Evidence) -> None:
    assert problem_of(evidence, Hypothesis((LAGS, OFFSETS)), [*LAG_S, *OFFSET_DEG])[0].near is None


def test_beside_a_limit_the_rest_can_be_fitted_about_a_motion_without_simulating_the_body(
    evidence: Evidence, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is left at that motion is what the body leaves there; slopes are those under its torques."""
    hypothesis = Hypothesis((Term("torque_limit", None), LAGS, OFFSETS))
    at = np.array([2.0, *LAG_S, *OFFSET_DEG])
    mine = np.arange(at.size) > 0
    problem = angle_problem(
        evidence.angles, evidence.predictor.simulator, hypothesis,
        specs_from(hypothesis, at, mine), evidence.split.free, Box.of(hypothesis.parameters).among(mine),
        rough=False, mine=mine, at=at,
    )  # fmt: skip
    assert problem is not None
    there = problem.for_each(at[mine])
    about = problem.about(there)
    assert about.residual(there) == pytest.approx(problem.residual(there), abs=1e-12)
    assert problem.near is not None
    assert slopes(about, there) == pytest.approx(slopes(problem.near(there), there), abs=1e-12)
    monkeypatch.setattr("snakebot.effects.servo_stage._on_a_body", None)
    away = there + 0.01
    some = np.arange(5) == 1
    assert about.residual_of(some, away)[:, 1] == pytest.approx(about.residual(away)[:, 1], abs=1e-12)
