"""A run that holds a course: what it does with poses, what it tells, what it refuses, and that limits hold."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lag_plant import LagPlant

from snakebot.board import Board
from snakebot.clock import VirtualClock
from snakebot.control import Attendant, RecordedRun, RunLoop, RunSettings, open_board, plan_run, record
from snakebot.control.recording import check_run
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, check_motion, parse_probe
from snakebot.robot import load_robot
from snakebot.runlog import RunLog, read_log
from snakebot.softboard import InProcessLink, SoftBoard
from snakebot.steering import Course, parse_line
from snakebot.steering.pose_line import SaidPose

ROBOT = load_robot("penn_state")
GAIT = Gait.from_degrees(37, 80, 2)
BODY_M = 0.96
TURNED = (0.0, 0.0, math.radians(20))


def run(
    folder: Path,
    course: Course,
    *,
    effects: tuple[str, ...] = (),
    start: tuple[float, float, float] = TURNED,
    duration_s: float = 28.0,
    attendant: Attendant | None = None,
    gait: Gait = GAIT,
) -> tuple[RecordedRun, RunLog]:
    settings = RunSettings(log_path=folder / "run.mcap", course=course)
    with open_board("sim:", ROBOT, effects=effects, virtual=True, start_pose=start) as board:
        recorded = record(board, ROBOT, plan_run(gait, 5, duration_s=duration_s), settings, attendant)
    return recorded, read_log(recorded.log_path)


def off_the_line(log: RunLog, course: Course, period_s: float = GAIT.period_s) -> tuple[Any, Any]:
    """Way along the line and distance from it, means over a cycle, until the last ramp begins."""
    count = round(period_s * 100)
    x, y = (np.convolve(column, np.full(count, 1 / count), "valid") for column in log.pose[:, :2].T)
    here = log.pose_t_s[count - 1 :] < log.t_s[-1] - 2.0
    points = list(zip(x[here].tolist(), y[here].tolist(), strict=True))
    start = course.along_m(*log.pose[0, :2])
    along = np.array([abs(course.along_m(*point) - start) for point in points])
    aside = [course.cross_track_m(*point) for point in points]
    return along, np.array(aside, dtype=float)


def assert_within_limits(log: RunLog) -> None:
    """Of what was sent, by finite differences; a step of the wire is 1e-4 rad."""
    sent, interval = log.sent_rad, 0.01
    assert np.abs(sent).max() <= ROBOT.angle_limit_rad[0] + 1e-4
    speed = np.abs(np.diff(sent, axis=0)) / interval
    assert speed.max() <= ROBOT.speed_limit_rad_s[0] + 2e-4 / interval
    assert np.abs(np.diff(sent, n=2, axis=0)).max() <= ROBOT.acceleration_limit_rad_s2[0] * interval**2 + 4e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("course", "effects", "start"),
    [
        ("y=0", (), TURNED),
        ("x=0", ("slope:angle_deg=2",), (0.0, 0.0, math.radians(110))),
        ("y=0", ("torque_limit:limit_nm=0.6,joints=3",), TURNED),
        ("y=0", ("servo_offset:offset_deg=5,joints=2",), TURNED),
    ],
    ids=["turned", "across a slope", "weak joint", "bent joint"],
)
def test_after_two_body_lengths_it_is_within_a_tenth_of_one(
    tmp_path: Path, course: str, effects: tuple[str, ...], start: tuple[float, float, float]
) -> None:
    line = parse_line(course)
    recorded, log = run(tmp_path, line, effects=effects, start=start)
    along, aside = off_the_line(log, line)
    beyond = along > 2 * BODY_M
    assert along.max() > 3 * BODY_M
    assert np.abs(aside[beyond]).max() < 0.1 * BODY_M
    assert recorded.progress.clamped == 0
    assert_within_limits(log)


@pytest.mark.slow
def test_without_steering_the_same_robot_goes_astray(tmp_path: Path) -> None:
    """The figures above are the steering's doing."""
    line = parse_line("y=0")
    with open_board("sim:", ROBOT, virtual=True, start_pose=TURNED) as board:
        settings = RunSettings(log_path=tmp_path / "a.mcap")
        recorded = record(board, ROBOT, plan_run(GAIT, 5, duration_s=28), settings)
    along, aside = off_the_line(read_log(recorded.log_path), line)
    assert np.abs(aside[along > 2 * BODY_M]).min() > 0.5 * BODY_M


