"""Without a fault the blind robot does what the product predicts: the floor of the check is its declared background.

Here, outside of tools/blind, because the blind robot may not know the product's simulation.
"""

import numpy as np
import pytest
from blind.cases import draw_build
from blind.robot import (
    NOMINAL_LAG_S,
    NOMINAL_LINK,
    TOLERANCE,
    Build,
    Parameters,
    Robot,
    gait_command,
    real_robot,
)

from snakebot.effects.prediction import body_stage, joint_run
from snakebot.effects.servo_stage import ServoRun
from snakebot.effects.stages import assemble
from snakebot.robot import Robot as SimRobot
from snakebot.robot import Servo, load_robot

GAITS = [(66, 80, 2.0), (30, 80, 4.0), (70, 70, 1.2)]


def speed(path: np.ndarray, t_s: np.ndarray) -> float:
    half = t_s > 5
    return float(np.linalg.norm(path[-1] - path[half][0]) / (t_s[-1] - t_s[half][0]))


@pytest.mark.parametrize("gait", GAITS)
@pytest.mark.parametrize(("rate_hz", "late_s", "faster"), [(100.0, 0.0005, 0.005), (500.0, 0.0010, 0.003)])
def test_nominal_blind_robot_is_what_the_product_predicts(
    gait: tuple[float, float, float], rate_hz: float, late_s: float, faster: float
) -> None:
    t = np.arange(round(10 * rate_hz)) / rate_hz
    command = gait_command(t, np.radians(gait[0]), np.radians(gait[1]), gait[2])
    real = Robot(Parameters().noiseless()).run(t, command, np.random.default_rng(0))
    stages = assemble(load_robot("penn_state"), ())
    angle = joint_run(stages, ServoRun(t, stages.link(t, command), initial_rad=command[0])).angle_rad
    off, rate = (real.encoder_rad - angle)[t > 2], np.gradient(angle, t, axis=0)[t > 2]
    lag_off_s = (off * rate).sum(axis=0) / (rate**2).sum(axis=0)
    assert np.abs(lag_off_s).max() < late_s  # what LOOP_LAG_S, one number, cannot take away
    assert np.degrees((off - lag_off_s * rate).std(axis=0)).max() < 0.05  # a count is 0.044
    replayed = body_stage(stages, t, real.encoder_rad)
    assert speed(real.pose[:, :2], t) == pytest.approx(speed(replayed.com_m, t), rel=faster)


def test_nominal_numbers_are_those_of_the_built_in_robot() -> None:
    robot = load_robot("penn_state")
    assert robot.body is not None
    assert robot.servo.time_constant_s == NOMINAL_LAG_S
    assert robot.body.link_mass_kg == NOMINAL_LINK["mass_kg"]
    for row in ("ct", "cn", "ct0", "cn0"):
        assert getattr(robot.body.friction, row) == NOMINAL_LINK[row]


@pytest.mark.parametrize("build", [Build(3, 0.015, 200.0), Build(12, 0.08, 50.0), Build(8, 0.05, 100.0)])
def test_robots_of_other_builds_are_what_the_product_predicts(build: Build) -> None:
    t = np.arange(round(6 * build.rate_hz)) / build.rate_hz
    command = gait_command(
        t, np.radians(150 / build.joints), 2 * np.pi / build.joints, 2.0, joints=build.joints
    )
    real = Robot(Parameters.of(build).noiseless()).run(t, command, np.random.default_rng(0))
    bench = SimRobot(name="bench", joints=build.joints, servo=Servo(time_constant_s=build.lag_s))
    stages = assemble(bench, ())
    angle = joint_run(stages, ServoRun(t, stages.link(t, command), initial_rad=command[0])).angle_rad
    off, rate = (real.encoder_rad - angle)[t > 2], np.gradient(angle, t, axis=0)[t > 2]
    lag_off_s = (off * rate).sum(axis=0) / (rate**2).sum(axis=0)
    assert (
        np.abs(lag_off_s).max() < 0.6 * TOLERANCE["lag"] * build.lag_s + 0.001
    )  # load takes off 2 ms at most
    assert np.degrees((off - lag_off_s * rate).std(axis=0)).max() < 0.08


def test_healthy_robots_are_off_by_the_tolerance_and_nothing_is_cut_off() -> None:
    nominal = Parameters()
    found: dict[str, list[float]] = {"lag": [], "mass": [], "friction": []}
    for seed in range(400):
        p = real_robot(np.random.default_rng(seed))
        found["lag"] += list((p.joint("lag_s") - nominal.joint("lag_s")) / NOMINAL_LAG_S)
        found["mass"] += list(p.link("mass_kg") / nominal.link("mass_kg") - 1)
        found["friction"] += list(p.link("ct0") / nominal.link("ct0") - 1)
    for key, values in found.items():
        assert np.std(values) == pytest.approx(TOLERANCE[key], rel=0.1), key
        beyond = np.mean(np.abs(values) > 2 * TOLERANCE[key])
        assert 0.02 < beyond < 0.08, key  # of a normal law, 4.6 %
    wires = [real_robot(np.random.default_rng(seed)).latency_s for seed in range(400)]
    assert min(wires) == 0.0
    assert np.quantile(wires, 0.84) == pytest.approx(0.001 + TOLERANCE["wire"], abs=2e-4)


def test_builds_are_drawn_over_their_whole_range() -> None:
    rng = np.random.default_rng(0)
    builds = [draw_build(rng) for _ in range(400)]
    assert {b.joints for b in builds} == set(range(3, 13))
    assert {b.rate_hz for b in builds} == {50.0, 100.0, 200.0}
    lags = np.array([b.lag_s for b in builds])
    assert lags.min() < 0.017
    assert lags.max() > 0.07
    assert 0.4 < np.mean(lags == NOMINAL_LAG_S) < 0.6
