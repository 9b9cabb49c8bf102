"""Small sessions with a known truth, predicted by the effects library and made noisy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import radians

import numpy as np

from snakebot.effects import predict
from snakebot.gait import Gait, GaitMotion
from snakebot.robot import Robot, load_robot
from snakebot.runlog import Run, Session

GAITS = ((66, 80, 2.0), (30, 80, 4.0), (50, 60, 1.0))


def bench(joints: int = 2) -> Robot:
    return Robot(name="bench", joints=joints)


def make_run(
    robot: Robot,
    effects: Sequence[str],
    gait: tuple[float, float, float],
    name: str,
    *,
    seed: int = 0,
    duration_s: float = 6.0,
    noise_deg: float = 0.05,
    pose: bool = False,
) -> Run:
    rng = np.random.default_rng(seed)
    alpha, beta, omega = gait
    wave = Gait(radians(alpha), radians(beta), omega)
    t = np.arange(int(duration_s * 100)) / 100
    command = GaitMotion(wave, robot.joints, duration_s, 1.0).sampled(t)
    made = predict(robot, effects, t, command, body=pose, quantise=False)
    step = robot.rad_per_count
    reading = made.encoder_rad + np.radians(noise_deg) * rng.normal(size=command.shape)
    where = None
    if pose and made.motion is not None:
        where = np.column_stack([made.motion.com_m, made.motion.heading_rad])
    return Run(name, t, command, np.round(reading / step) * step, pose=where, gait=wave)


def make_session(
    robot: Robot,
    effects: Sequence[str] = (),
    *,
    gaits: Sequence[tuple[float, float, float]] = GAITS,
    **options: object,
) -> Session:
    """One run a gait, and the first gait again."""
    runs = [
        make_run(robot, effects, gait, f"run_{i + 1:02d}.csv", seed=i, **options)  # type: ignore[arg-type]
        for i, gait in enumerate(gaits)
    ]
    again = make_run(robot, effects, gaits[0], f"run_{len(gaits) + 1:02d}.csv", seed=99, **options)  # type: ignore[arg-type]
    return Session(robot, (*runs, replace(again, repeat_of=runs[0].name)))


def lossy_session(robot: Robot, probability: float, effects: Sequence[str] = ()) -> Session:
    """``make_session`` of a robot that each set-point reaches by chance, each run by its own."""
    session = make_session(robot)
    runs = []
    for number, run in enumerate(session.runs):
        lost = np.random.default_rng(number).random(len(run)) < probability
        lost[0] = False
        arrived = run.command_rad[np.maximum.accumulate(np.where(lost, 0, np.arange(len(run))))]
        runs.append(replace(run, measured_rad=predict(robot, effects, run.t_s, arrived).encoder_rad))
    return replace(session, runs=tuple(runs))


def snake() -> Robot:
    return load_robot("penn_state")
