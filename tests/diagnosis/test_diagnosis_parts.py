"""The steps of a diagnosis, one by one."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sessions import bench, make_run, make_session, snake

import snakebot.diagnosis.result as result
from snakebot.diagnosis.blocks import block_map, mean_difference, resample
from snakebot.diagnosis.candidates import candidates, usable_effects
from snakebot.diagnosis.context import make_context
from snakebot.diagnosis.data import link_is_clean, prepare, spikes
from snakebot.diagnosis.fit import Problem, minimise, multi_start, refit
from snakebot.diagnosis.fitting import predicted_readings
from snakebot.diagnosis.floor import noise_floor
from snakebot.diagnosis.folds import folds
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.hypothesis import Hypothesis, Term
from snakebot.diagnosis.probability import Evidence, calibration, probability, shared
from snakebot.diagnosis.reference import limited, play
from snakebot.diagnosis.regime import sentence
from snakebot.diagnosis.smoothing import smoothed
from snakebot.diagnosis.trial import nominal_trial, run_trial
from snakebot.effects import parse_effect, predict
from snakebot.runlog import Session


def test_the_published_schema_is_the_one_of_the_types() -> None:
    published = Path(result.__file__).with_name("diagnosis-1.schema.json")
    assert json.loads(published.read_text()) == result.json_schema()


def test_repeats_and_equal_commands_never_part_between_folds() -> None:
    session = make_session(bench(1))
    twin = replace(
        make_run(bench(1), (), (30, 80, 4.0), "twin.csv", seed=7), repeat_of=None
    )  # not marked as a repeat
    data = prepare(Session(session.robot, (*session.runs, twin)))
    by_name = {run.name: run.motion for run in data.runs}
    assert by_name["twin.csv"] == by_name["run_02.csv"]
    assert by_name["run_04.csv"] == by_name["run_01.csv"]
    made = folds(data)
    assert len(made) == 3
    for fold in made:
        fitted, scored = ({data.runs[i].motion for i in part} for part in (fold.fit, fold.score))
        assert not fitted & scored
    assert sorted(i for fold in made for i in fold.score) == list(range(5))


def test_held_out_runs_are_in_no_fold() -> None:
    session = make_session(bench(1))
    data = prepare(replace(session, runs=(replace(session.runs[1], hold_out=True), *session.runs[2:])))
    assert all(0 not in (*fold.fit, *fold.score) for fold in folds(data))


def test_the_floor_of_repeats_is_the_noise_put_in() -> None:
    floor = noise_floor(
        prepare(make_session(bench(), noise_deg=0.3, duration_s=20.0, gaits=((40, 80, 2.0),)))
    )
    assert np.degrees(floor.repeat_rad) == pytest.approx([0.3, 0.3], rel=0.1)
    assert np.degrees(floor.white_rad) == pytest.approx([0.3, 0.3], rel=0.2)


def test_a_floor_without_repeats_is_that_of_the_readings() -> None:
    session = make_session(bench(1), noise_deg=0.2)
    floor = noise_floor(prepare(replace(session, runs=session.runs[:3])))
    assert not floor.known
    assert np.degrees(floor.rad) == pytest.approx([0.2], rel=0.25)


def test_lone_spikes_are_taken_out_and_steps_are_not() -> None:
    wave = np.sin(np.linspace(0, 6, 300))[:, None]
    wave[100] += 0.5
    wave[200:] += 0.5
    assert np.flatnonzero(spikes(wave, 0.01)[:, 0]).tolist() == [100]


def test_what_follows_a_hole_in_time_is_not_compared_until_the_servo_has_settled() -> None:
    session = make_session(bench(1))
    run = session.runs[0]
    rows = (run.t_s < 2.0) | (run.t_s >= 3.0)
    rows[450] = False  # a lone row, long after
    holed = replace(
        run, t_s=run.t_s[rows], command_rad=run.command_rad[rows], measured_rad=run.measured_rad[rows]
    )
    prepared = prepare(replace(session, runs=(holed,))).runs[0]
    masked = prepared.t_s[~prepared.use[:, 0]]
    settled_s = 5 * session.robot.servo.time_constant_s
    assert masked[0] == pytest.approx(3.0)
    assert masked[masked < 4][-1] == pytest.approx(3.0 + settled_s, abs=0.011)
    assert masked[masked > 4][[0, -1]] == pytest.approx([4.51, 4.56], abs=0.011)


def test_blocks_partition_the_samples_in_use() -> None:
    data = prepare(make_session(bench()))
    blocks = block_map(data)
    total = sum(int((b >= 0).sum()) for b in blocks.of_sample)
    assert blocks.samples.sum() == total
    residual = [np.full(run.use.shape, 2.0) for run in data.runs]
    assert blocks.mean_square(residual) == pytest.approx(np.full(blocks.count, 4.0))


@given(st.lists(st.floats(-1, 1), min_size=4, max_size=40), st.floats(0.1, 10))
def test_the_error_of_a_mean_scales_and_does_not_shift(values: list[float], factor: float) -> None:
    gain, cluster = np.array(values), np.zeros(len(values), dtype=np.int64)
    one, other = mean_difference(gain, cluster), mean_difference(factor * gain + 3, cluster)
    assert other.mean == pytest.approx(factor * one.mean + 3, abs=1e-9)
    assert other.se == pytest.approx(factor * one.se, rel=1e-6, abs=1e-9)


def test_correlated_blocks_have_a_larger_error() -> None:
    rng = np.random.default_rng(0)
    white = rng.normal(size=4000)
    walk = np.convolve(white, [1, 1], "same") / np.sqrt(2)
    cluster = np.zeros(4000, dtype=np.int64)
    assert mean_difference(walk, cluster).se > 1.3 * mean_difference(white, cluster).se


def test_the_bootstrap_stays_within_runs() -> None:
    cluster = np.array([0, 0, 0, 2, 2])
    draw = resample(cluster, np.random.default_rng(0), 50)
    assert (cluster[draw] == cluster).all()


def test_fit_of_several_units_at_once_finds_each_ones_parameters() -> None:
    x = np.linspace(0, 4, 200)[:, None]
    truth = np.array([[2.0, 0.5], [0.7, 3.0]])
    data = truth[:, 0] * np.exp(-x * truth[:, 1])

    def residual(theta: np.ndarray) -> np.ndarray:
        return np.asarray(data - theta[:, 0] * np.exp(-x * theta[:, 1]))

    block = (np.arange(200) // 20)[:, None] + np.array([0, 10])
    problem = Problem(
        residual, np.array([0, 1]), block, np.full(20, 1e-4), np.array([0.01, 0.01]), np.array([10.0, 10.0]),
        np.array([True, False]),
    )  # fmt: skip
    fit = multi_start(problem, [np.ones((2, 2)), np.full((2, 2), 5.0)])
    assert fit.theta == pytest.approx(truth, rel=1e-3)


def test_a_fit_stays_within_bounds() -> None:
    def residual(theta: np.ndarray) -> np.ndarray:
        return np.repeat(theta - 5.0, 10, axis=0)

    block = np.zeros((10, 1), dtype=np.int64)
    problem = Problem(
        residual, np.array([0]), block, np.ones(1), np.array([0.0]), np.array([2.0]), np.array([False])
    )
    assert minimise(problem, np.array([[1.0]])).theta[0, 0] == pytest.approx(2.0)


def ramp_problem(slope: float, noise: float = 0.0) -> Problem:
    """A straight line through zero, its slope unknown; forty samples in four blocks."""
    x = np.arange(1.0, 41.0)[:, None]
    seen = slope * x + noise * np.random.default_rng(3).normal(size=x.shape)
    block = np.repeat(np.arange(4), 10)[:, None]
    box = (np.array([0.0]), np.array([10.0]), np.array([False]))
    return Problem(lambda theta: theta[0, 0] * x - seen, np.zeros(1, dtype=np.int64), block, np.ones(4), *box)


def test_a_refit_is_the_minimum_of_what_counts() -> None:
    problem = ramp_problem(2.0, noise=0.5)
    whole = minimise(problem, np.array([[1.0]])).theta[0]
    for out in range(4):
        use = problem.block != out
        left = replace(problem, block=np.where(use, problem.block, -1))
        exact = minimise(left, whole[None]).theta[0]
        (near,) = refit(problem, whole, [use])
        assert near.theta == pytest.approx(exact, abs=0.2 * abs(exact - whole)[0] + 1e-6)


def test_no_search_begins_where_what_is_fitted_does_nothing() -> None:
    """A limit above all that is seen costs as little as none, and a search that starts there stays there."""
    x = np.linspace(0, 2, 40)[:, None]
    seen = np.minimum(x, 1.6)

    def residual(theta: np.ndarray) -> np.ndarray:
        return np.asarray(np.minimum(x, theta[0, 0]) - seen)

    box = (np.array([0.1]), np.array([10.0]), np.array([False]))
    block = np.zeros((40, 1), dtype=np.int64)
    problem = Problem(residual, np.zeros(1, dtype=np.int64), block, np.ones(1), *box)
    starts = [np.array([[5.0]]), np.array([[0.9]])]
    assert multi_start(problem, starts, 1).theta[0, 0] == pytest.approx(5.0)
    awake = replace(problem, idle=residual(np.array([[np.inf]])))
    assert multi_start(awake, starts, 1).theta[0, 0] == pytest.approx(1.6, abs=1e-3)


def test_simulating_some_joints_gives_what_simulating_all_gives() -> None:
    context = make_context(prepare(make_session(snake(), duration_s=3.0)), {}, 0)
    specs = [
        parse_effect("rate_limit:limit_rad_s=1.2,joints=2+4"),
        parse_effect("servo_offset:offset_deg=3,joints=4"),
    ]
    every = [p.reading_rad for p in context.simulator.predict(specs)]
    some = predicted_readings(context, specs, range(len(context.data.runs)))
    for a, b in zip(every, some, strict=True):
        assert a == pytest.approx(b, abs=1e-12)
    assert all(np.isnan(p.reading_rad).all() for p in context.simulator.predict(specs, columns=[]))


def test_where_nothing_is_left_no_effect_is_tried_beside_it() -> None:
    context = make_context(prepare(make_session(snake(), duration_s=3.0)), {}, 0)
    nominal = nominal_trial(context)
    assert not gap_of(context, nominal).any
    for effect in usable_effects(context):
        if effect.stage != "body" and effect.per_joint and effect.name != "wiring":
            assert candidates(context, nominal, effect) == []


def test_predictions_are_those_of_the_effects_library() -> None:
    session = make_session(bench(), ["backlash:width_deg=4"], noise_deg=0.0)
    context = make_context(prepare(session), {}, 0)
    specs = [parse_effect("backlash:width_deg=4")]
    run = session.runs[0]
    expected = predict(
        bench(), specs, run.t_s, run.command_rad, measured_rad=run.measured_rad, quantise=False
    )
    assert context.simulator.predict(specs)[0].reading_rad == pytest.approx(expected.encoder_rad, abs=1e-12)


def test_held_out_squares_are_worse_than_fitted_ones_for_an_effect_that_is_not_there() -> None:
    context = make_context(prepare(make_session(bench(1))), {}, 0)
    trial = run_trial(context, Hypothesis((Term("second_order", None),)), [np.array([60.0, 1.0])])
    assert trial.held_square.mean() >= trial.fitted_square.mean()


def test_a_hypothesis_gives_the_specs_it_names() -> None:
    hypothesis = Hypothesis((Term("rate_limit", (2,)), Term("command_delay", None)))
    assert [str(spec) for spec in hypothesis.specs([1.5, 0.02])] == [
        "rate_limit:limit_rad_s=1.5,joints=2",
        "command_delay:delay_s=0.02",
    ]
    assert hypothesis.joints(3) == (1, 2, 3)
    assert hypothesis.without(1).joints(3) == (2,)


def test_operators_of_the_reference() -> None:
    x = np.array([0.0, 1.0, 2.0, 1.5, 0.5, 0.5])
    assert play(x, 0.5).tolist() == [0.0, 0.5, 1.5, 1.5, 1.0, 1.0]
    assert limited(np.arange(6.0), x, 0.6) == pytest.approx([0.0, 0.6, 1.2, 1.5, 0.9, 0.5])


def test_smoothing_keeps_motion_and_takes_noise() -> None:
    t = np.arange(0, 5, 0.01)
    wave = np.sin(4 * t)[:, None]
    noise = np.random.default_rng(0).normal(size=wave.shape) * 0.01
    out = smoothed(t, wave + noise)
    assert np.std(out - wave) < 0.6 * 0.01
    assert smoothed(t, wave) == pytest.approx(wave, abs=2e-3)


def test_smoothing_goes_by_time_where_rows_are_missing() -> None:
    t = np.arange(1000) / 100
    kept = np.random.default_rng(1).random(t.size) < 0.8
    kept[[0, -1]] = True
    wave = np.sin(3 * t)[:, None]
    assert smoothed(t[kept], wave[kept]) == pytest.approx(wave[kept], abs=2e-3)


def test_probabilities_rise_with_the_lead_and_fall_with_the_rest() -> None:
    poor = Evidence(lead=3.0, rest=500.0, closed=0.98, rivals=0, motions=4, explained=True)
    assert probability(poor) <= 0.6  # so much left over: not the whole story
    base = Evidence(lead=0.3, rest=1.0, closed=0.98, rivals=0, motions=4, explained=True)
    assert probability(replace(base, lead=1.0)) >= probability(base) >= probability(replace(base, lead=0.0))
    assert probability(replace(base, rest=50.0)) < probability(base)
    assert probability(replace(base, motions=1)) <= 0.5
    assert calibration().cases > 0
    assert "calibrate" in calibration().command
    assert sum(shared(0.9, [-0.1, -0.2, -0.1])) == pytest.approx(0.9)


def test_applied_set_points_clear_the_link_of_suspicion() -> None:
    session = make_session(bench(1))

    def with_applied(ticks: int) -> Session:
        return replace(
            session,
            runs=tuple(replace(r, applied_rad=np.roll(r.command_rad, ticks, axis=0)) for r in session.runs),
        )

    assert not link_is_clean(prepare(session))
    assert link_is_clean(prepare(with_applied(0)))
    assert link_is_clean(prepare(with_applied(1)))
    assert not link_is_clean(prepare(with_applied(5)))


def test_the_sentence_names_the_load_or_the_angle_beside_the_largest_regime() -> None:
    def bins(axis: str, *rms: float) -> list[result.Regime]:
        return [
            result.Regime(axis=axis, bin=f"bin {i}", rms_before_rad=r, rms_after_rad=r / 2, samples=50)
            for i, r in enumerate(rms)
        ]

    time, angle = bins("time since start", 0.1, 0.5), bins("angle", 0.1, 0.3)
    both = sentence([*time, *angle])
    assert both.startswith("the gap is largest by time since start: 29 deg rms bin 1, 5.7 deg rms bin 0")
    assert both.endswith("; by angle: 17 deg rms bin 1, 5.7 deg rms bin 0")
    assert "angle" not in sentence([*time, *bins("angle", 0.1, 0.12)])
    assert sentence(angle, rest=True) == "the rest is largest by angle: 8.6 deg rms bin 1, 2.9 deg rms bin 0"
    assert "much the same" in sentence(bins("load", 0.1, 0.11))
