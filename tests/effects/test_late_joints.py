"""Set-points that reach some joints later than others, and values listed joint by joint."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.effects import Plant, parse_effect, predict
from snakebot.effects.stages import assemble
from snakebot.errors import BadInputError
from snakebot.robot import load_robot

ROBOT = load_robot("penn_state")
LATE = "command_delay:delay_s=0.0337"
T_S = np.arange(0, 3, 0.01)
COMMAND_RAD = np.stack([0.6 * np.sin(2 * T_S + joint) for joint in range(ROBOT.joints)], axis=1)


def readings(*effects: str) -> np.ndarray:
    return predict(ROBOT, effects, T_S, COMMAND_RAD, body=False, quantise=False).encoder_rad


def test_late_joints_are_as_late_as_all_would_be_and_the_others_are_not() -> None:
    some, every, none = readings(f"{LATE},joints=2+3"), readings(LATE), readings()
    assert some[:, 1:3] == pytest.approx(every[:, 1:3], abs=1e-12)
    assert np.array_equal(some[:, [0, 3, 4]], none[:, [0, 3, 4]])


@pytest.mark.parametrize("beside", [(), ("compliance:stiffness_nm_rad=3",)])
def test_the_simulated_robot_is_late_alike_set_point_by_set_point(beside: tuple[str, ...]) -> None:
    effects = (f"{LATE},joints=2+3", "command_delay:delay_s=0.012,joints=5", *beside)
    plant, seen = Plant(ROBOT, effects, initial_rad=COMMAND_RAD[0]), []
    for t_s, command in zip(T_S, COMMAND_RAD, strict=True):
        plant.advance(t_s)
        seen.append(plant.joint_angle_rad)
        plant.command(t_s, command)
    whole = predict(ROBOT, effects, T_S, COMMAND_RAD, quantise=False)
    # a body is simulated in steps of 1 ms here and of 2 ms there
    assert np.array(seen) == pytest.approx(whole.joint_angle_rad, abs=2e-3 if beside else 1e-9)


def test_values_may_be_listed_joint_by_joint() -> None:
    text = "servo_offset:offset_deg=1.5+-2,joints=3+4"
    spec = parse_effect(text, ROBOT)
    assert str(spec) == text
    parts = assemble(ROBOT, [text]).specs
    assert [(s.value("offset_deg"), s.joints) for s in parts] == [(1.5, (3,)), (-2.0, (4,))]
    for wrong in ("servo_offset:offset_deg=1.5+-2", "servo_offset:offset_deg=1+2+3,joints=3+4"):
        with pytest.raises(BadInputError, match="one for each of joints="):
            parse_effect(wrong, ROBOT)
