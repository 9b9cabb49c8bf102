"""Load effects on a body against torque servos of another make: spring and damper, a fine step, the online chain."""

import math

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.effects import predict, servo_stage
from snakebot.effects.spec import parse_effect
from snakebot.effects.stages import assemble
from snakebot.gait import Gait, GaitMotion
from snakebot.physics import TORQUE, Chain, ChainModel, Drive
from snakebot.physics.inertia import felt_inertia_kg_m2
from snakebot.physics.servo_chain import DrivenChain
from snakebot.robot import load_robot

ROBOT = load_robot("penn_state")
assert ROBOT.body is not None
BODY = ROBOT.body
MODEL = ChainModel.from_body(BODY)
T = np.arange(0, 9, 0.01)
COMMAND = (
    np.clip(T / math.pi, 0, 1)[:, None]
    * np.radians(66)
    * np.sin(2 * T[:, None] + np.arange(5) * np.radians(80))
)
TAU_S = 0.03
# Twelve links of half the length and mass.
LIGHT_BODY = BODY.model_copy(
    update={
        "links": 12,
        "half_length_m": 0.04,
        "link_mass_kg": 0.715,
        "friction": BODY.friction.model_copy(update={"ct": 0.415, "cn": 25.95, "ct0": 0.245, "cn0": 1.165}),
    }
)
LIGHT_ROBOT = ROBOT.model_copy(update={"joints": 11, "body": LIGHT_BODY})
LIGHT_GAIT = GaitMotion(Gait.from_degrees(31.8, 27.25, 1.44, 10.2), 11, 9.0, 0.0).sampled(T)


def torque_servos(
    stiffness: float,
    damping: float | Floats,
    *,
    limit: float = math.inf,
    coulomb: float = 0.0,
    step_s: float = 5e-4,
) -> Floats:
    """Joint angles when each joint is pulled to a first-order lag of its set-point by a spring and a damper."""
    chain = Chain(MODEL, step_s)
    drive = Drive.at_rest(5)
    drive.kind[:] = TORQUE
    motor = np.zeros(5)
    angles = []
    for setpoint in COMMAND:
        angles.append(chain.joint_angle_rad.copy())
        for _ in range(round(0.01 / step_s)):
            rate = (setpoint - motor) / TAU_S
            motor = setpoint + (motor - setpoint) * math.exp(-step_s / TAU_S)
            torque = stiffness * (motor - chain.joint_angle_rad) + damping * (rate - chain.joint_rate_rad_s)
            torque = np.clip(torque, -limit, limit)
            drive.torque_nm[:] = torque - coulomb * np.tanh(chain.joint_rate_rad_s / 0.01)
            chain.step(drive)
    return np.array(angles)


def predicted(*specs: str) -> Floats:
    return predict(ROBOT, specs, T, COMMAND, quantise=False, body=False).joint_angle_rad


NOMINAL = predicted()


def agree(found: Floats, other: Floats, rest: float) -> None:
    """The gap to the nominal motion is the same but for a ``rest`` of its size."""
    gap = np.sqrt(np.mean((other - NOMINAL) ** 2))
    assert gap > 0.01
    assert np.sqrt(np.mean((found - other) ** 2)) < rest * gap


@pytest.mark.parametrize("limit_nm", [0.2, 0.4])
def test_torque_limit(limit_nm: float) -> None:
    agree(predicted(f"torque_limit:limit_nm={limit_nm}"), torque_servos(60.0, 1.5, limit=limit_nm), 0.15)


def test_compliance() -> None:
    damping = 2 * 0.3 * np.sqrt(5.0 * felt_inertia_kg_m2(MODEL))
    agree(predicted("compliance:stiffness_nm_rad=5"), torque_servos(5.0, damping), 0.2)


