"""Predictions of recorded runs are those of the effects library, for some joints or all."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import bench, make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.effects import parse_effect, predict


def test_simulating_some_joints_gives_what_simulating_all_gives() -> None:
    evidence = gather(prepare(make_session(snake(), duration_s=3.0)))
    specs = [
        parse_effect("rate_limit:limit_rad_s=1.2,joints=2+4"),
        parse_effect("servo_offset:offset_deg=3,joints=4"),
    ]
    every = [p.reading_rad for p in evidence.predictor.simulator.predict(specs)]
    some = evidence.predictor.readings(specs, range(len(evidence.data.runs)))
    for a, b in zip(every, some, strict=True):
        assert a == pytest.approx(b, abs=1e-12)
    assert all(np.isnan(p.reading_rad).all() for p in evidence.predictor.simulator.predict(specs, columns=[]))


def test_predictions_are_those_of_the_effects_library() -> None:
    session = make_session(bench(), ["backlash:width_deg=4"], noise_deg=0.0)
    evidence = gather(prepare(session))
    specs = [parse_effect("backlash:width_deg=4")]
    run = session.runs[0]
    expected = predict(
        bench(), specs, run.t_s, run.command_rad, measured_rad=run.measured_rad, quantise=False
    )
    assert evidence.predictor.simulator.predict(specs)[0].reading_rad == pytest.approx(
        expected.encoder_rad, abs=1e-12
    )
