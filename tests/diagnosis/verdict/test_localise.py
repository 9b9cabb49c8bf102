"""Where the gap lies: angles and the motion over ground are weighed by what is allowed of each."""

from __future__ import annotations

import pytest
from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.trial import against_nominal
from snakebot.diagnosis.verdict.localise import shares

RUBS = "ground_friction:ct_scale=2,cn_scale=0.5"


@pytest.mark.parametrize(
    ("effects", "stage"),
    [
        ([RUBS], "body"),
        (["servo_offset:offset_deg=2,joints=2"], "servo"),
        ([RUBS, "servo_offset:offset_deg=2,joints=2"], "servo"),
    ],
)
def test_a_fault_of_a_joint_is_no_gap_of_a_body_that_rubs_a_little_otherwise(
    effects: list[str], stage: str
) -> None:
    nominal, evidence = against_nominal(gather(prepare(make_session(snake(), effects, pose=True))))
    gap = gap_of(evidence.scoring, nominal.held_square)
    found = shares(evidence, gap, nominal, [])
    assert found.largest() == stage
    assert found.body + found.servo + found.link + found.sensor == pytest.approx(1.0, abs=1e-3)
    assert (found.body > 0) == (RUBS in effects)
