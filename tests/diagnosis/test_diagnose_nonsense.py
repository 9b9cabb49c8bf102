"""Nonsense in: an error or a warning that names the problem, never a confident verdict."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, make_session, snake

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.evidence.sanity import check_session
from snakebot.errors import BadInputError
from snakebot.runlog import Run, Session


def changed(session: Session, **columns: object) -> Session:
    """Every run with its columns passed through functions."""
    runs = []
    for run in session.runs:
        new = {name: function(getattr(run, name)) for name, function in columns.items()}  # type: ignore[operator]
        runs.append(replace(run, **new))
    return replace(session, runs=tuple(runs))


def test_degrees_are_recognised() -> None:
    with pytest.raises(BadInputError, match="degrees"):
        diagnose(changed(make_session(bench(1)), measured_rad=np.degrees))
    with pytest.raises(BadInputError, match="degrees"):
        diagnose(changed(make_session(bench(1)), command_rad=np.degrees))


def test_small_commands_in_degrees_are_recognised_by_their_ratio() -> None:
    session = make_session(bench(1), gaits=((5, 0, 2.0), (4, 0, 4.0), (3, 0, 1.0)))
    with pytest.raises(BadInputError, match=r"57\.\d times the readings: are the columns cmd in degrees"):
        diagnose(changed(session, command_rad=np.degrees))


def test_no_motion() -> None:
    with pytest.raises(BadInputError, match="no motion is commanded"):
        diagnose(changed(make_session(bench(1)), command_rad=lambda c: 0 * c, measured_rad=lambda m: 0 * m))


def test_all_joints_dead() -> None:
    with pytest.raises(BadInputError, match="no joint moves"):
        diagnose(changed(make_session(bench()), measured_rad=lambda m: 0 * m + 0.1))


def test_no_readings() -> None:
    with pytest.raises(BadInputError, match="enc"):
        diagnose(changed(make_session(bench()), measured_rad=lambda m: np.nan * m))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("effect", ["servo_lag:time_constant_s=0.09", "command_delay:delay_s=0.06"])
def test_nothing_is_said_of_a_joint_that_was_never_read(effect: str) -> None:
    session = make_session(bench(3), [effect])
    blind = changed(session, measured_rad=lambda m: np.where(np.arange(3) == 1, np.nan, m))
    found = diagnose(blind, quick=True, only=["servo_lag", "command_delay"])
    (cause,) = found.causes
    assert cause.effect == effect.split(":")[0]
    assert cause.joints == (1, 3)
    assert found.where.joints == (1, 3)
    assert cause.effect == "command_delay" or cause.specification.endswith("joints=1+3")
    assert all(2 not in entry.joints for entry in found.ranking)
    assert any("joint 2: no reading in any run" in warning for warning in found.warnings)


def test_no_runs_and_short_runs() -> None:
    with pytest.raises(BadInputError, match="no runs"):
        diagnose(Session(bench(1), ()))
    t = np.arange(5) / 100
    run = Run("a", t, t[:, None], t[:, None])
    with pytest.raises(BadInputError, match="shorter than"):
        diagnose(Session(bench(1), (run,)))


def test_nothing_is_left_to_fit() -> None:
    session = make_session(bench(1))
    held = tuple(replace(run, hold_out=True) for run in session.runs)
    with pytest.raises(BadInputError, match="every run is marked hold_out: nothing is left to fit"):
        diagnose(replace(session, runs=held))
    t = np.arange(5) / 100
    short = Run("short", t, t[:, None], t[:, None])
    with pytest.raises(BadInputError, match="every run of at least 8 samples is marked hold_out"):
        diagnose(replace(session, runs=(*held, short)))
    unread = replace(session.runs[0], measured_rad=np.nan * session.runs[0].measured_rad)
    with pytest.raises(BadInputError, match="no sample of any run that may be fitted has both"):
        diagnose(replace(session, runs=(unread, *held[1:])))


def test_one_run_gives_no_confident_verdict() -> None:
    session = make_session(bench(1), ["rate_limit:limit_rad_s=1.3"])
    found = diagnose(replace(session, runs=session.runs[:1]), quick=True)
    assert all(cause.probability <= 0.5 for cause in found.causes)
    assert any("only one motion" in warning for warning in found.warnings)


def test_shuffled_columns_are_named_as_wiring() -> None:
    found = diagnose(changed(make_session(bench(3)), measured_rad=lambda m: m[:, [1, 0, 2]]), quick=True)
    assert found.causes[0].effect == "wiring"
    assert found.causes[0].joints == (1, 2)


def test_swapped_command_and_reading_are_warned_about_and_not_explained() -> None:
    session = make_session(bench(1), ["servo_lag:time_constant_s=0.15"])
    runs = tuple(replace(r, command_rad=r.measured_rad, measured_rad=r.command_rad) for r in session.runs)
    found = diagnose(
        replace(session, runs=runs), quick=True, only=["servo_lag", "rate_limit", "command_delay"]
    )
    assert any("swapped" in warning for warning in found.warnings)
    assert found.verdict == "unexplained" or all(cause.probability <= 0.5 for cause in found.causes)


def test_readings_that_are_the_commands_again_are_refused() -> None:
    session = make_session(bench())
    copied = replace(session, runs=tuple(replace(run, measured_rad=run.command_rad) for run in session.runs))
    with pytest.raises(BadInputError, match="same numbers in every sample: was one column written twice"):
        diagnose(copied)


def test_one_joint_whose_readings_are_its_commands_is_told() -> None:
    def copy_first(run: Run) -> Run:
        measured = run.measured_rad.copy()
        measured[:, 0] = run.command_rad[:, 0]
        return replace(run, measured_rad=measured)

    session = make_session(bench())
    warnings = check_session(replace(session, runs=tuple(copy_first(run) for run in session.runs)))
    assert any(line.startswith("joint 1: commands and readings are the same") for line in warnings)
    assert not any("same numbers" in line for line in check_session(session))


def test_options_that_name_nothing() -> None:
    session = make_session(bench(1))
    with pytest.raises(BadInputError, match="no effect is called 'rate_limt'"):
        diagnose(session, exclude=["rate_limt"])
    with pytest.raises(BadInputError, match="no effect has a parameter"):
        diagnose(session, known={"limit": 1.0})
    with pytest.raises(BadInputError, match=r"rate_limit has no parameter .*; did you mean limit_rad_s\?"):
        diagnose(session, known={"rate_limit.limt_rad_s": 1.0})
    with pytest.raises(BadInputError, match="leave no effect"):
        diagnose(session, only=["backlash"], exclude=["backlash"])


def test_lone_wild_readings_do_not_matter() -> None:
    def spoil(measured: np.ndarray) -> np.ndarray:
        out = measured.copy()
        out[50::97] += 1.0
        return out

    found = diagnose(changed(make_session(bench(1)), measured_rad=spoil), quick=True)
    assert found.verdict == "no_gap"
    assert any("lone readings" in warning for warning in found.warnings)


def thinned(session: Session, keep: Callable[[Run], np.ndarray]) -> Session:
    """Every run without the rows that its logger lost."""
    runs = []
    for run in session.runs:
        rows = keep(run)
        names = ("t_s", "command_rad", "measured_rad", *(() if run.pose is None else ("pose",)))
        parts = {name: getattr(run, name)[rows] for name in names}
        runs.append(replace(run, **parts))
    return replace(session, runs=tuple(runs))


def test_a_hole_in_a_log_is_no_gap() -> None:
    def keep(run: Run) -> np.ndarray:
        return (run.t_s < 2.0) | (run.t_s > 3.0) | (run.name != "run_01.csv")

    found = diagnose(thinned(make_session(bench()), keep), quick=True)
    assert found.verdict == "no_gap"
    assert found.causes == ()


def test_rows_lost_here_and_there_are_no_gap() -> None:
    rng = np.random.default_rng(3)
    lossy = thinned(make_session(bench(3)), lambda run: rng.random(len(run)) < 0.9)
    found = diagnose(lossy, quick=True)
    assert found.verdict == "no_gap"
    assert found.causes == ()


def test_a_body_is_no_other_for_a_hole_in_its_log() -> None:
    session = make_session(snake(), pose=True, duration_s=9.0)

    def hole(run: Run) -> np.ndarray:
        return (run.t_s < 3.0) | (run.t_s > 4.0)

    assert diagnose(thinned(session, hole), quick=True).verdict == "no_gap"
    rng = np.random.default_rng(5)
    assert diagnose(thinned(session, lambda run: rng.random(len(run)) < 0.9), quick=True).verdict == "no_gap"


def test_times_stamped_unevenly_are_no_lost_set_points() -> None:
    rng = np.random.default_rng(3)

    def stamped(t_s: np.ndarray) -> np.ndarray:
        shaken = np.maximum.accumulate(t_s + rng.normal(0, 0.002, t_s.size))
        return np.asarray(shaken + 1e-9 * np.arange(t_s.size))

    found = diagnose(changed(make_session(bench(3)), t_s=stamped), quick=True)
    assert all(cause.effect != "command_loss" for cause in found.causes)
