"""The search on outcomes that a formula gives, where brute force is cheap."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.optimise.goal import Goal
from snakebot.optimise.outcomes import Outcomes, joined
from snakebot.optimise.search import Search
from snakebot.optimise.space import Space
from snakebot.robot import Limits, load_robot

ROBOT = load_robot("penn_state")


def formula(gaits: Floats, *, thorough: bool = True) -> Outcomes:
    """Speed with a ridge that lies askew, power as its square and more off the ridge; torque grows with alpha."""
    a, b, w = gaits.T
    ridge = np.exp(-3 * (b - 1.4 + 0.3 * (a - 0.6)) ** 2)
    speed = 0.2 * w * np.sin(np.pi * np.minimum(a / 1.3, 1.0)) * ridge
    power = 2 * speed**2 / ridge + 0.3 * w * a**1.5 + 0.01
    rows = [speed, power, 2 * a, a, np.zeros_like(a)]
    return Outcomes(*(row[None, :] for row in rows), weight_n=np.array([80.0]))


def space(speed_rad_s: float = 2.0, margin: float = 0.0) -> Space:
    limits = Limits(angle_deg=80, speed_rad_s=speed_rad_s, acceleration_rad_s2=6)
    return Space.of(ROBOT.model_copy(update={"limits": limits}), margin=margin)


def brute(where: Space, goal: Goal) -> float:
    gaits = where.grid(60, 60, 60)
    return float(goal.worst(formula(gaits), where.torque_most).max())


@pytest.mark.parametrize("goal", [Goal("speed"), Goal("cost-of-transport"), Goal("power-at-speed", 0.3)])
@pytest.mark.parametrize("margin", [0.0, 0.5])
def test_no_gait_of_a_fine_grid_is_better_and_no_limit_is_broken(goal: Goal, margin: float) -> None:
    where = space(margin=margin)
    search = Search(formula, where, goal)
    gait, score = max((search.uphill(start) for start in search.over_grid()), key=lambda pair: pair[1])
    best = brute(where, goal)
    assert score >= best - 0.003 * abs(best)
    a, _, w = gait
    assert a * w <= 2 * (1 + 1e-9)
    assert a * w**2 <= 6 * (1 + 1e-9)
    assert a <= where.torque_most
    if goal.speed_m_s:
        assert formula(gait[None, :]).speed_m_s[0, 0] == pytest.approx(0.3, rel=2e-3)


def test_of_several_robots_the_worst_one_counts() -> None:
    def two(gaits: Floats, *, thorough: bool = True) -> Outcomes:
        first, shifted = formula(gaits), formula(gaits + np.array([0.3, 0.0, 0.0]))
        tables = (
            np.concatenate([getattr(part, name) for part in (first, shifted)])
            for name in ("speed_m_s", "power_in_w", "torque_nm", "torque_use", "turn_rad")
        )
        return Outcomes(*tables, weight_n=np.array([80.0, 80.0]))

    goal, where = Goal("speed"), space()
    alone = Search(formula, where, goal)
    promise = max(alone.uphill(start)[1] for start in alone.over_grid())
    both = Search(two, where, goal)
    gait, worst = max((both.uphill(start) for start in both.over_grid()), key=lambda pair: pair[1])
    assert worst <= promise
    assert worst == pytest.approx(float(two(gait[None, :]).speed_m_s.min()))


def test_what_cannot_be_reached_has_no_start() -> None:
    assert len(Search(formula, space(), Goal("power-at-speed", 5.0)).over_grid()) == 0


def test_goals_that_make_no_sense_are_refused() -> None:
    with pytest.raises(BadInputError, match="say which speed"):
        Goal("power-at-speed")
    with pytest.raises(BadInputError, match="above zero"):
        Goal("power-at-speed", -1.0)
    with pytest.raises(BadInputError, match="only with"):
        Goal("speed", 0.2)


def test_outcomes_are_joined_and_a_robot_that_stands_has_no_cost() -> None:
    gaits = np.array([[0.5, 1.4, 1.0], [1.3, 1.4, 1.0]])
    one, other = formula(gaits[:1]), formula(gaits[1:])
    both = joined([one, other])
    assert both.speed_m_s.shape == (1, 2)
    still = Outcomes(np.zeros((1, 1)), *(np.ones((1, 1)),) * 4, weight_n=np.ones(1))
    assert np.isinf(still.transport()[0, 0])
