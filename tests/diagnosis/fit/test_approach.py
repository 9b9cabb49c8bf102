"""Where a fit begins whose joints disturb each other: each joint goes its own way under the torques so far."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.fit.fit_runs import angle_problem, specs_from
from snakebot.diagnosis.fit.hypothesis import Box, Hypothesis, Term
from snakebot.diagnosis.fit.least_squares import approach, minimise
from snakebot.diagnosis.fit.step import Problem, Weights

EACH = (1, 2, 3, 4, 5)
HYPOTHESIS = Hypothesis((Term("compliance", EACH, own=True), Term("servo_offset", EACH, own=True)))
STIFFNESS_NM_RAD, OFFSET_DEG = (20.0, 45.0, 30.0, 60.0, 25.0), (1.0, -0.8, 0.6, 0.4, -1.2)
START = np.array([30.0] * 5 + [0.0] * 5)


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    effects = [
        f"{name}={'+'.join(map(str, values))},joints=1+2+3+4+5"
        for name, values in (
            ("compliance:stiffness_nm_rad", STIFFNESS_NM_RAD),
            ("servo_offset:offset_deg", OFFSET_DEG),
        )
    ]
    return gather(prepare(make_session(snake(), effects, duration_s=4.0)))


@pytest.fixture
def problem(evidence: Evidence) -> Problem:
    every = np.ones(START.size, dtype=bool)
    found = angle_problem(
        evidence.angles, evidence.predictor.simulator, HYPOTHESIS, specs_from(HYPOTHESIS, START, every),
        evidence.split.free, Box.of(HYPOTHESIS.parameters), rough=False, mine=every, at=START,
    )  # fmt: skip
    assert found is not None
    return found


def cost(problem: Problem, theta: np.ndarray) -> float:
    return float(Weights(problem).cost(problem.residual(theta))[0].sum())


def test_it_leads_near_the_minimum_in_a_few_motions(problem: Problem) -> None:
    start = problem.for_each(START)
    motions = 0
    whole = problem.residual

    def counted(theta: np.ndarray) -> np.ndarray:
        nonlocal motions
        motions += 1
        return whole(theta)

    near = approach(replace(problem, residual=counted), start)
    assert motions <= 6
    end = minimise(problem, near, 12, covariance=False)
    assert cost(problem, near) < cost(problem, start)
    assert cost(problem, near) == pytest.approx(float(end.cost.sum()), rel=0.02)
    assert near[0, 5:] == pytest.approx(OFFSET_DEG, abs=0.1)


def test_it_never_begins_where_more_is_left(problem: Problem) -> None:
    good = problem.for_each(np.array([*STIFFNESS_NM_RAD, *OFFSET_DEG]))
    assert cost(problem, approach(problem, good)) <= cost(problem, good)


def test_without_a_problem_near_by_it_stays(problem: Problem) -> None:
    start = problem.for_each(START)
    assert approach(replace(problem, near=None), start) is start
    some = np.arange(START.size) > 0
    assert approach(replace(problem, near_for=some), start) is start
