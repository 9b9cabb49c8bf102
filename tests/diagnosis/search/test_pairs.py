"""Two effects that are found together, where the best of them alone is a worse compromise than a third effect."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from sessions import bench, make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.fit.trial import Trial, nominal_trial
from snakebot.diagnosis.search.library import usable_effects
from snakebot.diagnosis.search.pairs import pairs
from snakebot.diagnosis.search.rounds import explore
from snakebot.robot import Robot

GAITS = ((37, 63, 3.8), (61, 70, 2.0), (70, 69, 1.4), (54, 93, 2.4))


def found_together(robot: Robot, effects: Sequence[str]) -> list[Trial]:
    evidence = gather(prepare(make_session(robot, effects, gaits=GAITS)))
    nominal = nominal_trial(evidence)
    library = usable_effects(evidence.data, over_ground=False)
    fits = explore(evidence, library, nominal, lambda text, share: None).fits
    return pairs(evidence, nominal, fits, nominal)


def test_a_pair_is_fitted_from_what_its_effects_are_alone() -> None:
    best = found_together(bench(), ("rate_limit:limit_rad_s=1.5", "servo_lag:time_constant_s=0.1"))[0]
    assert best.hypothesis.names == ("rate_limit", "servo_lag")
    assert np.allclose(best.theta, (1.5, 0.1), rtol=0.02)


def test_no_pair_where_one_effect_does_as_well() -> None:
    assert found_together(bench(), ("servo_offset:offset_deg=3",)) == []


@pytest.mark.slow
def test_of_a_pair_that_needs_the_whole_body_both_effects_are_fitted() -> None:
    best = found_together(snake(), ("deadband:width_deg=3.5,hard=1", "backlash:width_deg=4,loaded=1"))[0]
    assert best.hypothesis.names == ("deadband", "backlash")
    assert np.allclose(best.theta, (3.5, 4.0), rtol=0.1)
