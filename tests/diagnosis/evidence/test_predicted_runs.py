"""Predictions of recorded runs are those of the effects library, for some joints or all."""

from __future__ import annotations

import numpy as np
import pytest
from sessions import bench, make_session, snake

from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.evidence.recent import RecentRuns
from snakebot.effects import parse_effect, predict, servo_stage


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


def test_a_run_with_a_body_is_predicted_once_and_nobody_can_change_it() -> None:
    simulator = gather(prepare(make_session(snake(), duration_s=2.0))).predictor.simulator
    limit = [parse_effect("torque_limit:limit_nm=1.5")]
    first, again = simulator.predict(limit), simulator.predict(limit)
    assert all(a is b for a, b in zip(first, again, strict=True))
    assert simulator.predict(limit, [1], rough=True)[0] is first[1]  # rough or not, that takes the body
    with pytest.raises(ValueError, match="read-only"):
        first[0].reading_rad[0, 0] = 1.0


def test_the_runs_used_last_are_kept_up_to_a_size() -> None:
    made = gather(prepare(make_session(snake(), duration_s=2.0))).predictor.simulator.predict(())
    kept = RecentRuns(
        most_bytes=3 * (3 * 200 * 5 * 8 + 200 * 5)
    )  # three runs of angle, reading, load and power
    for key, run in enumerate(made[:3]):
        kept.keep(key, run)
    assert kept.get(0) is made[0]
    kept.keep(3, made[3])
    assert kept.get(1) is None
    assert kept.get(0) is made[0]
    small = RecentRuns(most_bytes=10)
    small.keep(0, made[0])
    assert small.get(0) is None


def test_a_first_look_beside_a_limit_takes_no_body(monkeypatch: pytest.MonkeyPatch) -> None:
    """Alone the limit shows as it does with a body; with more beside it, nearly so."""
    simulator = gather(prepare(make_session(snake(), duration_s=3.0))).predictor.simulator
    base = [
        parse_effect("torque_limit:limit_nm=1.5,joints=4"),
        parse_effect("encoder_offset:offset_deg=2,joints=3"),
    ]
    more = [*base, parse_effect("command_gain:gain=0.9,joints=2")]
    beside = simulator.beside(base)
    assert simulator.rough_needs_body(more)
    assert not beside.rough_needs_body(more)
    assert beside.needs_body(more)
    without = beside.predict(base, rough=True)
    for mine, its in zip(without, simulator.predict(base), strict=True):
        assert mine.reading_rad == pytest.approx(its.reading_rad, abs=1e-12)
    exact = simulator.predict(more)
    free = [parse_effect("joint_free:joints=1")]
    with_free = simulator.predict([*base, *free])

    def no_body(*_: object, **__: object) -> None:
        raise AssertionError("a body was simulated")

    with monkeypatch.context() as patch:
        patch.setattr(servo_stage, "_on_a_body", no_body)
        rough = beside.predict(more, rough=True)
    for mine, its, alone in zip(rough, exact, without, strict=True):
        change = its.reading_rad - alone.reading_rad
        assert np.std(mine.reading_rad - its.reading_rad) < 0.3 * np.std(change)
    for mine, its in zip(beside.predict([*base, *free], rough=True), with_free, strict=True):
        assert mine.reading_rad == pytest.approx(
            its.reading_rad, abs=1e-12
        )  # a free joint takes the body anyway
