"""Which effects are tried."""

from __future__ import annotations

from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.trial import nominal_trial
from snakebot.diagnosis.search.candidates import candidates
from snakebot.diagnosis.search.library import usable_effects


def test_where_nothing_is_left_no_effect_is_tried_beside_it() -> None:
    evidence = gather(prepare(make_session(snake(), duration_s=3.0)))
    nominal = nominal_trial(evidence)
    assert not gap_of(evidence.scoring, nominal.held_square).any
    library = usable_effects(evidence.data, over_ground=False)
    for effect in library.effects:
        if effect.stage != "body" and effect.per_joint and effect.name != "wiring":
            assert candidates(evidence, library, nominal, effect) == []
