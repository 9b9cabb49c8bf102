"""A cause of the ground that leaves a rest over ground, where joint angles are measured, is no sure one."""

from __future__ import annotations

import pytest
from sessions import make_session, snake

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.verdict.probability import MOST_BESIDE_GROUND_REST


@pytest.mark.parametrize(
    ("true", "asked", "sure"),
    [
        # both slow the robot; only one pulls it sideways, too
        ("slope:angle_deg=3", "ground_friction", False),
        ("slope:angle_deg=3", "slope", True),
        ("ground_friction:ct_scale=3", "ground_friction", True),
    ],
)
def test_another_law_over_ground_is_not_told_as_sure(true: str, asked: str, sure: bool) -> None:
    found = diagnose(make_session(snake(), [true], pose=True), only=[asked], quick=True)
    (cause,) = found.causes
    assert cause.effect == asked
    assert found.unexplained.significant is not sure
    assert (cause.probability > MOST_BESIDE_GROUND_REST) is sure
