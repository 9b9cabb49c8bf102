"""What the motion over ground may be off by: the noise of the pose, and what servos do between samples."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.evidence.ground import Feature, GroundFeatures, measured_ground
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.trial import run_trial
from snakebot.effects import predict
from snakebot.gait import Gait, GaitMotion
from snakebot.runlog import Run, Session

NOISE = np.array(
    [0.003, 0.003, radians(0.3)]
)  # m, m, rad: of a cheap camera; the quicker of two gaits has it
NOISY = 1


def measured(session: Session, rng: np.random.Generator) -> GroundFeatures:
    runs = list(session.runs)
    pose = runs[NOISY].pose
    assert pose is not None
    runs[NOISY] = replace(runs[NOISY], pose=pose + NOISE * rng.normal(size=pose.shape))
    found = measured_ground(prepare(Session(session.robot, tuple(runs))), frozenset({(0, 3)}))
    assert found is not None
    return found


def test_the_floor_of_a_velocity_holds_the_noise_of_the_pose_in_that_run() -> None:
    """Repeats of another gait do not show it: their windows are longer, and here their pose is better, too."""
    session, rng = make_session(snake(), pose=True), np.random.default_rng(0)
    found = [measured(session, rng) for _ in range(40)]
    values = np.stack([features.value for features in found])
    for kind in Feature:
        rows = (found[0].run == NOISY) & (found[0].kind == kind)
        spread = values[:, rows].var(axis=0).mean()
        floor = np.mean([features.floor_square[rows].mean() for features in found])
        assert 0.9 * spread < floor < 2.0 * spread
        calm = (found[0].run == 0) & (found[0].kind == kind)
        assert found[0].floor_square[calm].mean() < 0.2 * floor


def held_at_50_hz(gait: tuple[float, float, float], name: str, seed: int) -> Run:
    """A sound robot whose servos hold each set-point for 20 ms, seen at the times of the set-points."""
    alpha, beta, omega = gait
    wave, parts = Gait(radians(alpha), radians(beta), omega), 20
    robot, rng = snake(), np.random.default_rng(seed)
    t = np.arange(500) / 50
    command = GaitMotion(wave, robot.joints, 10.0, 1.0).sampled(t)
    fine = np.arange(500 * parts) / (50 * parts)
    made = predict(robot, (), fine, np.repeat(command, parts, axis=0), body=True, quantise=False)
    assert made.motion is not None
    pose = np.column_stack([made.motion.com_m, made.motion.heading_rad])[::parts]
    pose = pose + np.array([0.001, 0.001, radians(0.1)]) * rng.normal(size=pose.shape)
    reading = made.encoder_rad[::parts] + radians(0.05) * rng.normal(size=command.shape)
    return Run(name, t, command, reading, pose=pose, gait=wave)


def test_a_sound_robot_with_slow_set_points_has_no_gap_over_ground() -> None:
    """Its joints ripple between the samples, and that costs speed."""
    gaits = ((70.0, 69.5, 1.94), (45.0, 75.0, 3.3), (70.0, 69.0, 1.24))
    runs = [held_at_50_hz(gait, f"run_{i + 1:02d}.csv", i) for i, gait in enumerate(gaits)]
    again = replace(held_at_50_hz(gaits[0], "run_04.csv", 9), repeat_of="run_01.csv")
    evidence = gather(prepare(Session(snake(), (*runs, again))))
    gap = gap_of(evidence.scoring, run_trial(evidence, Hypothesis(()), []).held_square)
    assert not gap.ground_significant
    assert gap.ground_ratio < 1.0
