"""Joints on which an effect came to nothing are not named."""

from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.search.idle import without_idle

WORN = ("servo_offset:offset_deg=1.5+-2+0.8,joints=1+2+3", "backlash:width_deg=2+3,joints=1+3")
OFFSETS = Term("servo_offset", (1, 2, 3), own=True)
PLAY = Term("backlash", (1, 2, 3), (("loaded", 0.0),), own=True)


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return gather(prepare(make_session(bench(3), WORN)))


@pytest.fixture(scope="module")
def fitted(evidence: Evidence) -> Trial:
    """Offsets and play of every joint, of which joint 2 has no play."""
    return run_trial(evidence, Hypothesis((OFFSETS, PLAY)), [np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0])])


def with_play_of_joint_2(fitted: Trial, width_deg: float) -> Trial:
    theta = fitted.theta.copy()
    theta[4] = width_deg
    return replace(fitted, theta=theta)


def test_a_joint_without_play_is_not_said_to_have_any(evidence: Evidence, fitted: Trial) -> None:
    less = without_idle(evidence, with_play_of_joint_2(fitted, 0.0))
    assert [term.joints for term in less.hypothesis.terms] == [(1, 2, 3), (1, 3)]
    assert less.theta[3:] == pytest.approx(fitted.theta[[3, 5]], rel=0.02)


def test_of_one_joint_that_is_left_no_values_of_its_own_are_told(evidence: Evidence, fitted: Trial) -> None:
    theta = fitted.theta.copy()
    theta[4:] = 0.0
    one = replace(fitted, theta=theta, held_square=100 * fitted.held_square)
    offsets, play = without_idle(evidence, one).hypothesis.terms
    assert (offsets.own, play) == (True, replace(PLAY, joints=(1,), own=False))


def test_a_little_play_stays(evidence: Evidence, fitted: Trial) -> None:
    some = with_play_of_joint_2(fitted, 0.1)
    assert without_idle(evidence, some) is some


def test_an_effect_that_no_joint_has_goes(evidence: Evidence, fitted: Trial) -> None:
    theta = fitted.theta.copy()
    theta[3:] = 0.0
    nothing = replace(fitted, theta=theta, held_square=100 * fitted.held_square)
    assert without_idle(evidence, nothing).hypothesis.names == ("servo_offset",)


def test_what_motions_left_out_speak_for_stays(evidence: Evidence, fitted: Trial) -> None:
    """Zero in the fit to all, and yet better with it on motions left out."""
    theta = fitted.theta.copy()
    theta[3:] = 0.0
    foretells = replace(fitted, theta=theta)
    assert without_idle(evidence, foretells) is foretells