def test_the_log_holds_what_was_seen_wanted_and_done(tmp_path: Path) -> None:
    course = Course.of_heading(10)
    recorded, log = run(tmp_path, course, duration_s=14)
    assert log.metadata["course"] == {"heading_deg": 10.0}
    assert log.metadata["start_pose"] == list(TURNED)
    steering = recorded.progress.steering
    assert steering is not None
    assert steering.decisions == log.steering_t_s.size >= 3
    assert math.degrees(log.steering["heading_rad"][0]) == pytest.approx(20, abs=0.01)
    error = log.steering["heading_rad"] - log.steering["wanted_heading_rad"]
    np.testing.assert_allclose(error, log.steering["heading_error_rad"], atol=1e-9)
    assert np.isnan(log.steering["cross_track_m"]).all() if "cross_track_m" in log.steering else True
    told = [event for event in log.events if event.kind == "steering"]
    assert "heading 10 deg" in told[0].message
    assert told[0].data["turn_per_offset_1_s"] == pytest.approx(1.145, rel=0.02)
    table = recorded.read().extra
    assert np.nanmax(np.abs(table["steering_offset_rad"])) == pytest.approx(
        np.abs(log.steering["offset_rad"]).max()
    )
    at = np.searchsorted(
        log.t_s, log.steering_t_s[1] + 1.2
    )  # a change has blended in, and the next is not due
    wave = GaitMotion(GAIT, 5, 14, 2, log.setpoint_rad[0].tolist()).sampled(log.t_s[at : at + 1])
    np.testing.assert_allclose(log.setpoint_rad[at] - wave[0], log.steering["offset_rad"][1], atol=1e-3)


def test_a_narrow_room_is_told_and_kept(tmp_path: Path) -> None:
    """84 of 95 degrees are the gait's: 11 are left, and turning round wants more."""
    gait = Gait.from_degrees(84, 80, 2)
    recorded, log = run(tmp_path, Course.of_heading(-150), duration_s=16, gait=gait)
    steering = recorded.progress.steering
    assert steering is not None
    assert steering.saturated >= 2
    limits = [event for event in log.events if event.kind == "steering_limit"]
    assert len(limits) == 1  # one for all cycles in a row
    assert limits[0].level == "warning"
    assert np.abs(log.steering["offset_rad"]).max() == pytest.approx(math.radians(11), abs=1e-4)
    assert_within_limits(log)


class Outside:
    """A tracker that sees what the simulated robot does, until it falls silent."""

    def __init__(
        self, board: Board, sim: SoftBoard, silent: tuple[float, float] = (math.inf, math.inf)
    ) -> None:
        self.board, self.sim, self.silent = board, sim, silent
        self.bad, self.first_s = 0, board.clock.now_s()

    def take(self) -> list[tuple[float, SaidPose]]:
        now = self.board.clock.now_s()
        pose = self.sim.plant.pose()
        if pose is None or self.silent[0] <= now - self.first_s < self.silent[1]:
            return []
        return [(now, SaidPose(now, *pose[:3]))]


def outside_run(
    silent: tuple[float, float], bad_at_s: float = math.inf
) -> tuple[RunLoop, list[Any], list[Any]]:
    from test_run_loop import Memory

    class Kept(Memory):
        def __init__(self) -> None:
            super().__init__()
            self.steered: list[Any] = []

        def steering(self, record: Any) -> None:
            self.steered.append(record)

    clock = VirtualClock()
    sim = SoftBoard(ROBOT, start_pose=TURNED)
    board = Board(InProcessLink(sim, clock), clock)
    board.connect()
    memory = Kept()
    source = Outside(board, sim, silent)
    loop = RunLoop(
        board, ROBOT, plan_run(GAIT, 5, duration_s=26).motion_from, rate_hz=100, clock=clock,
        amplitude_rad=GAIT.alpha_rad, recorder=memory, course=parse_line("y=0"), pose_source=source,
    )  # fmt: skip
    memory.at[300] = lambda: setattr(source, "bad", 3)
    loop.run()
    return loop, memory.events, memory.steered


