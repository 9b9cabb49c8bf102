"""What comes by chance does not come again: losses that repeats would show are no explanation of what they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, lossy_session, make_session

from snakebot.diagnosis.engine import diagnose
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import trial_at
from snakebot.diagnosis.search.chance import too_random
from snakebot.runlog import Session

LOSS = Hypothesis((Term("command_loss", None),))


def evidence_of(session: Session) -> Evidence:
    return gather(prepare(session))


def loses(evidence: Evidence, probability: float) -> bool:
    return too_random(evidence, trial_at(evidence, LOSS, np.array([probability])))


@pytest.mark.parametrize("probability", [0.05, 0.2, 0.6])
def test_true_losses_show_between_repeats(probability: float) -> None:
    assert not loses(evidence_of(lossy_session(bench(3), probability)), probability)


def test_repeats_that_are_alike_lose_nothing() -> None:
    late = make_session(bench(3), ["command_delay:delay_s=0.015"])
    assert loses(evidence_of(late), 0.6)
    assert not loses(evidence_of(late), 1e-4)
    other = evidence_of(late)
    assert not too_random(
        other, trial_at(other, Hypothesis((Term("command_delay", None),)), np.array([0.015]))
    )


def test_without_repeats_nothing_is_known_of_chance() -> None:
    late = make_session(bench(3), ["command_delay:delay_s=0.015"])
    assert not loses(evidence_of(replace(late, runs=late.runs[:-1])), 0.6)


def test_a_delay_that_comes_again_is_not_said_to_be_lost_set_points() -> None:
    late = make_session(bench(3), ["servo_lag:time_constant_s=0.06", "command_delay:delay_s=0.01"])
    found = diagnose(late, quick=True)
    told = {name for cause in found.causes for name in (cause.effect, *cause.indistinguishable_from)}
    assert told
    assert "command_loss" not in told
