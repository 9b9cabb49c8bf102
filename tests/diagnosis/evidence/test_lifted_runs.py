"""A run in the air is predicted in the air: no ground, no way travelled, no repeat of one on the ground."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from sessions import make_run, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import Evidence, gather
from snakebot.effects import parse_effect, predict
from snakebot.gait import Gait, GaitMotion
from snakebot.lifted import lifted
from snakebot.runlog import Run, Session

SOFT = "compliance:stiffness_nm_rad=8"


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    """One motion on the ground, and in the air."""
    robot = snake()
    ground = make_run(robot, [SOFT], (40, 80, 2.0), "ground.csv", pose=True)
    t = ground.t_s
    command = GaitMotion(Gait(radians(40), radians(80), 2.0), robot.joints, 6.0, 1.0).sampled(t)
    made = predict(lifted(robot), [SOFT], t, command, quantise=False)
    air = Run("air.csv", t, command, made.encoder_rad, pose=ground.pose, metadata={"lifted": True})
    return gather(prepare(Session(robot, (ground, replace(air, forward_speed_m_s=0.1)))))


def test_in_the_air_the_effect_leaves_nothing_over(evidence: Evidence) -> None:
    predicted = evidence.predictor.simulator.predict([parse_effect(SOFT)])
    for run, made in zip(evidence.data.runs, predicted, strict=True):
        assert np.degrees(np.sqrt(np.mean(np.square(made.reading_rad - run.measured_rad)))) < 0.1, run.name
    rough = evidence.predictor.simulator.predict([parse_effect(SOFT)], rough=True)
    torques = [evidence.predictor.simulator.load(i) for i in (0, 1)]
    assert torques[0] is not None
    assert torques[1] is not None
    assert np.abs(torques[1]).max() < 0.5 * np.abs(torques[0]).max()
    assert all(np.isfinite(made.reading_rad).all() for made in rough)


def test_it_is_no_repeat_of_the_motion_on_the_ground_and_goes_nowhere(evidence: Evidence) -> None:
    ground, air = evidence.data.runs
    assert ground.motion != air.motion
    assert air.pose is None
    assert air.forward_speed_m_s is None
    assert evidence.ground is not None
    assert set(evidence.ground.features.run.tolist()) == {0}
