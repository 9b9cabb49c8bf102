"""A motor's torque-speed line, a torque limit and the shape of the position loop, one with the other, on a body."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.effects import assemble, predict
from snakebot.effects.prediction import PredictedRun
from snakebot.physics import ChainModel
from snakebot.physics import servo_layout as layout
from snakebot.physics.servo_chain import DrivenChain, Samples
from snakebot.robot import load_robot

ROBOT = load_robot("penn_state")
assert ROBOT.body is not None
MODEL = ChainModel.from_body(ROBOT.body)
OMEGA = 4.0
PERIOD_S = 2 * math.pi / OMEGA
GAIT = (math.radians(49), math.radians(80), OMEGA)
CYCLES, AVERAGED = 7, 4
T = np.arange(0, CYCLES * PERIOD_S, 0.01)
RAMP = np.clip(T / PERIOD_S, 0, 1)
COMMAND = (RAMP**3 * (10 - 15 * RAMP + 6 * RAMP**2))[:, None] * (
    GAIT[0] * np.sin(OMEGA * T[:, None] + np.arange(5) * GAIT[1])
)
LINE = "torque_speed:no_load_rad_s=6,stall_nm=0.4"
LIMIT = "torque_limit:limit_nm=0.3"
SHAPE = "second_order:natural_freq_rad_s=30,damping_ratio=0.8"


def predicted(*specs: str) -> PredictedRun:
    return predict(ROBOT, specs, T, COMMAND, quantise=False)


def speed(*specs: str) -> float:
    motion = predicted(*specs).motion
    assert motion is not None
    return motion.forward_speed_m_s(T[-1] - AVERAGED * PERIOD_S)


def error(*specs: str) -> float:
    late = T[-1] - AVERAGED * PERIOD_S < T
    return math.sqrt(np.mean((predicted(*specs).joint_angle_rad - COMMAND)[late] ** 2))


def driven(change: Callable[[Floats], None], sample_s: float = 2e-3) -> tuple[Floats, Samples]:
    """Angles and torques of the chain, with the servos' rows changed."""
    rows = assemble(ROBOT).servo_rows.copy()
    change(rows)
    t = np.arange(0, 2.5 * PERIOD_S, sample_s)
    out = DrivenChain(rows, np.zeros(5), model=MODEL, grid_s=2e-3).run(t, T, COMMAND)
    return t, out


@pytest.mark.parametrize("shape", [(), (SHAPE,)])
def test_a_limit_far_above_the_line_changes_nothing(shape: tuple[str, ...]) -> None:
    alone = predicted(LINE, *shape).joint_angle_rad
    assert np.abs(alone - predicted(*shape).joint_angle_rad).max() > 0.1
    assert np.array_equal(predicted(LINE, "torque_limit:limit_nm=500", *shape).joint_angle_rad, alone)


@pytest.mark.parametrize("shape", [(), (SHAPE,)])
def test_a_line_far_above_the_limit_changes_nothing(shape: tuple[str, ...]) -> None:
    alone = predicted(LIMIT, *shape).joint_angle_rad
    line = "torque_speed:no_load_rad_s=50,stall_nm=500"
    assert np.array_equal(predicted(LIMIT, line, *shape).joint_angle_rad, alone)


def test_a_line_that_does_not_fall_is_a_limit() -> None:
    def line(rows: Floats) -> None:
        rows[:, layout.RATE_LIMIT_RAD_S] = 1e9
        rows[:, layout.RATE_DROP_PER_NM] = 1 / 0.3

    def limit(rows: Floats) -> None:
        rows[:, layout.TORQUE_LIMIT_NM] = 0.3

    assert np.abs(driven(line)[1].angle - driven(limit)[1].angle).max() < 1e-5


