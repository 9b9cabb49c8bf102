"""Rivals of a term: another effect in its place, though the rest has that effect on other joints."""

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.search.library import usable_effects
from snakebot.diagnosis.search.rivals import rivals

LAGS = ("servo_lag:time_constant_s=0.08+0.07,joints=1+2",)
SLOW = ((60, 80, 0.5), (40, 60, 0.8), (50, 70, 1.0))  # so slow that a lag and a delay are alike


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return gather(prepare(make_session(bench(3), LAGS, gaits=SLOW)))


def rivals_of(
    evidence: Evidence, hypothesis: Hypothesis, start: list[float]
) -> tuple[tuple[Trial, ...], ...]:
    best = run_trial(evidence, hypothesis, [np.array(start)])
    without = [
        run_trial(evidence, hypothesis.without(i), [hypothesis.rest(best.theta, i)])
        for i in range(len(hypothesis.terms))
    ]
    library = usable_effects(evidence.data, over_ground=False, only=("command_delay", "servo_lag"))
    return rivals(evidence, library, best, [], {}, [], without, lambda text, share: None)


def test_a_lag_of_one_joint_more_is_a_rival_of_its_delay(evidence: Evidence) -> None:
    said = Hypothesis((Term("command_delay", (1,)), Term("servo_lag", (2,))))
    of_delay, of_lag = rivals_of(evidence, said, [0.04, 0.07])
    (lags,) = (t for t in of_delay if t.hypothesis.names == ("servo_lag",))
    assert lags.hypothesis.terms == (Term("servo_lag", (1, 2), own=True),)
    assert lags.theta == pytest.approx([0.08, 0.07], abs=0.005)
    (delays,) = (t for t in of_lag if t.hypothesis.names == ("command_delay",))
    assert delays.hypothesis.terms == (Term("command_delay", (1, 2), own=True),)


def test_a_joint_that_has_both_keeps_the_other(evidence: Evidence) -> None:
    said = Hypothesis(
        (Term("command_delay", (1, 2), own=True), Term("servo_lag", (2, 3), own=True)),
    )
    of_delay, _ = rivals_of(evidence, said, [0.04, 0.01, 0.05, 0.03])
    (lags,) = (t for t in of_delay if t.hypothesis.names == ("servo_lag",))
    assert lags.hypothesis.terms == (Term("servo_lag", (1, 2, 3), own=True),)


def test_an_effect_that_the_rest_does_not_have_is_on_the_same_joints(evidence: Evidence) -> None:
    said = Hypothesis((Term("command_delay", (1, 2), own=True), Term("servo_offset", (3,))))
    of_delay, _ = rivals_of(evidence, said, [0.04, 0.03, 0.1])
    (lags,) = (t for t in of_delay if "command_delay" not in t.hypothesis.names)
    assert lags.hypothesis.terms == (Term("servo_offset", (3,)), Term("servo_lag", (1, 2), own=True))


def test_the_joint_that_an_effect_does_most_for_may_have_another() -> None:
    lags = "servo_lag:time_constant_s=0.09+0.05,joints=1+2"
    evidence = gather(prepare(make_session(bench(3), (lags,), gaits=SLOW)))
    said = Hypothesis((Term("command_delay", (1, 2, 3), own=True), Term("servo_offset", (3,))))
    of_delay, _ = rivals_of(evidence, said, [0.04, 0.03, 0.001, 0.1])
    (one,) = (t for t in of_delay if "command_delay" in t.hypothesis.names)
    offset, delay, lag = one.hypothesis.terms
    assert (delay, lag) == (Term("command_delay", (2, 3), own=True), Term("servo_lag", (1,)))
    assert offset == Term("servo_offset", (3,))


def test_what_most_joints_have_anyway_is_no_rival(evidence: Evidence) -> None:
    """A gain that does nothing would tie with a lag that is there with it and without it."""
    said = Hypothesis((Term("command_delay", (1, 2), own=True), Term("servo_lag", (1, 2, 3), own=True)))
    of_delay, of_lag = rivals_of(evidence, said, [0.01, 0.01, 0.05, 0.05, 0.03])
    assert of_delay == of_lag == ()
