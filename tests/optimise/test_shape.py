"""Amplitudes of single joints, on a formula whose best ones are known."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.optimise.goal import Goal
from snakebot.optimise.outcomes import Outcomes, commands
from snakebot.optimise.search import Search
from snakebot.optimise.shape import LEAST, Amplitudes, shaped, taper
from snakebot.optimise.space import Space, parse_grid
from snakebot.robot import load_robot

ROBOT = load_robot("penn_state")
BEST = np.array([0.5, 0.6, 0.7, 0.8, 0.9])  # rad
SMALL = (5, 5, 5)


def formula(gaits: Floats, *, thorough: bool = True) -> Outcomes:
    """The nearer each joint's amplitude is to its best, the faster."""
    amplitude = gaits[:, :1] * (gaits[:, 3:] if gaits.shape[1] > 3 else 1.0)
    speed = gaits[:, 2] * (1 - ((amplitude - BEST) ** 2).sum(axis=1)) * np.exp(-((gaits[:, 1] - 1.4) ** 2))
    rows = [speed, gaits[:, 2] ** 2 * 0.1 + 0.01, speed, np.zeros_like(speed), np.zeros_like(speed)]
    return Outcomes(*(row[None, :] for row in rows), weight_n=np.array([80.0]))


@pytest.mark.parametrize("kind", ["taper", "each"])
@pytest.mark.parametrize("goal", [Goal("speed"), Goal("power-at-speed", 0.5)])
def test_the_best_amplitudes_are_found(kind: Amplitudes, goal: Goal) -> None:
    space = Space.of(ROBOT, {"omega": (0.5, 1.0)})
    found = shaped(Search(formula, space, goal), np.array([0.7, 1.4, 0.9]), 5, kind, SMALL)
    np.testing.assert_allclose(found[0] * found[3:], BEST, atol=0.04)
    assert found[3:].max() == 1.0


def test_equal_amplitudes_stay_where_nothing_is_better() -> None:
    def equal(gaits: Floats, *, thorough: bool = True) -> Outcomes:
        spread = np.ptp(gaits[:, 3:], axis=1)
        rows = [1 - spread - (gaits[:, 0] - 0.6) ** 2, *([np.ones(len(gaits))] * 4)]
        return Outcomes(*(row[None, :] for row in rows), weight_n=np.array([80.0]))

    found = shaped(Search(equal, Space.of(ROBOT), Goal("speed")), np.array([0.6, 1.4, 1.0]), 5, "each", SMALL)
    np.testing.assert_array_equal(found[3:], np.ones(5))


def test_no_limit_is_passed_and_no_joint_stands_still() -> None:
    space = Space.of(ROBOT, {"alpha": (10, 40), "omega": (0.5, 1.0)})  # the best needs 52 deg
    found = shaped(Search(formula, space, Goal("speed")), np.array([0.6, 1.4, 0.9]), 5, "each", SMALL)
    assert found[0] <= np.radians(40) * (1 + 1e-9)
    assert LEAST <= found[3:].min() <= found[3:].max() <= 1


def test_a_taper_falls_to_either_end() -> None:
    np.testing.assert_allclose(taper(0.4, 5), [0.6, 0.7, 0.8, 0.9, 1.0])
    np.testing.assert_allclose(taper(-0.4, 3), [1.0, 0.8, 0.6])


def test_set_points_have_the_shares() -> None:
    row = np.array([0.5, 1.4, 2.0, 1.0, 0.5, 0.25, 0.5, 1.0])
    _, wave, _ = commands(row, 5, 3)
    _, even, _ = commands(row[:3], 5, 3)
    np.testing.assert_allclose(wave, even * row[3:])


@pytest.mark.parametrize("text", ["5", "5,5", "1,5,5", "5,5,x", "5,5,101"])
def test_a_grid_that_is_none_is_refused(text: str) -> None:
    assert parse_grid("6,5,4") == (6, 5, 4)
    with pytest.raises(BadInputError, match="--grid"):
        parse_grid(text)