@pytest.mark.parametrize("shape", [(), (SHAPE,)])
def test_a_stronger_or_faster_motor_follows_better(shape: tuple[str, ...]) -> None:
    by_stall = [error(f"torque_speed:no_load_rad_s=6,stall_nm={stall}", *shape) for stall in (0.3, 0.5, 1, 5)]
    by_speed = [
        error(f"torque_speed:no_load_rad_s={no_load},stall_nm=0.4", *shape) for no_load in (3, 6, 12, 50)
    ]
    assert np.all(np.diff(by_stall) < 0)
    assert np.all(np.diff(by_speed) < 0)


def test_the_loop_keeps_its_shape_within_the_torque() -> None:
    """A second-order loop about as late as the nominal lag falls as far short as that, behind the same motor."""
    same_lag = "second_order:natural_freq_rad_s=60,damping_ratio=0.9"  # 2 zeta / omega_n = 30 ms
    assert speed(same_lag) == pytest.approx(speed(), rel=0.01)
    assert speed(LINE) < 0.85 * speed()
    assert speed(LINE, same_lag) == pytest.approx(speed(LINE), rel=0.02)


def test_no_motor_gives_more_than_its_line() -> None:
    stall, no_load, limit = 0.4, 6.0, 0.35

    def motor(rows: Floats) -> None:
        rows[:, layout.RATE_LIMIT_RAD_S] = no_load
        rows[:, layout.RATE_DROP_PER_NM] = 1 / stall
        rows[:, layout.TORQUE_LIMIT_NM] = limit

    t, out = driven(motor)
    torque = out.torque[1:]
    rate = np.diff(out.angle, axis=0) / np.diff(t)[:, None]
    most = np.minimum(limit, stall * (1 - rate / no_load))
    least = np.maximum(-limit, -stall * (1 + rate / no_load))
    at_the_end = (torque > most - 0.01) | (torque < least + 0.01)
    assert np.mean(at_the_end) > 0.2
    beyond = np.maximum(torque - most, least - torque)
    assert np.quantile(beyond, 0.95) < 0.03  # a step is cut off by what its motor had at the step's start
    assert np.abs(torque).max() < 1.25 * limit


def test_the_motor_does_not_shake_at_its_line() -> None:
    """The joint's acceleration does not change its sign from sample to sample."""
    bend = np.diff(predicted(LINE).joint_angle_rad, n=2, axis=0)
    to_and_fro = (bend[1:] * bend[:-1] < 0) & (np.minimum(np.abs(bend[1:]), np.abs(bend[:-1])) > 1e-4)
    assert np.mean(to_and_fro) < 0.05


@pytest.mark.parametrize(
    "motor",
    [
        pytest.param({"stall_nm": 0.4, "no_load_rad_s": 6.0}, marks=pytest.mark.slow),
        pytest.param({"stall_nm": 0.8, "no_load_rad_s": 3.0}, marks=pytest.mark.slow),
        pytest.param({"limit_nm": 0.3}, marks=pytest.mark.slow),
        {"stall_nm": 0.4, "no_load_rad_s": 6.0, "limit_nm": 0.3},
    ],
)
def test_as_in_mujoco(motor: dict[str, Any]) -> None:
    """Another engine, another servo: a spring and a damper to the lagging gait, cut off at what the motor has."""
    pytest.importorskip("mujoco")
    from physics_peers import MujocoChain

    late = math.atan(OMEGA * ROBOT.servo.time_constant_s)
    every = 8000
    peer = MujocoChain(MODEL, dt_s=PERIOD_S / every, kp=60.0, kd=1.5, **motor)
    rows = peer.run((GAIT[0] * math.cos(late), GAIT[1], OMEGA), CYCLES * every, every)
    way = rows[-1, 1:3] - rows[-1 - AVERAGED, 1:3]
    other = float(np.linalg.norm(way)) / (AVERAGED * PERIOD_S)
    specs = []
    if "stall_nm" in motor:
        specs.append("torque_speed:" + ",".join(f"{k}={v}" for k, v in motor.items() if k != "limit_nm"))
    if "limit_nm" in motor:
        specs.append(f"torque_limit:limit_nm={motor['limit_nm']}")
    assert other < 0.96 * speed()  # the motor is met
    assert speed(*specs) == pytest.approx(other, rel=0.02)
