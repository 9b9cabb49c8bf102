"""What effects say of themselves, so that nothing else need know their names."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import snakebot
from snakebot.effects import Observed, Plant, effects, find_effect, parse_effect
from snakebot.effects.effect import Usual
from snakebot.robot import Robot, load_robot
from snakebot.runlog import Run


def observed(robot: Robot, reading: np.ndarray, command: np.ndarray) -> Observed:
    return Observed(robot, [Run("a", np.arange(len(command)) / 100, command, reading)])


def waves(joints: int) -> np.ndarray:
    t = np.arange(0, 6, 0.01)
    return np.column_stack([np.sin((2 + j) * t + j) for j in range(joints)])


# Where the name of an effect stands for something else, or is what the module is about.
_OF_OTHER_THINGS = (
    "calibrated/mujoco_callbacks.py",  # numbers of the exported model
    "calibrated/mujoco_model.py",
    "conformance/",  # payloads of frames
    "servobus/",  # registers of servos
    "studies/gap.py",  # the paper's question: which of these servo effects it was
)


def test_what_is_special_about_an_effect_is_said_by_the_effect() -> None:
    package = Path(snakebot.__file__).parent
    for path in package.rglob("*.py"):
        place = path.relative_to(package).as_posix()
        if place.startswith(("effects/library/", "effects/registry.py", *_OF_OTHER_THINGS)):
            continue
        words = {
            node.value
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
        assert not words & set(effects()), place


def test_swapped_and_reversed_wires_are_read_off_and_right_ones_are_not() -> None:
    robot, command = Robot(name="bench", joints=3), waves(3)
    wiring = find_effect("wiring")
    assert wiring.is_read_off
    assert wiring.read_off(observed(robot, command, command)) is None
    found = wiring.read_off(observed(robot, command[:, [1, 0, 2]] * [1, 1, -1], command))
    assert found is not None
    assert found.joints == (1, 2, 3)
    assert found.values == {"permutation": (2.0, 1.0, 3.0), "signs": (1.0, 1.0, -1.0)}


def test_a_single_joint_is_wired_wrong_only_if_it_turns_the_other_way() -> None:
    robot, command = Robot(name="bench", joints=1), waves(1)
    assert not find_effect("wiring").can_explain(observed(robot, command, command))
    assert find_effect("wiring").can_explain(observed(robot, -command, command))


def test_a_free_joint_needs_a_body_to_say_how_it_swings() -> None:
    free, command = find_effect("joint_free"), waves(5)
    snake = load_robot("penn_state")
    assert free.can_explain(observed(snake, command, command))
    assert not free.can_explain(observed(Robot(name="bench", joints=5), command, command))


def test_a_torque_limit_that_holds_nothing_is_a_free_joint() -> None:
    limit = find_effect("torque_limit")
    assert limit.plainer({"limit_nm": 0.01}, Usual(1.0, 1.0)) == ("joint_free", {})
    assert limit.plainer({"limit_nm": 0.15}, Usual(1.0, 1.0)) == (
        "joint_free",
        {},
    )  # at its limit nearly always
    assert limit.plainer({"limit_nm": 0.5}, Usual(1.0, 1.0)) is None
    assert limit.plainer({"limit_nm": 0.01}, Usual(0.0, 1.0)) is None  # no load is known


def test_friction_is_off_in_one_coefficient_or_in_all_and_a_payload_sits_on_a_link() -> None:
    friction = find_effect("ground_friction")
    held = friction.variants({p.name: 1.0 for p in friction.parameters})
    assert [len(h) for h in held] == [3, 3, 3, 3, 0]
    assert find_effect("payload").variants({"link": 2.0, "mass_kg": 0.1}) == [{"link": 2.0}]


def test_gains_and_scales_are_counted_from_one() -> None:
    neutral = {p.name: p.neutral for effect in effects().values() for p in effect.parameters}
    assert {name for name, value in neutral.items() if value == 1.0} == {
        "gain", "ct_scale", "cn_scale", "ct0_scale", "cn0_scale",
    }  # fmt: skip


def test_what_chance_decides_shows_in_the_scatter() -> None:
    shows = {name: set(effect.shows_in) for name, effect in effects().items()}
    assert {name for name, where in shows.items() if "scatter" in where} == {"command_loss", "encoder_noise"}
    assert "mean" not in shows["encoder_noise"]


@pytest.mark.parametrize("ppm", [0.0, 2000.0])
def test_a_board_runs_on_the_clock_of_its_effects(ppm: float) -> None:
    specs = [parse_effect(f"clock_drift:ppm={ppm}"), parse_effect("servo_offset:offset_deg=1")]
    assert Plant(Robot(name="bench", joints=1), specs).clock_ppm == ppm


@pytest.mark.parametrize(
    ("effect", "values", "plain", "start"),
    [
        (
            "joint_friction",
            {"coulomb_nm": 0.0, "stiffness_nm_rad": 50.0},
            "compliance",
            {"stiffness_nm_rad": 50.0},
        ),
        ("voltage_sag", {"initial_rad_s": 2.0, "drop_per_s": 0.0}, "rate_limit", {"limit_rad_s": 2.0}),
        ("torque_speed", {"no_load_rad_s": 2.0, "stall_nm": 500.0}, "rate_limit", {"limit_rad_s": 2.0}),
        (
            "second_order",
            {"natural_freq_rad_s": 200.0, "damping_ratio": 4.0},
            "servo_lag",
            {"time_constant_s": 0.04},
        ),
    ],
)
def test_an_effect_without_what_makes_it_special_is_a_plainer_one(
    effect: str, values: dict[str, float], plain: str, start: dict[str, float]
) -> None:
    usual = Usual(load_nm=1.0, rate_rad_s=1.0)
    assert find_effect(effect).plainer(values, usual) == (plain, start)
    special = {
        "joint_friction": "coulomb_nm", "voltage_sag": "drop_per_s", "torque_speed": "stall_nm",
        "second_order": "damping_ratio",
    }[effect]  # fmt: skip
    assert find_effect(effect).plainer({**values, special: 0.5}, usual) is None


def test_a_motor_that_hardly_turns_beside_what_it_could_has_a_limit_of_torque() -> None:
    motor, usual = find_effect("torque_speed"), Usual(load_nm=1.0, rate_rad_s=1.0)
    assert motor.plainer({"no_load_rad_s": 25.0, "stall_nm": 1.5}, usual) == (
        "torque_limit",
        {"limit_nm": 1.5},
    )
    assert motor.plainer({"no_load_rad_s": 10.0, "stall_nm": 1.5}, usual) is None
    assert motor.plainer({"no_load_rad_s": 10.0, "stall_nm": 0.01}, usual) == ("joint_free", {})
    assert (
        motor.plainer({"no_load_rad_s": 25.0, "stall_nm": 1.5}, Usual(1.0, 0.0)) is None
    )  # no speed is known


def test_where_no_load_is_known_nothing_is_said_of_what_a_load_does() -> None:
    motor = find_effect("torque_speed")
    assert motor.plainer({"no_load_rad_s": 2.0, "stall_nm": 500.0}, Usual(0.0, 1.0)) is None
