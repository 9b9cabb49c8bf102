"""The noise floor, blocks and their statistics, smoothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sessions import bench, make_session

from snakebot.diagnosis.evidence.blocks import block_map, mean_difference, resample
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.floor import noise_floor
from snakebot.diagnosis.evidence.operators import limited, play
from snakebot.smoothing import smoothed


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


def test_runs_of_one_block_each_tell_of_chance_by_how_far_they_are_apart() -> None:
    gain = np.array([1.0, -0.5, 2.0, 0.2])
    one_each = mean_difference(gain, np.arange(4))
    assert one_each.se == pytest.approx(gain.std(ddof=1) / 2)
    assert (
        mean_difference(np.repeat(gain, 2), np.repeat(np.arange(4), 2)).se == 0
    )  # runs differ by what they show


def test_the_bootstrap_stays_within_runs() -> None:
    cluster = np.array([0, 0, 0, 2, 2])
    draw = resample(cluster, np.random.default_rng(0), 50)
    assert (cluster[draw] == cluster).all()


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
