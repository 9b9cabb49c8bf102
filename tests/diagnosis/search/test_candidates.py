"""Which effects are tried."""

from __future__ import annotations

import numpy as np
from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.trial import nominal_trial
from snakebot.diagnosis.search.candidates import candidates
from snakebot.diagnosis.search.library import usable_effects
from snakebot.effects.registry import find_effect


def test_where_nothing_is_left_no_effect_is_tried_beside_it() -> None:
    evidence = gather(prepare(make_session(snake(), duration_s=3.0)))
    nominal = nominal_trial(evidence)
    assert not gap_of(evidence.scoring, nominal.held_square).any
    library = usable_effects(evidence.data, over_ground=False)
    for effect in library.effects:
        if effect.stage != "body" and effect.per_joint and effect.name != "wiring":
            assert candidates(evidence, library, nominal, effect) == []


def test_a_limit_that_is_met_in_a_few_moments_of_one_motion_is_tried() -> None:
    """What it gains there differs from second to second by far more than what noise is made of."""
    sag = "voltage_sag:initial_rad_s=2.9,drop_per_s=0.058,joints=2"
    session = make_session(
        snake(), [sag], gaits=((40, 80, 2.0), (30, 80, 4.0), (50, 60, 1.0)), duration_s=10.0
    )
    evidence = gather(prepare(session))
    nominal = nominal_trial(evidence)
    blocks = evidence.angles.blocks
    beyond = evidence.angles.mean_square(nominal.readings) > 5 * evidence.angles.allowed_square
    assert {session.runs[i].gait for i in blocks.run[beyond]} == {session.runs[1].gait}
    assert beyond.sum() == 3
    library = usable_effects(evidence.data, over_ground=False)
    tried = candidates(evidence, library, nominal, find_effect("voltage_sag"))
    assert [c.hypothesis.terms[0].joints for c in tried] == [(2,)]
    assert np.allclose(tried[0].starts[0], (2.9, 0.058), rtol=0.05)
