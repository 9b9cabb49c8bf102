"""One wire takes the commands to all joints: delays of the joints' own become one, where that foretells as well."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.search.library import usable_effects
from snakebot.diagnosis.search.wire import of_one_wire

GAITS = ((66, 80, 2.0), (30, 80, 4.0), (50, 60, 1.0), (40, 80, 6.0))
LAGS = "servo_lag:time_constant_s=0.05+0.065+0.042,joints=1+2+3"


def told_of_one_wire(delay: str) -> tuple[Trial, Trial]:
    """What two joints' own delays, with a lag of the third, become where the robot has ``delay``, and lags."""
    evidence = gather(prepare(make_session(bench(3), (LAGS, delay), gaits=GAITS)))
    library = usable_effects(evidence.data, over_ground=False)
    delays, lag = Term("command_delay", (1, 2), own=True), Term("servo_lag", (3,))
    best = run_trial(evidence, Hypothesis((delays, lag)), [np.array([0.03, 0.03, 0.04])])
    return of_one_wire(evidence, library, best), best


def test_delays_of_some_joints_are_one_delay_of_the_wire_and_the_lags_come_back() -> None:
    found, _ = told_of_one_wire("command_delay:delay_s=0.025")
    terms = {term.effect: term.joints for term in found.hypothesis.terms}
    assert terms == {"command_delay": None, "servo_lag": (1, 2, 3)}
    values = dict(zip(terms, found.hypothesis.split(found.theta), strict=True))
    assert values["command_delay"] == pytest.approx([0.025], abs=0.002)
    assert values["servo_lag"] == pytest.approx([0.05, 0.065, 0.042], abs=0.003)


def test_delays_that_differ_stay_the_joints_own() -> None:
    found, best = told_of_one_wire("command_delay:delay_s=0.01+0.06,joints=1+2")
    assert found is best