@pytest.mark.slow
def test_poses_that_stop_let_the_offset_fade_and_are_told_until_they_come_again() -> None:
    loop, events, steered = outside_run((8.0, 14.0))
    kinds = [event.kind for event in events]
    stale, back = kinds.index("pose_stale"), kinds.index("pose_back")
    assert events[stale].t_s == pytest.approx(8.5, abs=0.3)
    assert events[back].t_s == pytest.approx(14.0, abs=0.3)
    assert kinds.count("pose_stale") == kinds.count("pose_back") == kinds.count("pose_damaged") == 1
    faded = [record for record in steered if record.stale]
    assert len(faded) == 1
    assert faded[0].offset_rad == 0.0
    assert faded[0].t_s < events[stale].t_s + 1.1
    after = [record for record in steered if record.t_s > 14]
    assert after
    assert after[0].t_s > 14 + 0.9 * GAIT.period_s  # a whole cycle first
    assert loop.progress.steering is not None
    assert loop.progress.steering.stale_times == 1
    assert loop.progress.bad_poses == 3


def test_without_a_pose_nothing_moves_and_one_line_says_so() -> None:
    clock = VirtualClock()
    plant = LagPlant(5, 0.03)
    board = Board(InProcessLink(SoftBoard(ROBOT, plant=plant), clock), clock)
    board.connect()
    loop = RunLoop(
        board, ROBOT, plan_run(GAIT, 5).motion_from, rate_hz=100, clock=clock, amplitude_rad=1.0,
        course=parse_line("y=0"),
    )  # fmt: skip
    with pytest.raises(BadInputError, match="the board tells no pose: give one with --pose") as refused:
        loop.run()
    assert "\n" not in str(refused.value)
    assert refused.value.exit_status == 2
    assert loop.progress.ticks == 0
    assert plant.setpoint is None or max(map(abs, plant.setpoint)) == 0.0


@pytest.mark.parametrize("what", ["probe", "lifted", "alpha"])
def test_what_can_hold_no_course_is_refused_before_anything_is_opened(what: str, tmp_path: Path) -> None:
    plan = plan_run(
        parse_probe("triangle:amplitude_deg=5,rate_deg_s=20") if what == "probe"
        else Gait.from_degrees(94.5, 80, 1) if what == "alpha" else GAIT,
        5, lifted=what == "lifted",
    )  # fmt: skip
    settings = RunSettings(log_path=tmp_path / "a.mcap", course=parse_line("y=0"))
    with pytest.raises(BadInputError, match=r"cannot be held|to steer with"):
        check_run(ROBOT, plan, settings)


def test_the_gait_may_change_while_a_course_is_held(tmp_path: Path) -> None:
    """The new gait's own response counts, its limits hold, and the change is without a jump as ever."""
    other = Gait.from_degrees(30, 80, 3)

    class Changes(Attendant):
        def while_running(self, loop: RunLoop, log: Any) -> Any:
            self.tap = None
            tick = log.tick

            def and_change(record: Any) -> None:
                tick(record)
                if abs(record.t_s - 8.0) < 0.004:
                    loop.change_gait(other)

            log.tick = and_change
            return super().while_running(loop, log)

    recorded, log = run(tmp_path, Course.of_heading(0), duration_s=18, attendant=Changes("sim:"))
    assert [event.kind for event in log.events].count("gait") == 1
    assert recorded.progress.clamped == 0
    assert abs(log.steering["heading_error_rad"][-1]) < math.radians(6)
    after = log.steering_t_s[log.steering_t_s > 10]
    np.testing.assert_allclose(np.diff(after), other.period_s, atol=0.03)
    assert_within_limits(log)


def test_a_gait_that_cannot_be_steered_is_not_changed_to(tmp_path: Path) -> None:
    with open_board("sim:", ROBOT, virtual=True) as board:
        loop = RunLoop(
            board, ROBOT, plan_run(GAIT, 5, duration_s=8).motion_from, rate_hz=100, clock=board.clock,
            amplitude_rad=1.0, course=Course.of_heading(0),
        )  # fmt: skip
        loop._streamed.now = plan_run(GAIT, 5, duration_s=8).from_straight()
        with pytest.raises(BadInputError):
            loop.change_gait(Gait.from_degrees(1, 80, 2))
        check_motion(loop._streamed.now, ROBOT)
        assert loop.gait == GAIT
