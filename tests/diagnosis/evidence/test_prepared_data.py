"""Runs made ready: spikes, holes, motions, folds, the link."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, make_run, make_session

from snakebot.diagnosis.evidence.data import link_is_clean, prepare, spikes
from snakebot.diagnosis.evidence.folds import folds
from snakebot.runlog import Session


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
