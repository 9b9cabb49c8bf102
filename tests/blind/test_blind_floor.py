"""Without a fault the blind robot does what the product predicts: the floor of the check is its declared background.

Here, outside of tools/blind, because the blind robot may not know the product's simulation.
"""

import numpy as np
import pytest
from blind.cases import RATE_HZ
from blind.robot import MOST_OFF, NOMINAL_LAG_S, NOMINAL_LINK, Parameters, Robot, gait_command, real_robot

from snakebot.effects.prediction import body_stage, servo_stage
from snakebot.effects.stages import assemble
from snakebot.robot import load_robot

GAITS = [(66, 80, 2.0), (30, 80, 4.0), (70, 70, 1.2)]


def speed(path: np.ndarray, t_s: np.ndarray) -> float:
    half = t_s > 5
    return float(np.linalg.norm(path[-1] - path[half][0]) / (t_s[-1] - t_s[half][0]))


@pytest.mark.parametrize("gait", GAITS)
@pytest.mark.parametrize(("rate_hz", "late_s", "faster"), [(RATE_HZ, 0.0005, 0.005), (500.0, 0.0010, 0.003)])
def test_nominal_blind_robot_is_what_the_product_predicts(
    gait: tuple[float, float, float], rate_hz: float, late_s: float, faster: float
) -> None:
    t = np.arange(round(10 * rate_hz)) / rate_hz
    command = gait_command(t, np.radians(gait[0]), np.radians(gait[1]), gait[2])
    real = Robot(Parameters().noiseless()).run(t, command, np.random.default_rng(0))
    stages = assemble(load_robot("penn_state"), ())
    angle = servo_stage(stages, stages.link(t, command), t, initial_rad=command[0]).joint_angle_rad
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


def test_background_stays_within_what_counts_as_healthy() -> None:
    nominal = Parameters()
    lag, mass, friction = [], [], []
    for seed in range(200):
        p = real_robot(np.random.default_rng(seed))
        jitter = p.latency_jitter_s * np.abs(np.random.default_rng(0).normal(size=10000)).mean()
        late = p.joint("lag_s") - nominal.joint("lag_s") + p.latency_s + jitter - nominal.latency_s
        lag.append(np.abs(late / NOMINAL_LAG_S).max())
        mass.append(np.abs(p.link("mass_kg") / nominal.link("mass_kg") - 1).max())
        friction += [np.abs(p.link(row) / nominal.link(row) - 1).max() for row in ("ct", "cn", "ct0", "cn0")]
    for found, key in ((lag, "lag"), (mass, "mass"), (friction, "friction")):
        assert 0.8 * MOST_OFF[key] < max(found) < 1.01 * MOST_OFF[key]  # few per cent off, and never more
