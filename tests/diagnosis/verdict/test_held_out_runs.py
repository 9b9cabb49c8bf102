"""Runs that the user holds out: nothing is fitted there, but a gap there is a gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from sessions import bench, make_run

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.show.words import summary
from snakebot.runlog import Session

ROBOT = bench(1)
LIMIT = "rate_limit:limit_rad_s=1.5"


def session(
    effects: Sequence[str], gaits: Sequence[tuple[float, float, float]], last: Sequence[str] | None = None
) -> Session:
    """A run each gait, the first one again, and the last gait held out, under effects of its own if ``last``."""
    runs = [
        make_run(ROBOT, effects, gait, f"run_{i + 1:02d}", seed=i, duration_s=8.0)
        for i, gait in enumerate(gaits)
    ]
    again = make_run(ROBOT, effects, gaits[0], "again", seed=9, duration_s=8.0)
    if last is not None:
        runs[-1] = make_run(ROBOT, last, gaits[-1], runs[-1].name, seed=8, duration_s=8.0)
    runs[-1] = replace(runs[-1], hold_out=True)
    return Session(ROBOT, (*runs, replace(again, repeat_of="run_01")))


def test_a_gap_in_the_held_out_run_alone_is_unexplained_and_says_where() -> None:
    calm = ((20, 80, 1.0), (20, 80, 2.0), (10, 80, 3.0), (50, 80, 4.0))  # only the last one is fast enough
    found = diagnose(session([LIMIT], calm), quick=True)
    assert found.verdict == "unexplained"
    assert not found.causes
    assert found.where.joints == (1,)
    assert found.where.stage == "servo"
    assert found.where.regime.startswith("in run_04, held out: the gap is largest")
    angle = found.closure.joint_angle
    assert found.closure.held_out_runs == ("run_04",)
    assert np.degrees(angle.rms_before) > 5
    assert angle.closed == 0.0
    assert any(
        w.startswith("in run_04, held out: there is a gap, and none in the runs") for w in found.warnings
    )
    assert found.unexplained.significant
    assert found.unexplained.share == 1.0
    assert "no gap" not in " ".join(summary(found)).lower()


def test_an_explanation_that_fails_in_the_held_out_run_does_not_explain() -> None:
    gaits = ((40, 80, 2.0), (30, 80, 3.0), (20, 80, 1.0), (50, 80, 4.0))
    lag = ["servo_lag:time_constant_s=0.09"]
    assert diagnose(session(lag, gaits), quick=True, only=["servo_lag"]).verdict == "explained"
    found = diagnose(session(lag, gaits, [*lag, LIMIT]), quick=True, only=["servo_lag"])
    assert found.verdict == "unexplained"
    assert found.unexplained.where.startswith("in run_04, held out: ")
    assert any(w.startswith("in run_04, held out: ") and "of the gap is left" in w for w in found.warnings)


def test_a_held_out_run_without_a_gap_changes_nothing() -> None:
    found = diagnose(session([], ((40, 80, 2.0), (30, 80, 3.0), (20, 80, 1.0))), quick=True)
    assert found.verdict == "no_gap"
    assert not found.warnings


def test_a_held_out_run_tests_what_one_fitted_motion_shows() -> None:
    slow, fast, faster = (5, 80, 1.0), (40, 80, 3.0), (50, 80, 3.5)
    tested = diagnose(session([LIMIT], (slow, fast, (8, 80, 1.5), faster)), quick=True)
    untested = diagnose(session([LIMIT], (slow, fast, (8, 80, 1.5), (6, 80, 2.0))), quick=True)
    for found, said in ((tested, False), (untested, True)):
        assert [cause.effect for cause in found.causes] == ["rate_limit"]
        assert any("nothing tests it" in warning for warning in found.warnings) == said
    assert tested.closure.joint_angle.closed is not None
    assert tested.closure.joint_angle.closed > 0.95
    assert untested.closure.joint_angle.closed is None


def test_what_makes_the_held_out_run_worse_keeps_its_name_and_says_where_it_fails() -> None:
    gaits = ((40, 80, 2.0), (30, 80, 3.0), (20, 80, 1.0), (50, 80, 4.0))
    less = session(["servo_lag:time_constant_s=0.09"], gaits, ["servo_lag:time_constant_s=0.045"])
    found = diagnose(less, quick=True, only=["servo_lag"])
    assert found.verdict == "unexplained"
    assert [cause.effect for cause in found.causes] == ["servo_lag"]
    assert found.causes[0].probability <= 0.5
    assert found.unexplained.where.startswith("in run_04, held out: ")
