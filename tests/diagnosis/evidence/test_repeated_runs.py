"""What repeats differ by: how they are aligned, and what of it is noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, make_run

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.evidence.data import prepare
from snakebot.diagnosis.evidence.floor import Floor
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import gather
from snakebot.diagnosis.evidence.sanity import check_session
from snakebot.diagnosis.fit.trial import nominal_trial
from snakebot.effects import EffectSpec, Plant, predict
from snakebot.runlog import Run, Session
from snakebot.runlog.matching.motion import CommandedMotion, Match, same_motion

ROBOT = bench()
GAITS = ((40, 80, 2.0), (30, 80, 3.0), (20, 80, 1.0))


def align(t_s: np.ndarray, told: np.ndarray, other_t_s: np.ndarray, other: np.ndarray) -> Match | None:
    return same_motion(CommandedMotion(t_s, told), CommandedMotion(other_t_s, other), claimed=True)


def runs_of(*effects: Sequence[str]) -> list[Run]:
    """A run each gait and the first one again, each under effects of its own."""
    gaits = (*GAITS, GAITS[0])
    made = [
        make_run(ROBOT, specs, gait, f"run_{i + 1:02d}", seed=i, duration_s=8.0)
        for i, (gait, specs) in enumerate(zip(gaits, effects, strict=True))
    ]
    return [*made[:-1], replace(made[-1], repeat_of="run_01")]


def cut(run: Run, first: int) -> Run:
    return replace(
        run, t_s=run.t_s[first:], command_rad=run.command_rad[first:], measured_rad=run.measured_rad[first:]
    )


def floor_of(runs: Sequence[Run]) -> Floor:
    return gather(prepare(Session(ROBOT, tuple(runs)))).floor


def gap_joints(runs: Sequence[Run]) -> list[int]:
    evidence = gather(prepare(Session(ROBOT, tuple(runs))))
    gap = gap_of(evidence.scoring, nominal_trial(evidence).held_square)
    return [int(j) + 1 for j in np.flatnonzero(gap.significant)]


@pytest.mark.parametrize("late", [0.4, 0.1, 0.003, 2.0])
def test_a_log_that_begins_later_is_found_in_the_other(late: float) -> None:
    t = np.arange(0, 10, 0.01)

    def wave(t_s: np.ndarray) -> np.ndarray:
        return np.column_stack([np.sin(2 * t_s) * (1 - np.exp(-t_s)), np.cos(2 * t_s) * (1 - np.exp(-t_s))])

    found = align(t, wave(t), t, wave(t + late))
    assert found is not None
    assert found.shift_s == pytest.approx(-late, abs=2e-4)


def test_equal_commands_are_not_shifted_and_other_ones_do_not_align() -> None:
    a, other = (make_run(ROBOT, (), gait, "a", duration_s=8.0) for gait in GAITS[:2])
    found = align(a.t_s, a.command_rad, a.t_s, a.command_rad)
    assert found is not None
    assert found.shift_s == 0.0
    assert found.same.all()
    assert align(a.t_s, a.command_rad, other.t_s, other.command_rad) is None
    assert align(a.t_s, a.command_rad, a.t_s, 0.8 * a.command_rad) is None


def test_steps_of_another_height_are_another_motion() -> None:
    t = np.arange(0, 4, 0.02)
    low, high = (np.where(t > 2.5, height, 0.0)[:, None] for height in (0.3, 0.5))
    assert align(t, low, t, high) is None
    assert align(t, low, t, np.roll(low, 1, axis=0)) is not None


def test_a_gap_is_no_noise_because_the_repeats_log_began_later() -> None:
    slow = ["rate_limit:limit_rad_s=0.5"]
    runs = runs_of(slow, slow, slow, slow)
    runs[-1] = cut(runs[-1], 40)
    floor = floor_of(runs)
    assert np.degrees(floor.rad) == pytest.approx([0.05, 0.05], abs=0.02)
    assert floor.pairs == 1
    assert not floor.warnings
    assert gap_joints(runs) == [1, 2]


def test_a_repeat_of_another_gait_is_none_and_a_warning_names_both() -> None:
    runs = runs_of((), (), (), ())
    runs[1] = replace(runs[1], repeat_of="run_01")
    data = prepare(Session(ROBOT, tuple(runs)))
    assert [run.motion for run in data.runs] == [0, 1, 2, 0]
    assert floor_of(runs).pairs == 1
    (warning,) = check_session(Session(ROBOT, tuple(runs)))
    assert warning.startswith("run_02 is marked as a repeat of run_01, but its commands are others")


@pytest.mark.parametrize(
    "effect",
    [
        "servo_offset:offset_deg=8,joints=2",
        "rate_limit:limit_rad_s=0.5,joints=2",
        "joint_rigid:angle_deg=5,joints=2",
    ],
)
def test_a_joint_that_changed_before_the_repeat_is_not_noisy(effect: str) -> None:
    runs = runs_of((), (), (), [effect])
    floor = floor_of(runs)
    assert np.degrees(floor.rad) == pytest.approx([0.05, 0.05], abs=0.02)
    (warning,) = floor.warnings
    assert "joint 2 moves otherwise in run_04 than in the same motion in run_01" in warning
    assert gap_joints(runs) == [2]


def there_and_back(effects: Sequence[str], name: str, seed: int) -> Run:
    """One slow stroke forth and one back: too few to show that a difference depends on the motion."""
    t_s = np.arange(0, 8, 0.01)
    command = np.outer(np.radians(40) * np.sin(np.pi * t_s / 8) ** 2, np.ones(2))
    reading = predict(ROBOT, effects, t_s, command, quantise=False).encoder_rad
    noise = np.radians(0.05) * np.random.default_rng(seed).normal(size=command.shape)
    return Run(name, t_s, command, reading + noise)


def test_where_a_joint_changed_its_other_motions_are_no_noise_either() -> None:
    gain = ["command_gain:gain=0.6,joints=2"]
    quick = (40, 80, 3.0)
    runs = [
        there_and_back((), "slow", 0),
        make_run(ROBOT, (), quick, "quick", seed=1, duration_s=8.0),
        replace(there_and_back(gain, "slow_again", 2), repeat_of="slow"),
        replace(make_run(ROBOT, gain, quick, "quick_again", seed=3, duration_s=8.0), repeat_of="quick"),
    ]
    alone = floor_of([runs[0], runs[2], runs[1]])
    assert not alone.warnings
    assert np.degrees(alone.rad[1]) > 1.0  # nothing tells that it is no noise
    floor = floor_of(runs)
    assert np.degrees(floor.rad) == pytest.approx([0.05, 0.05], abs=0.02)
    assert [w.partition(" otherwise")[0] for w in floor.warnings] == ["joint 2 moves"] * 2


def test_a_gain_that_changed_is_a_smaller_angle_in_a_smaller_motion() -> None:
    gain = ["command_gain:gain=0.6,joints=2"]
    wide, small = (40, 80, 3.0), (8, 80, 0.7)
    runs = [
        make_run(ROBOT, effects, gait, f"{name}{again}", seed=seed, duration_s=8.0)
        for seed, (name, gait, again, effects) in enumerate(
            (n, g, a, e)
            for n, g in (("wide", wide), ("small", small))
            for a, e in (("", ()), ("_again", gain))
        )
    ]
    marked = [replace(r, repeat_of=r.name.removesuffix("_again")) if "again" in r.name else r for r in runs]
    assert np.degrees(floor_of(marked).rad) == pytest.approx([0.05, 0.05], abs=0.02)


def test_a_robot_that_is_a_little_another_one_in_every_repeat_is_told() -> None:
    """Three motions, each made with two loads: nothing tells what is usual, so all of it is in the floor."""
    runs = []
    for again, effects in enumerate(((), ["command_gain:gain=0.95,joints=2"])):
        for i, gait in enumerate(GAITS):
            lag = ["servo_lag:time_constant_s=0.15", *effects]
            run = make_run(ROBOT, lag, gait, f"run_{i}{'ab'[again]}", seed=10 * again + i, duration_s=8.0)
            runs.append(replace(run, repeat_of=f"run_{i}a") if again else run)
    floor = floor_of(runs)
    assert np.degrees(floor.rad[1]) > 0.3
    (warning,) = floor.warnings
    assert warning.startswith("joint 2 moves otherwise in run_")
    assert "as a function of the motion" in warning
    assert floor.known


def test_a_joint_that_was_stuck_all_along_but_in_the_first_run_has_a_gap() -> None:
    stuck = ["joint_rigid:angle_deg=5,joints=2"]
    assert gap_joints(runs_of((), stuck, stuck, stuck)) == [2]


def test_what_broke_in_mid_run_hides_nothing() -> None:
    runs = runs_of((), (), (), ())
    broken = runs[-1].measured_rad.copy()
    broken[450:, 1] = broken[450, 1]
    runs[-1] = replace(runs[-1], measured_rad=broken)
    found = diagnose(Session(ROBOT, tuple(runs)), quick=True)
    assert found.verdict == "unexplained"
    assert found.where.joints == (2,)
    still, repeats = found.warnings[:2]
    assert still.startswith("run_04: from 4.5 to 8.0 s joint 2 is told to move by")
    assert repeats.startswith("joint 2: run_01 and run_04, the same motion, part from 4.0 to 8.0 s")
    assert found.closure.joint_angle.closed == 0.0
    (time,) = found.where.times
    assert (time.run, time.joint) == ("run_04", 2)


def test_a_disturbance_in_a_repeat_is_no_noise() -> None:
    """Somebody held joint 2 for two seconds: that made a floor of 1.7 deg, and "no gap" of all that it hid."""
    runs = runs_of((), (), (), ())
    held = runs[-1].measured_rad.copy()
    held[(runs[-1].t_s >= 3.0) & (runs[-1].t_s < 5.0), 1] += 0.1
    runs[-1] = replace(runs[-1], measured_rad=held)
    floor = floor_of(runs)
    assert np.degrees(floor.rad) == pytest.approx([0.05, 0.05], abs=0.02)
    (warning,) = floor.warnings
    assert warning.startswith(
        "joint 2: run_01 and run_04, the same motion, part from 3.0 to 5.0 s of run_01, by 5.7 deg"
    )
    assert gap_joints(runs) == [2]


def test_somebody_who_held_all_joints_is_told_once() -> None:
    runs = runs_of((), (), (), ())
    held = runs[-1].measured_rad + 0.1 * ((runs[-1].t_s >= 3.0) & (runs[-1].t_s < 5.0))[:, np.newaxis]
    runs[-1] = replace(runs[-1], measured_rad=held)
    (warning,) = floor_of(runs).warnings
    assert warning.startswith("joints 1, 2: run_01 and run_04")
    assert not floor_of(runs).like


def test_a_count_that_flickers_is_no_disturbance() -> None:
    """Readings without noise: the median difference is nothing, and one count is many times that."""
    runs = runs_of((), (), (), ())
    for i, run in enumerate(runs):
        runs[i] = replace(
            run, measured_rad=np.round(run.command_rad / ROBOT.rad_per_count) * ROBOT.rad_per_count
        )
    flicker = runs[-1].measured_rad.copy()
    flicker[500:505, 1] += ROBOT.rad_per_count
    runs[-1] = replace(runs[-1], measured_rad=flicker)
    assert floor_of(runs).warnings == ()


def test_of_three_repeats_the_two_that_agree_tell_the_noise() -> None:
    runs = runs_of((), (), (), ["servo_offset:offset_deg=4,joints=1"])
    runs.append(replace(make_run(ROBOT, (), GAITS[0], "run_05", seed=9, duration_s=8.0), repeat_of="run_01"))
    floor = floor_of(runs)
    assert np.degrees(floor.repeat_rad) == pytest.approx([0.05, 0.05], abs=0.02)
    assert floor.like == {(0, 4)}
    assert len(floor.warnings) == 2


def test_a_joint_that_sticks_elsewhere_at_each_turn_is_noisy_and_has_not_changed() -> None:
    runs = []
    for i, run in enumerate(runs_of((), (), (), ())):
        rng = np.random.default_rng(i)
        turns = np.cumsum(
            np.diff(np.sign(np.gradient(run.command_rad, axis=0)), axis=0, prepend=0.0) != 0, axis=0
        )
        stuck = np.radians(0.8) * rng.normal(size=(turns.max() + 1, 2))
        runs.append(replace(run, measured_rad=run.measured_rad + np.take_along_axis(stuck, turns, axis=0)))
    floor = floor_of(runs)
    assert not floor.warnings
    assert not floor.doubts
    assert (np.degrees(floor.rad) > 0.4).all()
    assert gap_joints(runs) == []


def test_chance_is_noise() -> None:
    """Set-points lost at random: repeats differ by many times the readings' noise, and by no plan."""
    runs = []
    for i, gait in enumerate((*GAITS, GAITS[0])):
        whole = make_run(ROBOT, (), gait, f"run_{i + 1:02d}", seed=i, duration_s=8.0)
        plant = Plant(ROBOT, [EffectSpec("command_loss", {"probability": 0.6})], seed=i)
        read = np.empty_like(whole.measured_rad)
        for n, now in enumerate(whole.t_s):
            plant.advance(float(now))
            read[n] = plant.encoder_rad()
            plant.command(float(now), whole.command_rad[n])
        noise = np.radians(0.05) * np.random.default_rng(i).normal(size=read.shape)
        runs.append(replace(whole, measured_rad=read + noise))
    floor = floor_of([*runs[:-1], replace(runs[-1], repeat_of="run_01")])
    assert not floor.warnings
    assert (floor.repeat_rad > 4 * floor.white_rad).all()


