"""Noise of the encoders: its interval holds it as often as it says, and it is none where the description states it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from sessions import make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.floor import white_noise
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.verdict.noise import noisy_encoders
from snakebot.runlog import Session

NOISE_DEG, DRAWS = 0.6, 60


def test_the_interval_of_the_noise_covers_it() -> None:
    session = make_session(snake())
    floor = gather(prepare(session)).floor
    rng, held = np.random.default_rng(0), 0
    for _ in range(DRAWS):
        runs = []
        for run in session.runs:
            noise_rad = np.radians(NOISE_DEG) * rng.normal(size=run.measured_rad.shape)
            runs.append(replace(run, measured_rad=run.measured_rad + noise_rad))
        data = prepare(Session(session.robot, tuple(runs)))
        white_rad = np.array([white_noise(data, joint) for joint in range(data.joints)])
        noise = noisy_encoders(data, replace(floor, white_rad=white_rad))
        assert noise is not None
        low, high = noise.ci95
        held += low <= NOISE_DEG <= high
        assert high - low < 0.1 * NOISE_DEG  # tens of thousands of readings tell more than that
    assert held >= 0.85 * DRAWS  # of 60 draws, fewer than 51 hold it once in 1000 where 95 % is meant


def test_scatter_that_the_description_states_is_no_noise() -> None:
    session = make_session(snake(), noise_deg=NOISE_DEG)
    data = prepare(session)
    floor = gather(data).floor
    assert noisy_encoders(data, floor) is not None
    stated = session.robot.tolerance.model_copy(update={"scatter_rad": np.radians(2 * NOISE_DEG)})
    robot = session.robot.model_copy(update={"tolerance": stated})
    assert noisy_encoders(replace(data, robot=robot), floor) is None
