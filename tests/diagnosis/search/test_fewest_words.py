"""The end of the search: taken out is what can be spared, and said plainly is what stays, until neither changes it."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import nominal_trial, run_trial
from snakebot.diagnosis.search import search
from snakebot.diagnosis.search.library import usable_effects
from snakebot.diagnosis.search.search import in_fewest_words


@pytest.mark.parametrize("beside", [(), ("joint_free",)])
def test_a_motor_of_hardly_any_torque_is_a_free_joint_whatever_stood_beside_it(
    beside: tuple[str, ...],
) -> None:
    """A limit beside a free joint of the same place says nothing; taken out, either may be left."""
    session = make_session(
        snake(), ["joint_free:joints=3"], gaits=((66, 80, 2.0), (40, 80, 1.0)), duration_s=3.0
    )
    evidence = gather(prepare(session))
    library = usable_effects(evidence.data, over_ground=False)
    starts = {"torque_limit": [0.01], "joint_free": []}
    names = ("torque_limit", *beside)
    hypothesis = Hypothesis(tuple(Term(name, (3,)) for name in names))
    limited = run_trial(evidence, hypothesis, [np.array([v for name in names for v in starts[name]])])
    best, without = in_fewest_words(evidence, library, nominal_trial(evidence), limited)
    assert best.hypothesis.names == ("joint_free",)
    assert without == ()


def test_what_is_left_of_two_plain_names_is_said_plainly_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a free joint that was first told as a torque limit and a motor that slows."""
    plainer = {"limit + slow": "free + limit", "limit": "free"}
    less = {"free + limit": "limit"}
    monkeypatch.setattr(search, "prune", lambda evidence, best: (less.get(best, best), (best,)))
    monkeypatch.setattr(
        search, "said_plainly", lambda evidence, library, nominal, best: plainer.get(best, best)
    )
    found: object = in_fewest_words(None, None, None, "limit + slow")  # type: ignore[arg-type]
    assert found == ("free", ("free",))
