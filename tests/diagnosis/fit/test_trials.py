"""Explanations as data, and their trials."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import bench, make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import FAR_BEHIND, run_trial, run_trial_against


def test_a_hypothesis_gives_the_specs_it_names() -> None:
    hypothesis = Hypothesis((Term("rate_limit", (2,)), Term("command_delay", None)))
    assert [str(spec) for spec in hypothesis.specs([1.5, 0.02])] == [
        "rate_limit:limit_rad_s=1.5,joints=2",
        "command_delay:delay_s=0.02",
    ]
    assert hypothesis.joints(3) == (1, 2, 3)
    assert hypothesis.without(1).joints(3) == (2,)


def test_held_out_squares_are_worse_than_fitted_ones_for_an_effect_that_is_not_there() -> None:
    evidence = gather(prepare(make_session(bench(1))))
    trial = run_trial(evidence, Hypothesis((Term("second_order", None),)), [np.array([60.0, 1.0])])
    assert trial.held_square.mean() >= trial.fitted_square.mean()


def test_a_trial_that_is_far_behind_is_given_up_and_one_that_is_near_is_held_out() -> None:
    evidence = gather(prepare(make_session(snake(), ["compliance:stiffness_nm_rad=15"], duration_s=4.0)))
    bends, sticks = Hypothesis((Term("compliance", None),)), Hypothesis((Term("joint_friction", (3,)),))
    best = run_trial(evidence, bends, [np.array([15.0])])
    far = run_trial_against(evidence, best, sticks, [np.array([0.1, 60.0])])
    assert far.held_square is far.fitted_square
    assert far.score(evidence.scoring) < best.score(evidence.scoring) - FAR_BEHIND
    near = run_trial_against(evidence, best, bends, [np.array([17.0])])
    assert near.held_square is not near.fitted_square
    assert near.theta == pytest.approx(best.theta, rel=0.02)
    apart = Hypothesis(
        (Term("command_delay", None),)
    )  # takes no body, and little time: whole, however far behind
    whole = run_trial_against(evidence, best, apart, [np.array([0.01])])
    assert whole.held_square is not whole.fitted_square
