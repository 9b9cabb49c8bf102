"""Courses held by ``snakebot run --line``, on the simulated robot and on blind ones that share no code with it.

The poses are those that the board tells; a blind robot's have the noise of a camera (1 mm, 0.1 deg).
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from blind import chain as ch
from blind.robot import Parameters, real_robot
from blind.wire_plant import BlindPlant
from snakebot.arrays import Floats
from snakebot.board import Board
from snakebot.clock import VirtualClock
from snakebot.control import RunSettings, open_board, plan_run, record
from snakebot.gait import Gait
from snakebot.robot import load_robot
from snakebot.runlog import RunLog, read_log
from snakebot.softboard import InProcessLink, SoftBoard
from snakebot.steering import Course, parse_line

ROBOT = load_robot("penn_state")
GAIT = Gait.from_degrees(37, 80, 2)
BODY_M = 0.96
RUN_S, RAMP_S, RATE_HZ = 34.0, 2.0, 100.0
SETTLED = 2.0  # body lengths along the line, after which it counts
AIM = 0.1  # of a body length: the most that it may then be off

Pose = tuple[float, float, float]  # m, m, rad


@dataclass(frozen=True)
class Trouble:
    """What stands against the course: how the robot lies at first, and what is wrong with it or the ground."""

    words: str
    line: str
    start: Pose
    effects: tuple[str, ...]  # of the simulated board, which the steering is not told
    change: Callable[[Parameters], None]  # of a blind robot, the same


def _nothing(robot: Parameters) -> None:
    pass


def _slope(robot: Parameters) -> None:
    robot.ground[0] = math.radians(2)


def _weak(robot: Parameters) -> None:
    robot.joint("torque_limit_nm")[2] = 0.6


def _bent(robot: Parameters) -> None:
    robot.joint("offset_rad")[1] = math.radians(5)


def _all(robot: Parameters) -> None:
    for change in (_slope, _weak, _bent):
        change(robot)


_ASLANT = math.radians(20)
_SLOPE, _WEAK, _BENT = (
    "slope:angle_deg=2", "torque_limit:limit_nm=0.6,joints=3", "servo_offset:offset_deg=5,joints=2",
)  # fmt: skip
_ACROSS = (0.0, 0.0, math.pi / 2 + _ASLANT)
TROUBLES = (
    Trouble("turned by 20 deg", "y=0", (0.0, 0.0, _ASLANT), (), _nothing),
    Trouble("the same, 0.3 m aside", "y=0", (0.0, 0.3, _ASLANT), (), _nothing),
    Trouble("across a slope of 2 deg", "x=0", _ACROSS, (_SLOPE,), _slope),
    Trouble("joint 3 has 0.6 N m", "y=0", (0.0, 0.0, _ASLANT), (_WEAK,), _weak),
    Trouble("joint 2 is bent by 5 deg", "y=0", (0.0, 0.0, _ASLANT), (_BENT,), _bent),
    Trouble("slope, weak and bent joint", "x=0", _ACROSS, (_SLOPE, _WEAK, _BENT), _all),
)


@dataclass(frozen=True)
class Held:
    """How it went: ways in body lengths.

    Attributes:
        off: largest distance from the line, of means over a cycle, from ``SETTLED`` on until the last ramp.
        along: how far it came.
        saturated: cycles whose offset a limit cut short; ``told``: events that say so.
        within_limits: whether every set-point kept angle, speed and acceleration.
    """

    off: float
    along: float
    saturated: int
    told: int
    within_limits: bool


def held(trouble: Trouble, seed: int | None, *, steered: bool = True, duration_s: float = RUN_S) -> Held:
    """One run: on the blind robot of a seed (those from 5 on are sealed), or, without one, on the simulated robot."""
    course = parse_line(trouble.line)
    plan = plan_run(GAIT, ROBOT.joints, duration_s=duration_s, ramp_s=RAMP_S)
    with tempfile.TemporaryDirectory(prefix="course_") as folder:
        settings = RunSettings(log_path=Path(folder) / "run.mcap", course=course if steered else None)
        if seed is None:
            with open_board(
                "sim:", ROBOT, effects=trouble.effects, virtual=True, start_pose=trouble.start
            ) as board:
                recorded = record(board, ROBOT, plan, settings)
        else:
            recorded = record(_blind_board(trouble, seed), ROBOT, plan, settings)
        log = read_log(recorded.log_path)
    steering = recorded.progress.steering
    along, aside = _way(log, course)
    beyond = along > SETTLED * BODY_M
    return Held(
        off=float(np.abs(aside[beyond]).max() / BODY_M) if beyond.any() else math.inf,
        along=float(along.max() / BODY_M),
        saturated=0 if steering is None else steering.saturated,
        told=sum(event.kind == "steering_limit" for event in log.events),
        within_limits=recorded.progress.clamped == 0 and _keeps_limits(log),
    )


def _blind_board(trouble: Trouble, seed: int) -> Board:
    parameters = real_robot(np.random.default_rng(seed))
    trouble.change(parameters)
    plant, clock = BlindPlant(parameters, seed), VirtualClock()
    place, where = np.zeros(3), plant._going.data.qpos
    where[2] = trouble.start[2]
    ch._pose(where, parameters.links, place)
    where[:2] += np.array(trouble.start[:2]) - place[:2]
    board = Board(InProcessLink(SoftBoard(ROBOT, plant=plant), clock), clock)
    board.connect()
    return board


def _way(log: RunLog, course: Course) -> tuple[Floats, Floats]:
    """Way along the line and distance from it in m, means over a cycle, until the last ramp begins."""
    count = round(GAIT.period_s * RATE_HZ)
    x, y = (np.convolve(column, np.full(count, 1 / count), "valid") for column in log.pose[:, :2].T)
    here = log.pose_t_s[count - 1 :] < log.t_s[-1] - RAMP_S
    points = list(zip(x[here].tolist(), y[here].tolist(), strict=True))
    first = course.along_m(*log.pose[0, :2])
    along = np.array([abs(course.along_m(*point) - first) for point in points])
    return along, np.array([course.cross_track_m(*point) for point in points], dtype=float)


def _keeps_limits(log: RunLog) -> bool:
    """Of what was sent, by finite differences; a step of the wire is 1e-4 rad."""
    sent, interval = log.sent_rad, 1 / RATE_HZ
    return bool(
        np.abs(sent).max() <= ROBOT.angle_limit_rad[0] + 1e-4
        and np.abs(np.diff(sent, axis=0)).max() <= ROBOT.speed_limit_rad_s[0] * interval + 2e-4
        and np.abs(np.diff(sent, n=2, axis=0)).max()
        <= ROBOT.acceleration_limit_rad_s2[0] * interval**2 + 4e-4
    )
