"""What an offset does to a robot is simulated from its description, effects included."""

from __future__ import annotations

import math

import pytest

from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.robot import load_robot
from snakebot.steering.response import response_of

ROBOT = load_robot("penn_state")
GAIT = Gait.from_degrees(37, 80, 2)


def test_the_built_in_robot_turns_in_proportion() -> None:
    """5, 10, 15, 20 degrees of offset turn it by 5.8, 11.5, 17.2, 23.1 deg/s less the 0.1 that it turns anyway."""
    response = response_of(ROBOT, GAIT)
    assert response.turn_per_offset_1_s == pytest.approx(1.145, rel=0.02)
    assert abs(response.bias_rad_s) < math.radians(0.2)
    assert response.speed_m_s == pytest.approx(0.17, rel=0.05)
    assert response.body_m == pytest.approx(0.96)


def test_a_gait_that_goes_backwards_turns_the_other_way() -> None:
    response = response_of(ROBOT, Gait.from_degrees(37, -80, 2))
    assert response.speed_m_s < 0
    assert response.turn_per_offset_1_s < 0


def test_effects_of_the_description_are_part_of_it() -> None:
    bent = ROBOT.model_copy(update={"effects": ("servo_offset:offset_deg=5,joints=3",)})
    slack = ROBOT.model_copy(update={"effects": ("command_gain:gain=0.7",)})
    assert abs(response_of(bent, GAIT).bias_rad_s) > math.radians(0.5)
    assert response_of(slack, GAIT).turn_per_offset_1_s < 0.9 * response_of(ROBOT, GAIT).turn_per_offset_1_s


@pytest.mark.parametrize("gait", [(10, 80, 0), (1, 80, 2)])
def test_what_cannot_be_steered_is_refused(gait: tuple[float, float, float]) -> None:
    with pytest.raises(BadInputError, match=r"omega|cannot be steered|does not move"):
        response_of(ROBOT, Gait.from_degrees(*gait))


def test_a_bench_has_no_course() -> None:
    bench = ROBOT.model_copy(update={"body": None})
    with pytest.raises(BadInputError, match="no body"):
        response_of(bench, GAIT)
