"""The end of the search: a rival that clearly does better than what was found is the answer."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial, against_nominal, run_trial
from snakebot.diagnosis.search import search
from snakebot.diagnosis.search.library import usable_effects

TRUE = Hypothesis((Term("rate_limit", (1,)),))


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> Any:
    """What is found of a speed limit by who knows of lags alone, with the limit among the rivals."""
    nominal, evidence = against_nominal(
        gather(prepare(make_session(bench(), ("rate_limit:limit_rad_s=1.2,joints=1",))))
    )
    library = usable_effects(evidence.data, over_ground=False, only=("servo_lag",))
    true = run_trial(evidence, TRUE, [np.array([1.2])])
    monkeypatch.setattr(search, "rivals", lambda *_: ((true,),))
    return lambda: search.search(evidence, library, nominal).best


def test_it_is_the_answer(found: Any) -> None:
    assert found().hypothesis == TRUE


@pytest.mark.timeout(60)
def test_but_not_where_plain_words_lead_back(found: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """As of joints that bend, told as dry friction of some of them, of which the plain name is that they bend."""
    first: list[Trial] = []

    def back(
        evidence: object, library: object, nominal: object, best: Trial
    ) -> tuple[Trial, tuple[Trial, ...]]:
        first.append(best)
        return first[0], ()

    monkeypatch.setattr(search, "in_fewest_words", back)
    assert found().hypothesis != TRUE
    assert len(first) == 2
