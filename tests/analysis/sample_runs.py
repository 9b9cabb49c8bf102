"""Runs of the simulated robot, made on the spot."""

from __future__ import annotations

import math

import numpy as np

from snakebot.analysis.loading import Loaded
from snakebot.effects import predict
from snakebot.gait import Gait, GaitMotion
from snakebot.robot import Robot, load_robot, robot_from_mapping
from snakebot.runlog import Run

PENN_STATE = load_robot("penn_state")
BENCH = robot_from_mapping({"joints": 1}, "bench")


def snake_run(
    alpha: float = 66,
    beta: float = 80,
    omega: float = 2,
    effects: tuple[str, ...] = (),
    cycles: float = 8,
    rate_hz: float = 50.0,
    name: str = "run",
    pose: bool = True,
    lost: float = 0.0,
    seed: int = 0,
    robot: Robot = PENN_STATE,
    **extra: object,
) -> Run:
    """A gait with its ramps on the robot with these effects, as its log would hold it."""
    gait = Gait.from_degrees(alpha, beta, omega)
    ramp = 2.0
    t = np.arange(0, cycles * 2 * math.pi / omega + 2 * ramp, 1 / rate_hz)
    command = GaitMotion(gait, robot.joints, float(t[-1]), ramp, [0.0] * robot.joints).sampled(t)
    found = predict(robot, effects, t, command, body=pose)
    rng = np.random.default_rng(seed)
    measured = found.encoder_rad.copy()
    measured[rng.random(len(t)) < lost] = np.nan
    where = None
    if pose and found.motion is not None:
        where = np.column_stack([found.motion.com_m, found.motion.heading_rad])
    faults = [e for e in effects if e.startswith(("joint_free", "joint_rigid"))]
    return Run(
        name=name,
        t_s=t,
        command_rad=command,
        measured_rad=measured,
        applied_rad=found.applied_rad,
        pose=where,
        gait=gait,
        extra={"latency_s": 0.004 + 0.001 * rng.random(len(t)), "late": rng.random(len(t)) < 0.01},
        metadata={"effects": faults, "simulated": True},
        **extra,  # type: ignore[arg-type]
    )


def bench_run(name: str = "chirp.csv") -> Run:
    """One servo on a bench: a chirp, with the servo off at the end."""
    t = np.arange(0, 12, 0.02)
    command = 0.8 * np.sin(0.4 * t**2)
    command[t > 10] = np.nan
    measured = np.interp(t - 0.1, t, np.nan_to_num(command))
    return Run(name, t, command[:, None], measured[:, None])


def loaded(run: Run, robot: Robot = PENN_STATE) -> Loaded:
    from pathlib import Path

    return Loaded(run, robot, Path(f"{run.name}.mcap"))
