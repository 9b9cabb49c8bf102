"""Robots for the check of ``snakebot optimize``: one or two faults each, and what gaits make of them.

All have the built-in robot's description. Faults are of a size that changes a gait, not only a reading.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from blind.cases import Case, Label
from blind.chain import Floats
from blind.faults import FAULTS, draw_joints, go_together
from blind.motions import Motion
from blind.robot import Build, Parameters, Robot, gait_command, real_robot
from snakebot.diagnosis.proposal.motions import known_motions

FIRST_SEED = 600_000_000  # of no other set of ``cases``
PAIRS = 0.4  # share of the robots with two faults
# Magnitudes as ``faults`` takes them, drawn evenly in their logarithm; whether on all joints.
KINDS: dict[str, tuple[float, float, bool]] = {
    "rate_limit": (1.3, 5.0, True),  # 3 to 0.8 rad/s
    "torque_limit": (0.8, 2.5, True),  # 1.25 to 0.4 N m
    "compliance": (0.05, 0.5, True),  # 20 to 2 N m/rad
    "servo_lag": (1.0, 6.0, True),  # 60 to 210 ms
    "ground_friction": (0.3, 1.2, True),  # slip or drag: a coefficient 1.3 to 3.3 times as large, or as small
    "wheel_drag": (0.5, 3.0, True),  # N on one link
    "joint_free": (1.0, 1.0, False),
}
CYCLES, AVERAGED = 5, 2  # of a measured gait
MEASURED_S = 10.0  # of a run that a lab makes, as those of a diagnosis


@dataclass(frozen=True)
class GaitRobot:
    """A robot with what is wrong in it; ``rng`` makes the noise of its runs."""

    number: int
    faults: tuple[tuple[str, tuple[int, ...] | None, dict[str, float]], ...]
    parameters: Parameters
    rng: np.random.Generator

    @property
    def words(self) -> str:
        return ", ".join(
            name + (f" on {'+'.join(map(str, at))}" if at else "") for name, at, _ in self.faults
        )

    def label(self) -> dict[str, Any]:
        return {
            "faults": [{"name": name, "joints": at, "values": values} for name, at, values in self.faults]
        }

    def case(self) -> Case:
        """What a lab records of it: the starting set of a live diagnosis."""
        start = [
            Motion("gait", np.radians(gait.alpha_deg), np.radians(gait.beta_deg), gait.omega_rad_s)
            for gait in known_motions().start
        ]
        label = Label("gaits", 0.0, [], 0.0, 0.0)
        return Case(label, None, start, Build(), self.parameters, self.rng)


def draw_robot(seed: int, number: int) -> GaitRobot:
    """The kinds take turns, so that a few robots show most of them."""
    rng = np.random.default_rng([FIRST_SEED + seed, number])
    order = np.random.default_rng(FIRST_SEED + seed).permutation(list(KINDS))
    names = [str(order[number % len(order)])]
    if rng.random() < PAIRS:
        names.append(str(rng.choice([name for name in KINDS if go_together(names[0], name)])))
    parameters = real_robot(rng)
    found = []
    for name in names:
        low, high, everywhere = KINDS[name]
        magnitude = float(np.exp(rng.uniform(np.log(low), np.log(high))))
        count = parameters.joint_count
        joints = np.arange(count) if everywhere else draw_joints(name, rng, count)
        assert joints is not None
        values = FAULTS[name].apply(parameters, joints, magnitude, rng)
        told = None if everywhere else tuple(int(j) + 1 for j in joints)
        found.append((name, told, {key: float(value) for key, value in values.items()}))
    return GaitRobot(number, tuple(found), parameters, rng)


def true_speeds(parameters: Parameters, gaits: Floats) -> Floats:
    """Steady speeds in m/s of gaits (G, 3), rad and rad/s, read by perfect sensors."""
    robot, rng = Robot(parameters.noiseless()), np.random.default_rng(0)
    return np.array([_speed(robot, gait, rng, CYCLES, AVERAGED) for gait in gaits])


def measured_speed(robot: Robot, gait: Floats, rng: np.random.Generator) -> float:
    """What a lab measures of a gait in one run."""
    cycles = int(MEASURED_S * gait[2] / (2 * np.pi))
    if cycles < 2:
        return _speed(robot, gait, rng, 2, 1)
    return _speed(robot, gait, rng, cycles, max(1, cycles // 2))


def _speed(robot: Robot, gait: Floats, rng: np.random.Generator, cycles: int, averaged: int) -> float:
    alpha, beta, omega = (float(v) for v in gait)
    period = 2 * np.pi / omega
    t = np.arange(0.0, cycles * period + 0.02, 0.01)
    run = robot.run(t, gait_command(t, alpha, beta, omega, period, robot.parameters.joint_count), rng)
    ends = period * np.arange(cycles - averaged, cycles + 1)
    x, y = (np.interp(ends, t, run.pose[:, axis]) for axis in (0, 1))
    return float(np.hypot(np.diff(x), np.diff(y)).mean() / period)
