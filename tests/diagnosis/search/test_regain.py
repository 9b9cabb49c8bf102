"""Everyday effects that a joint was left without come back where they help, joint by joint, and not otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.search.candidates import kinds
from snakebot.diagnosis.search.library import Library, usable_effects
from snakebot.diagnosis.search.regain import regained
from snakebot.effects.registry import find_effect

GAITS = ((66, 80, 2.0), (30, 80, 4.0), (50, 60, 1.0))
WORN = (
    "servo_offset:offset_deg=1.5+-2+0.8,joints=1+2+3",
    "backlash:width_deg=2+3,joints=1+3",
    "servo_lag:time_constant_s=0.05,joints=2",
)


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return gather(prepare(make_session(bench(3), WORN, gaits=GAITS)))


@pytest.fixture(scope="module")
def library(evidence: Evidence) -> Library:
    return usable_effects(evidence.data, over_ground=False)


def explained_by(evidence: Evidence, library: Library, **joints: tuple[int, ...]) -> Trial:
    """Everyday effects on some joints, fitted to data of joints that have more of them."""
    terms = tuple(
        Term(name, where, kinds(library, find_effect(name))[0], own=len(where) > 1)
        for name, where in joints.items()
    )
    begin = [find_effect(t.effect).parameters[0].typical for t in terms for _ in t.joints or ()]
    return run_trial(evidence, Hypothesis(terms), [np.array(begin)])


def where(trial: Trial) -> dict[str, tuple[int, ...] | None]:
    return {term.effect: term.joints for term in trial.hypothesis.terms}


def test_what_joints_were_left_without_comes_back_to_each_of_them(
    evidence: Evidence, library: Library
) -> None:
    best = explained_by(evidence, library, servo_offset=(1, 2), backlash=(1,))
    assert where(regained(evidence, library, best)) == {
        "servo_offset": (1, 2, 3),
        "backlash": (1, 3),
        "servo_lag": (2,),
    }


def test_nothing_comes_back_where_nothing_is_missing(evidence: Evidence, library: Library) -> None:
    best = explained_by(evidence, library, servo_offset=(1, 2, 3), backlash=(1, 3), servo_lag=(2,))
    assert regained(evidence, library, best) is best


def test_an_effect_that_is_there_in_another_kind_stays_as_it_is(evidence: Evidence, library: Library) -> None:
    hard = Term("deadband", (1,), (("hard", 1.0),))
    plain = Term("deadband", (2, 3), kinds(library, find_effect("deadband"))[0], own=True)
    best = run_trial(evidence, Hypothesis((hard, plain)), [np.array([1.0, 1.0, 1.0])])
    found = regained(evidence, library, best).hypothesis.terms
    assert [term for term in found if term.effect == "deadband"] == [hard, plain]
    assert len(found) > 2