def test_joint_friction() -> None:
    damping = 2 * 0.3 * np.sqrt(8.0 * felt_inertia_kg_m2(MODEL))
    found = predicted("joint_friction:coulomb_nm=0.25,stiffness_nm_rad=8")
    agree(found, torque_servos(8.0, damping, coulomb=0.25), 0.2)


@pytest.mark.parametrize(
    "spec",
    [
        "torque_limit:limit_nm=500",
        "compliance:stiffness_nm_rad=5000",
        "joint_friction:coulomb_nm=0,stiffness_nm_rad=2000",
        "voltage_sag:initial_rad_s=50,drop_per_s=0,drop_per_nm=0.01",
    ],
)
def test_at_the_end_of_their_range_load_effects_do_nothing(spec: str) -> None:
    assert np.sqrt(np.mean((predicted(spec) - NOMINAL) ** 2)) < ROBOT.rad_per_count


def test_one_weak_joint_does_not_pull_the_others_along() -> None:
    gap = np.abs(predicted("torque_limit:limit_nm=0.2,joints=3") - NOMINAL).max(axis=0)
    assert gap[2] > 0.1
    assert np.all(gap[[0, 1, 3, 4]] < 1e-9)


def test_load_depends_on_the_ground() -> None:
    ice = predicted("torque_limit:limit_nm=0.3", "ground_friction:cn_scale=0.05,cn0_scale=0.05")
    ground = predicted("torque_limit:limit_nm=0.3")
    assert np.abs(ground - NOMINAL).max() > 5 * np.abs(ice - NOMINAL).max()


@pytest.mark.parametrize("limit_nm", [1.0, 1.3, 1.5, 1.62, 1.7, 1.8])
def test_light_links_do_not_shake_under_a_torque_limit(
    limit_nm: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Twelve light links move the same at the step of a prediction and at a quarter of it. Motors that gave all they
    have for a whole step, and as much the other way in the next, threw them 10 deg off.
    """

    def moved(grid_s: float) -> Floats:
        monkeypatch.setattr(servo_stage, "GRID_S", grid_s)
        spec = f"torque_limit:limit_nm={limit_nm}"
        return predict(LIGHT_ROBOT, [spec], T, LIGHT_GAIT, quantise=False, body=False).joint_angle_rad

    assert np.sqrt(np.mean((moved(2e-3) - moved(5e-4)) ** 2)) < np.radians(0.3)


@pytest.mark.parametrize("other", ["backlash:width_deg=0.45,loaded=1", "compliance:stiffness_nm_rad=40"])
def test_no_motor_gives_more_than_its_limit(other: str) -> None:
    stages = assemble(LIGHT_ROBOT, [parse_effect("torque_limit:limit_nm=1.6"), parse_effect(other)])
    chain = DrivenChain(stages.servo_rows, LIGHT_GAIT[0], model=stages.model, grid_s=2e-3)
    borne = np.abs(chain.run(np.arange(0, 3, 2e-3), T, LIGHT_GAIT).torque)
    assert borne.max() > 1.5  # the limit is met
    assert np.mean(borne > 1.6 * 1.001) < 1e-3  # but for gears that meet


@pytest.mark.parametrize("spec", ["torque_limit:limit_nm=0.1", "compliance:stiffness_nm_rad=0.3"])
def test_far_out_of_use_nothing_blows_up(spec: str) -> None:
    found = predicted(spec, "joint_friction:coulomb_nm=1,stiffness_nm_rad=3,joints=2")
    assert np.all(np.isfinite(found))
    assert np.abs(found).max() < 20


def test_felt_inertia_of_two_links() -> None:
    """At relative rate 1 two equal rods turn by -1/2 and 1/2, their centres stay in place: 2 J / 4 = m l^2 / 6."""
    body = BODY.model_copy(update={"links": 2})
    expected = MODEL.mass[0] * MODEL.half_length[0] ** 2 / 6
    assert felt_inertia_kg_m2(ChainModel.from_body(body)) == pytest.approx([expected])
