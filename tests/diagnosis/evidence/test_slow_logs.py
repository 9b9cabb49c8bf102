"""Logs with fewer rows than there were set-points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.evidence.slow_logs import with_ticks
from snakebot.diagnosis.evidence.ticks import is_slow, set_points
from snakebot.diagnosis.verdict.probability import MOST_WHERE_GUESSED
from snakebot.runlog import Run, Session

GAITS = ((40, 80, 2.0), (30, 80, 3.0), (20, 80, 1.0), (15, 80, 5.0))


def rows_of(run: Run, rows: np.ndarray | slice, **metadata: Any) -> Run:
    return replace(
        run,
        t_s=run.t_s[rows],
        command_rad=run.command_rad[rows],
        measured_rad=run.measured_rad[rows],
        metadata=metadata,
    )


def session(effects: Sequence[str] = (), *, every: int, joints: int = 1, **metadata: Any) -> Session:
    """Runs driven at 100 Hz, of which every so many rows are logged."""
    whole = make_session(bench(joints), effects, gaits=GAITS, duration_s=8.0)
    return Session(
        whole.robot, tuple(rows_of(run, slice(None, None, every), **metadata) for run in whole.runs)
    )


def test_a_log_that_is_late_by_no_more_than_the_robot_may_be_needs_no_word() -> None:
    found = diagnose(session(every=2), quick=True)
    assert found.verdict == "no_gap"
    assert not found.warnings


@pytest.mark.parametrize("every", [5, 10])
def test_a_sound_robot_in_a_slow_log_has_no_gap_and_a_warning_says_why(every: int) -> None:
    found = diagnose(session(every=every), quick=True)
    assert found.verdict == "no_gap"
    (warning,) = found.warnings
    assert f": a row every {10 * every} ms, but the readings follow set-points between the rows" in warning
    assert warning.endswith("log a row for every set-point")


def test_rows_that_are_missing_at_random_are_no_gap() -> None:
    whole = session(every=1)
    rng = np.random.default_rng(0)
    runs = [rows_of(run, np.sort(rng.choice(len(run), len(run) // 2, replace=False))) for run in whole.runs]
    assert diagnose(Session(whole.robot, tuple(runs)), quick=True).verdict == "no_gap"


def test_a_cause_in_a_slow_log_is_found_and_not_sure() -> None:
    found = diagnose(session(["rate_limit:limit_rad_s=0.5,joints=2"], every=5, joints=2), quick=True)
    assert found.verdict == "explained"
    (cause,) = found.causes
    assert (cause.effect, cause.joints) == ("rate_limit", (2,))
    assert cause.parameters["limit_rad_s"].estimate == pytest.approx(0.5, rel=0.02)
    assert cause.probability <= MOST_WHERE_GUESSED
    assert max(entry.probability for entry in found.ranking) <= MOST_WHERE_GUESSED


def test_a_log_that_tells_the_rate_is_believed() -> None:
    found = diagnose(session(every=5, rate_hz=100.0), quick=True)
    assert found.verdict == "no_gap"
    assert "a row every 50 ms, but set-points came every 10 ms" in found.warnings[0]


@pytest.mark.parametrize(("every", "metadata"), [(1, {"rate_hz": 100.0}), (2, {"rate_hz": 50.0}), (1, {})])
def test_a_row_for_every_set_point_is_held_whatever_the_gap(every: int, metadata: dict[str, Any]) -> None:
    """A servo that is faster than described leads, as in a slow log; a log that is not slow is none."""
    data = prepare(session(["servo_lag:time_constant_s=0.01"], every=every, **metadata))
    evidence = gather(data)
    assert with_ticks(evidence) is None
    for run in data.runs:
        times, told = set_points(run)
        assert times is run.t_s
        assert told is run.command_rad


def test_set_points_between_rows_pass_through_the_rows_and_do_not_overshoot() -> None:
    t = np.arange(0, 4, 0.1)
    told = np.column_stack([np.where(t < 2, 0.0, 0.5), 0.2 * t, np.where(t < 1, np.nan, np.sin(3 * t))])
    run = Run("a", t, told, np.zeros_like(told), metadata={"rate_hz": 100})
    (prepared,) = prepare(Session(bench(3), (run,))).runs
    assert is_slow(prepared)
    times, made = set_points(prepared)
    assert times.size == 391
    assert np.diff(times) == pytest.approx(0.01)
    assert made[::10] == pytest.approx(told, nan_ok=True)
    assert made[:, 0].min() >= 0.0
    assert made[:, 0].max() <= 0.5
    assert made[:, 1] == pytest.approx(0.2 * times)
    assert np.isnan(made[:, 2]).tolist() == (times < 1 - 1e-9).tolist()
    assert np.abs(made[110:, 2] - np.sin(3 * times[110:])).max() < 0.005


@pytest.mark.parametrize("rate", [True, "fast", -5, 0, float("nan"), float("inf")])
def test_a_rate_that_is_none_is_not_taken_for_one(rate: object) -> None:
    data = prepare(session(every=1, rate_hz=rate))
    assert all(run.tick_s is None for run in data.runs)
