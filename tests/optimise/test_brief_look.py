"""A brief look costs little and tells nearly what a thorough one does; nothing is looked at twice."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.effects import EffectSpec
from snakebot.optimise.goal import Goal
from snakebot.optimise.outcomes import GaitSimulator, Outcomes
from snakebot.optimise.search import Search
from snakebot.optimise.space import Space
from snakebot.robot import load_robot

ROBOT = load_robot("penn_state")


@pytest.mark.parametrize("limit_rad_s", [1.0, 1.5])
def test_a_brief_look_is_within_a_hundredth(limit_rad_s: float) -> None:
    gaits = np.array([[0.6, 1.4, 0.5], [0.6, 1.4, 1.0], [0.5, 1.2, 2.0], [0.4, 1.6, 4.0]])
    simulator = GaitSimulator([(ROBOT, [EffectSpec("rate_limit", {"limit_rad_s": limit_rad_s})])])
    brief, thorough = (simulator(gaits, thorough=long) for long in (False, True))
    np.testing.assert_allclose(brief.speed_m_s, thorough.speed_m_s, rtol=0.01)
    np.testing.assert_allclose(brief.power_in_w, thorough.power_in_w, rtol=0.01)


def test_a_gait_is_looked_at_once_in_either_way() -> None:
    asked: list[int] = []

    def simulate(gaits: Floats, *, thorough: bool = True) -> Outcomes:
        asked.append(len(gaits))
        speed = gaits[:, 0] * (2.0 if thorough else 1.0)
        return Outcomes(*(speed[None, :],) * 5, weight_n=np.array([80.0]))

    search = Search(simulate, Space.of(ROBOT), Goal("speed"))
    first = np.array([[0.3, 1.0, 1.0], [0.4, 1.0, 1.0]])
    again = np.array([[0.4, 1.0, 1.0], [0.5, 1.0, 1.0], [0.3, 1.0, 1.0 + 1e-12]])
    search.look(first, thorough=False)
    found = search.look(again, thorough=False)
    np.testing.assert_allclose(found.speed_m_s[0], [0.4, 0.5, 0.3])
    assert asked == [2, 1]
    np.testing.assert_allclose(search.look(first).speed_m_s[0], [0.6, 0.8])
    assert asked == [2, 1, 2]
    assert len(search.all_seen()[0]) == 5
