"""The robot on wheels does what metal does: it falls behind, rolls, is stopped by friction, and its faults show."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from blind.robot import Build, Parameters, Robot, gait_command
from blind_wheels.body import Floats
from blind_wheels.described import foretold
from blind_wheels.faults import FAULTS
from blind_wheels.lab import Description, measured
from blind_wheels.robot import Wheeled, healthy_robot


@cache
def small() -> tuple[Wheeled, Description]:
    """One of four links."""
    for seed in range(100):
        rng = np.random.default_rng(seed)
        robot = healthy_robot(rng)
        if robot.body.links == 4:
            return robot, measured(robot, rng)
    raise AssertionError("no robot of four links")


def gait(robot: Wheeled, seconds: float = 2.0) -> tuple[Floats, Floats]:
    t = np.arange(round(seconds * robot.rate_hz)) / robot.rate_hz
    return t, gait_command(t, np.radians(40.0), np.radians(80.0), 2.5, 0.5, robot.joint_count)


def ran(robot: Wheeled) -> tuple[Floats, Floats]:
    t, command = gait(robot)
    run = robot.noiseless().run(t, command, np.random.default_rng(0))
    return run.encoder_rad, run.pose


def rms(table: Floats) -> float:
    return float(np.sqrt(np.mean(table**2)))


@pytest.mark.slow
def test_a_healthy_robot_does_about_what_the_lab_says_of_it() -> None:
    robot, about = small()
    t, command = gait(robot)
    angle, pose = ran(robot)
    said, path = foretold(about, t, command)
    assert rms(angle - said) < 0.2 * rms(command - said)  # most of being late is foretold
    assert np.degrees(rms(angle - said)) > 0.02  # and no lag tells all
    assert pose[-1, 0] == pytest.approx(path[-1, 0], rel=0.25)
    assert pose[-1, 0] > 0.1


@pytest.mark.slow
def test_the_lab_measures_what_was_built_in() -> None:
    robot, about = small()
    grip = float(robot.body.grip.mean()) * about.mass_kg * 9.80665
    assert about.cn0 + 0.25 * about.cn == pytest.approx(grip, rel=0.25)
    drag = 2 * float(robot.bearings[0].mean()) / 0.025
    assert about.ct0 == pytest.approx(drag, rel=0.35)
    assert 0.015 < about.lag_s < 0.08
    t, command = gait(robot)
    angle, _ = ran(robot)
    errors = [
        rms(angle - foretold(replace(about, lag_s=share * about.lag_s), t, command)[0])
        for share in (0.7, 1.0, 1.3)
    ]
    assert errors[1] == min(errors)  # the held command's half tick is not counted twice


@pytest.mark.slow
def test_what_the_description_foretells_is_what_the_first_blind_robot_does() -> None:
    """Two simulations of one family, written apart from each other."""
    robot, about = small()
    t, command = gait(robot)
    p = Parameters.of(Build(robot.joint_count, about.lag_s, robot.rate_hz))
    for row, value in (
        ("mass_kg", about.mass_kg), ("half_length_m", about.half_length_m), ("ct", about.ct), ("cn", about.cn),
        ("ct0", about.ct0), ("cn0", about.cn0),
    ):  # fmt: skip
        p.link(row)[:] = value
    p.joint("gear_nm_s_rad")[:] = 0.1
    other = Robot(p.noiseless()).run(t, command, np.random.default_rng(0))
    angle, pose = foretold(about, t, command)
    assert np.degrees(rms(other.encoder_rad - angle)) < 0.1
    assert other.pose[-1, 0] == pytest.approx(pose[-1, 0], rel=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_shows_where_it_is(name: str) -> None:
    robot, _ = small()
    fault, at = FAULTS[name], 1
    faulty = robot.copy()
    fault.apply(faulty, at, fault.high if name != "uneven_floor" else 0.003, np.random.default_rng(3))
    assert faulty.body is not robot.body
    (sound, sound_pose), (angle, pose) = ran(robot), ran(faulty)
    if "body" in fault.stages:
        assert rms((pose - sound_pose)[:, :2]) > 2e-3
        return
    by_joint = np.sqrt(np.mean((angle - sound) ** 2, axis=0))
    assert np.degrees(by_joint[at]) > 0.2
    if fault.at == "joint":
        assert by_joint.argmax() == at


@pytest.mark.slow
def test_duty_below_the_dead_zone_moves_nothing() -> None:
    robot = small()[0].copy()
    robot.joint("dead_zone")[:] = 2000  # more than there is
    assert np.degrees(np.abs(ran(robot)[0]).max()) < 0.5


@pytest.mark.slow
def test_a_simulation_that_runs_away_is_told_and_not_started_anew() -> None:
    robot = small()[0].copy()
    robot.joint("kt_nm_a")[:] *= 300
    with pytest.raises(FloatingPointError, match="blew up"):
        ran(robot)


def test_a_magnet_beside_its_axis_reads_right_at_rest_alone() -> None:
    robot = healthy_robot(np.random.default_rng(0))
    robot.magnet[:, 0] = 0.1, 1.0
    seen = robot._field(np.full((2, robot.joint_count), 0.5) * [[0.0], [1.0]])
    assert seen[0, 0] == 0.0
    assert abs(seen[1, 0] - 0.5) > 0.01
    assert np.allclose(seen[:, 1:], [[0.0], [0.5]])
