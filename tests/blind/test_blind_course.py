"""The course is held on a robot that shares no code with the model that the steering believes."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from blind.gait_course import AIM, BODY_M, GAIT, ROBOT, SETTLED, TROUBLES, Trouble, held
from blind.robot import Parameters, real_robot
from blind.wire_plant import BlindPlant

from snakebot.board import Board
from snakebot.clock import VirtualClock
from snakebot.control import RunSettings, plan_run, record
from snakebot.runlog import read_log
from snakebot.softboard import InProcessLink, SoftBoard
from snakebot.steering import parse_line

SEED = 3  # of the robot's own numbers; those from 5 on are sealed


def plain(robot: Parameters) -> None:
    pass


def uphill(robot: Parameters) -> None:
    robot.ground[0] = math.radians(2)  # along x: the line runs aslant across it


def weak(robot: Parameters) -> None:
    robot.joint("torque_limit_nm")[2] = 0.6
    robot.joint("offset_rad")[1] = math.radians(4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "towards_deg", "duration_s"), [(plain, -20, 26), (uphill, 20, 36), (weak, -20, 26)]
)
def test_after_two_body_lengths_it_is_within_a_tenth_of_one(
    tmp_path: Path, change: Callable[[Parameters], None], towards_deg: float, duration_s: float
) -> None:
    parameters = real_robot(np.random.default_rng(SEED))
    change(parameters)
    line = parse_line(f"0,0@{towards_deg}")  # it lies along x: turned by 20 degrees
    clock = VirtualClock()
    board = Board(InProcessLink(SoftBoard(ROBOT, plant=BlindPlant(parameters, SEED)), clock), clock)
    board.connect()
    settings = RunSettings(log_path=tmp_path / "run.mcap", course=line)
    recorded = record(board, ROBOT, plan_run(GAIT, 5, duration_s=duration_s), settings)
    log = read_log(recorded.log_path)
    count = round(GAIT.period_s * 100)
    x, y = (np.convolve(column, np.full(count, 1 / count), "valid") for column in log.pose[:, :2].T)
    points = list(zip(x.tolist(), y.tolist(), strict=True))
    along = np.array([line.along_m(*point) for point in points])
    aside = np.array([line.cross_track_m(*point) for point in points], dtype=float)
    beyond = (along > 2 * BODY_M) & (log.pose_t_s[count - 1 :] < log.t_s[-1] - 2)
    assert along.max() > 2.8 * BODY_M
    assert np.abs(aside[beyond]).max() < 0.1 * BODY_M
    assert np.abs(log.sent_rad).max() <= ROBOT.angle_limit_rad[0]
    assert recorded.progress.clamped == 0


@pytest.mark.slow
@pytest.mark.parametrize("trouble", TROUBLES[1:], ids=lambda trouble: trouble.words)
def test_whatever_the_trouble_and_no_limit_is_broken(trouble: Trouble) -> None:
    """The rows of the table in docs/steering.md, on one robot."""
    run = held(trouble, SEED)
    assert run.along > SETTLED + 0.5
    assert run.off < AIM
    assert run.within_limits
    assert bool(run.saturated) == bool(run.told)


@pytest.mark.slow
def test_without_steering_the_blind_robot_goes_astray() -> None:
    """The figures above are the steering's doing; and the blind robot lies as it is told to."""
    run = held(TROUBLES[0], SEED, steered=False)
    assert run.off > 0.5
