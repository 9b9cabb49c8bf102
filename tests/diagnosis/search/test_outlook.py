"""What an effect promises, before it is fitted."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.fit.hypothesis import Term
from snakebot.diagnosis.fit.trial import Trial, nominal_trial
from snakebot.diagnosis.search.candidate import Candidate, added
from snakebot.diagnosis.search.outlook import promise, promising
from snakebot.diagnosis.sizes import LITTLE
from snakebot.effects.observed import Observed
from snakebot.effects.registry import find_effect

LIMIT_RAD_S = 1.2  # of joint 2, which the gaits want to turn faster


@pytest.fixture(scope="module")
def slow_joint() -> tuple[Evidence, Trial]:
    session = make_session(snake(), [f"rate_limit:limit_rad_s={LIMIT_RAD_S},joints=2"])
    evidence = gather(prepare(session))
    return evidence, nominal_trial(evidence)


def of_joint_2(base: Trial, effect: str, value: float) -> Candidate:
    return added(base, Term(effect, (2,)), [np.array([value])])


def test_the_cause_promises_most_also_from_a_start_that_is_off(slow_joint: tuple[Evidence, Trial]) -> None:
    evidence, base = slow_joint
    true = promise(evidence, base, of_joint_2(base, "rate_limit", LIMIT_RAD_S))
    off = promise(evidence, base, of_joint_2(base, "rate_limit", 1.3 * LIMIT_RAD_S))
    other = promise(evidence, base, of_joint_2(base, "servo_offset", 0.5))
    assert 0 < other < LITTLE * true
    assert off > LITTLE * true


def test_what_does_nothing_or_the_opposite_promises_nothing(slow_joint: tuple[Evidence, Trial]) -> None:
    evidence, base = slow_joint
    assert promise(evidence, base, of_joint_2(base, "rate_limit", 50.0)) == pytest.approx(0.0, abs=1e-3)
    assert promise(evidence, base, of_joint_2(base, "command_gain", 1.2)) < 0


def test_only_what_promises_a_share_of_the_best_is_fitted(slow_joint: tuple[Evidence, Trial]) -> None:
    evidence, base = slow_joint
    cause = of_joint_2(base, "rate_limit", 1.1 * LIMIT_RAD_S)
    idle, against = of_joint_2(base, "servo_offset", 0.5), of_joint_2(base, "command_gain", 1.2)
    over_ground = added(base, Term("slope", None), [np.array([1.0])])
    nothing_open = added(base, Term("joint_free", (2,)), [np.zeros(0)])
    everything = [cause, idle, against, over_ground, nothing_open]
    assert promising(evidence, base, everything) == [cause, over_ground, nothing_open]
    assert promising(evidence, base, []) == []


def test_a_torque_limit_starts_where_the_measured_motion_never_bore_more() -> None:
    """Within what smoothing makes of torque that is cut off. Of several joints: where none bore more."""
    limit_nm = 1.5
    session = make_session(snake(), [f"torque_limit:limit_nm={limit_nm}"])
    observed = Observed(session.robot, session.runs)
    every = tuple(range(session.robot.joints))
    first, second = find_effect("torque_limit").starts(observed, every)
    assert first["limit_nm"] == pytest.approx(limit_nm, rel=0.2)
    assert second["limit_nm"] == pytest.approx(0.9 * float(first["limit_nm"]))  # type: ignore[arg-type]
    assert observed.most(observed.top_load_nm, every, 1.0) == observed.top_load_nm.max()
    assert observed.most(np.full(2, np.nan), (0, 1), 7.0) == 7.0
