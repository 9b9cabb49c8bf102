"""What differs from run to run, and the times at which most of the rest lies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, make_run

from snakebot.diagnosis import Diagnosis, diagnose
from snakebot.diagnosis.verdict.run_by_run import _Own
from snakebot.effects.registry import effects
from snakebot.runlog import Run, Session

ROBOT = bench(2)
GAITS = ((50, 80, 2.0), (40, 80, 3.0), (45, 80, 2.5), (60, 80, 2.0))


def runs_under(specifications: Sequence[str]) -> list[Run]:
    """A run of each gait, each under an effect of its own."""
    return [
        make_run(ROBOT, [effect], gait, f"run_{i + 1:02d}", seed=i, duration_s=8.0)
        for i, (gait, effect) in enumerate(zip(GAITS, specifications, strict=True))
    ]


def limits(*limits_rad_s: float) -> Diagnosis:
    runs = runs_under([f"rate_limit:limit_rad_s={limit},joints=1" for limit in limits_rad_s])
    return diagnose(Session(ROBOT, tuple(runs)), quick=True, only=["rate_limit"])


def test_a_limit_that_fell_between_the_runs_is_told_run_by_run() -> None:
    found = limits(1.2, 1.2, 0.9, 0.9)
    values = found.where.values
    assert values is not None
    assert (values.effect, values.parameter, values.joints) == ("rate_limit", "limit_rad_s", (1,))
    assert [row.run for row in values.values] == ["run_01", "run_02", "run_03", "run_04"]
    assert [row.estimate for row in values.values] == pytest.approx([1.2, 1.2, 0.9, 0.9], abs=0.05)
    assert found.where.runs == values.unlike
    assert found.where.runs in (("run_01", "run_02"), ("run_03", "run_04"))
    assert values.of_rest > 0.8
    (told,) = [w for w in found.warnings if "differs from run to run" in w]
    assert told.startswith("joint 1, a limit of speed: fastest turn differs from run to run, from 0.9")


def test_the_one_run_that_is_unlike_the_others_is_named() -> None:
    assert limits(1.2, 1.2, 0.8, 1.2).where.runs == ("run_03",)


def test_one_limit_in_all_runs_is_told_once() -> None:
    found = limits(1.0, 1.0, 1.0, 1.0)
    assert found.verdict == "explained"
    assert found.where.values is None
    assert found.where.runs == ()
    assert not any("run to run" in w for w in found.warnings)


@pytest.mark.parametrize("first_seed", [0, 100, 200])
def test_a_run_in_which_the_effect_is_absent_is_unlike_the_others(first_seed: int) -> None:
    """Play that is gone ends where play may end: at nothing."""
    runs = [
        make_run(
            ROBOT,
            [] if i == 2 else ["backlash:width_deg=6,joints=1"],
            gait,
            f"run_{i + 1:02d}",
            seed=first_seed + i,
            duration_s=8.0,
        )
        for i, gait in enumerate(GAITS)
    ]
    found = diagnose(Session(ROBOT, tuple(runs)), quick=True, only=["backlash"])
    assert found.where.runs == ("run_03",)


def own(value: Sequence[float] | np.ndarray) -> _Own:
    parameter = effects()["rate_limit"].parameter("limit_rad_s")
    return _Own(parameter, tuple(range(len(value))), np.array(value), np.full(len(value), 0.1))


@pytest.mark.parametrize("count", [2, 20])
def test_the_ends_of_many_equal_values_are_apart_by_chance(count: int) -> None:
    rng = np.random.default_rng(3)
    assert np.mean([own(rng.normal(2.0, 0.1, count)).differ for _ in range(1000)]) <= 0.01


def test_values_that_are_apart_beyond_chance_differ() -> None:
    assert own([1.0, 2.0]).differ
    assert not own([1.0, 1.2]).differ  # no more than a real servo differs from the formula
    assert not own([1.0]).differ


def held(run: Run, begin_s: float, end_s: float) -> Run:
    """Somebody holds joint 2 for a while, a tenth of a radian off."""
    measured = run.measured_rad.copy()
    measured[(run.t_s >= begin_s) & (run.t_s < end_s), 1] += 0.1
    return replace(run, measured_rad=measured)


@pytest.mark.parametrize("effect", ["", "servo_offset:offset_deg=4,joints=2"])
def test_a_time_in_which_somebody_held_the_robot_is_told(effect: str) -> None:
    runs = [
        make_run(ROBOT, [effect] if effect else [], gait, f"run_{i + 1:02d}", seed=i, duration_s=8.0)
        for i, gait in enumerate(GAITS)
    ]
    runs[2] = held(runs[2], 3.0, 5.0)
    found = diagnose(Session(ROBOT, tuple(runs)), quick=True)
    (stretch,) = found.where.times
    assert (stretch.run, stretch.joint) == ("run_03", 2)
    assert (stretch.begin_s, stretch.end_s) == pytest.approx((3.0, 5.0), abs=0.05)
    assert stretch.share > 0.9
    (told,) = [w for w in found.warnings if "of what is left over is from" in w]
    assert told.startswith("joint 2: ")
    assert "from 3.0 to 5.0 s in run_03" in told


def test_of_one_joint_the_end_of_a_run_and_the_beginning_of_the_next_are_two_times() -> None:
    robot = bench(1)
    runs = [
        make_run(robot, [], gait, f"run_{i + 1:02d}", seed=i, duration_s=8.0) for i, gait in enumerate(GAITS)
    ]
    for i, begin_s in ((1, 7.0), (2, 0.0)):
        off = (
            runs[i].measured_rad
            + 0.1 * ((runs[i].t_s >= begin_s) & (runs[i].t_s < begin_s + 1))[:, np.newaxis]
        )
        runs[i] = replace(runs[i], measured_rad=off)
    found = diagnose(Session(robot, tuple(runs)), quick=True)
    assert {time.run for time in found.where.times} == {"run_02", "run_03"}


def test_what_is_wrong_all_the_time_has_no_time_of_its_own() -> None:
    runs = runs_under(["servo_offset:offset_deg=4,joints=2"] * 4)
    found = diagnose(Session(ROBOT, tuple(runs)), quick=True, exclude=["servo_offset", "encoder_offset"])
    assert found.verdict != "no_gap"
    assert found.where.times == ()


def test_a_run_that_is_wrong_from_end_to_end_is_no_time() -> None:
    runs = runs_under(["servo_offset:offset_deg=0,joints=2"] * 4)
    runs[1] = held(runs[1], 0.0, 9.0)
    found = diagnose(Session(ROBOT, tuple(runs)), quick=True, only=["rate_limit"])
    assert np.any(np.array(found.where.joints) == 2)
    assert found.where.times == ()
