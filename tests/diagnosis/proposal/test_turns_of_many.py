"""Where joints have values of their own, the turns of an explanation are worked out for all joints at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import trial_at
from snakebot.diagnosis.proposal.menu import menu
from snakebot.diagnosis.proposal.separation import SimulatedMotion, directions

ALL = (1, 2, 3, 4, 5)


def test_they_are_what_each_direction_alone_changes() -> None:
    """Beside a torque limit a joint's own value changes others a little: that much is left out."""
    evidence = gather(prepare(make_session(snake(), ["torque_limit:limit_nm=1.0"], pose=True)))
    hypothesis = Hypothesis(
        (
            Term("torque_limit", None),
            Term("servo_offset", ALL, own=True),
            Term("encoder_gain", ALL, own=True),
        )
    )
    theta = np.array([0.9, *np.linspace(-0.5, 0.5, 5), *np.linspace(0.96, 1.04, 5)])
    spread = np.array([0.01, *np.full(5, 0.02), *np.full(5, 0.003)])
    trial = replace(trial_at(evidence, hypothesis, theta), covariance=np.diag(np.square(spread)))
    motion = SimulatedMotion(evidence, menu(evidence.data.robot, ALL, loads=True)[3], over_ground=True)
    fit = motion.at_fit(trial)
    turns = motion.with_turns(trial, fit).turns
    steps = directions(trial)
    assert len(turns) == len(steps) == 11
    for (angle, ground), step in zip(turns, steps, strict=True):
        alone, over = motion.shown(hypothesis.specs(theta + step))
        change = alone - fit.angle
        assert np.sqrt(np.mean(np.square(angle - change))) < 0.05 * np.sqrt(np.mean(np.square(change)))
        assert (ground is None) == (over is None) == (not motion.measures_ground)


def test_the_same_value_of_joints_that_each_have_their_own_stands_side_by_side() -> None:
    hypothesis = Hypothesis((Term("second_order", (2, 4), own=True), Term("servo_lag", None)))
    assert hypothesis.side_by_side == [[0, 2], [1, 3], [4]]
