"""A cause takes something of the gap away on motions that it was not fitted to, whatever the score says of it."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import against_nominal, trial_at
from snakebot.diagnosis.options import Options
from snakebot.diagnosis.search.search import SearchResult
from snakebot.diagnosis.verdict.decision import judge
from snakebot.diagnosis.verdict.rest import brings_nearer, rest_of


@pytest.mark.parametrize(("offset_deg", "closes"), [(-0.5, False), (0.5, True)])
def test_an_explanation_that_closes_nothing_is_none(offset_deg: float, closes: bool) -> None:
    robot_off = ["servo_offset:offset_deg=3", "backlash:width_deg=1"]
    nominal, evidence = against_nominal(gather(prepare(make_session(bench(3), robot_off))))
    offset = trial_at(evidence, Hypothesis((Term("servo_offset", None),)), np.array([offset_deg]))
    found = SearchResult(evidence, nominal, offset, singles=(offset,), rivals=((),), path=(nominal, offset))
    assert brings_nearer(evidence, nominal, offset, rest_of(evidence, nominal, offset)) == closes
    judgement = judge(evidence, found, Options())
    assert judgement.verdict == "unexplained"
    assert judgement.best is (offset if closes else nominal)
    assert judgement.rest.share == (pytest.approx(1.0) if not closes else pytest.approx(0.7, abs=0.1))
