"""Explanations as data, and their trials."""

from __future__ import annotations

import numpy as np
from sessions import bench, make_session

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import run_trial


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