def test_a_servo_that_reads_a_sample_late_is_no_other_robot() -> None:
    runs = runs_of((), (), (), ())
    late = runs[-1].measured_rad.copy()
    late[1:] = late[:-1]
    floor = floor_of([*runs[:-1], replace(runs[-1], measured_rad=late)])
    assert not floor.warnings


def test_where_a_joint_sticks_in_one_stroke_says_nothing_of_the_next() -> None:
    """A slow run turns twice: three strokes, each off by an amount of its own, foretell nothing."""
    slow = (40, 80, 0.8)
    runs = [
        make_run(ROBOT, (), gait, f"run_{i + 1:02d}", seed=i, duration_s=8.0)
        for i, gait in enumerate((slow, *GAITS[1:], slow))
    ]
    turns = np.cumsum(
        np.diff(np.sign(np.gradient(runs[-1].command_rad, axis=0)), axis=0, prepend=0.0) != 0, axis=0
    )
    stuck = np.radians([[0.0], [0.9], [-1.0], [0.8], [0.9]])
    off = np.take_along_axis(np.repeat(stuck, 2, axis=1), turns, axis=0)
    runs[-1] = replace(runs[-1], measured_rad=runs[-1].measured_rad + off, repeat_of="run_01")
    assert not floor_of(runs).warnings


def test_a_floor_above_what_is_left_is_doubted() -> None:
    """The repeated motion is noisy, the others are not: the floor of all is that of the one."""
    runs = runs_of((), (), (), ())
    for i, noisy in ((0, True), (1, False), (2, False), (3, True)):
        extra = np.radians(0.5) * np.random.default_rng(20 + i).normal(size=runs[i].measured_rad.shape)
        runs[i] = replace(runs[i], measured_rad=runs[i].measured_rad + noisy * extra)
    found = diagnose(Session(ROBOT, tuple(runs)), quick=True)
    angle = found.closure.joint_angle
    assert angle.rms_floor is not None
    assert angle.rms_after < 0.95 * angle.rms_floor
    assert any("less than the noise floor" in warning for warning in found.warnings)
    usual = diagnose(Session(ROBOT, tuple(runs_of((), (), (), ()))), quick=True)
    assert not any("less than the noise floor" in warning for warning in usual.warnings)
