"""The run loop on a simulated board in this process: what is sent, what is measured, and that every way out is safe."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from lag_plant import LagPlant

from firmware_protocol.catalogue import EmergencyStop, JointMode, Latch, Mode, StopReason, decode, encode
from firmware_protocol.frame import Frame
from snakebot.board import Board
from snakebot.clock import VirtualClock
from snakebot.control import JointFault, RunLoop
from snakebot.errors import BadInputError, BoardFaultError, LogError, LostBoardError
from snakebot.gait import Gait, GaitMotion
from snakebot.robot import load_robot
from snakebot.runlog.records import Event, Tick
from snakebot.softboard import InProcessLink, SoftBoard

ROBOT = load_robot("penn_state")
GAIT = Gait.from_degrees(66, 80, 2)
TAU_S = ROBOT.servo.time_constant_s


class Memory:
    """A recorder that keeps everything, and can be told to call something at a tick."""

    def __init__(self) -> None:
        self.ticks: list[Tick] = []
        self.events: list[Event] = []
        self.at: dict[int, Callable[[], None]] = {}

    def tick(self, tick: Tick) -> None:
        self.ticks.append(tick)
        if len(self.ticks) in self.at:
            self.at[len(self.ticks)]()

    def event(self, event: Event) -> None:
        self.events.append(event)

    def ignore(self, *_: Any) -> None:
        pass

    pose = link_statistics = telemetry = steering = frame = ignore

    @property
    def kinds(self) -> list[str]:
        return [event.kind for event in self.events]


class Bench:
    """Board, link, loop and recorder in virtual time."""

    def __init__(
        self, rate_hz: float = 100, duration_s: float = 8, ramp_s: float = 1, **options: Any
    ) -> None:
        self.clock = VirtualClock()
        self.plant = LagPlant(ROBOT.joints, TAU_S)
        self.sim = SoftBoard(ROBOT, plant=self.plant)
        self.link = InProcessLink(self.sim, self.clock)
        self.board = Board(self.link, self.clock)
        self.board.connect()
        self.memory = Memory()
        self.start: Sequence[float] = ()

        def motion(start: Sequence[float]) -> GaitMotion:
            self.start = start
            return GaitMotion(GAIT, ROBOT.joints, duration_s, ramp_s, start)

        self.loop = RunLoop(
            self.board,
            ROBOT,
            motion,
            rate_hz=rate_hz,
            clock=self.clock,
            amplitude_rad=GAIT.alpha_rad,
            settle_s=2 * ramp_s,
            recorder=self.memory,
            **options,
        )

    @property
    def sent(self) -> np.ndarray:
        return np.array([tick.sent_rad for tick in self.memory.ticks])

    def assert_came_to_rest(self) -> None:
        """The last set-points stand still: the robot was ramped down before it was held."""
        assert np.abs(np.diff(self.sent[-4:], axis=0)).max() < 2e-3
        assert self.board.mode is Mode.DISARMED


def test_a_run_sends_the_motion_and_logs_what_came_back() -> None:
    bench = Bench()
    result = bench.loop.run()
    assert result.ended == "finished"
    ticks = bench.memory.ticks
    assert len(ticks) == result.progress.ticks == 801
    sequences = [tick.sequence for tick in ticks]
    assert all((b - a) & 0xFFFF == 1 for a, b in pairwise(sequences))
    motion = GaitMotion(GAIT, ROBOT.joints, 8, 1, bench.start)
    wanted = motion.sampled(np.arange(801) / 100)
    np.testing.assert_allclose(bench.sent, wanted, atol=0.51e-4)  # the wire's resolution
    np.testing.assert_allclose(np.array([tick.applied_rad for tick in ticks]), bench.sent, atol=1e-9)
    assert (result.progress.late, result.progress.lost, result.progress.clamped) == (0, 0, 0)
    bench.assert_came_to_rest()
    assert bench.memory.kinds[0] == "armed"
    assert bench.memory.kinds[-3:] == ["holding", "disarmed", "finished"]


def test_tracking_error_is_what_a_first_order_lag_behind_held_setpoints_predicts() -> None:
    """y[k+1] = y[k] + (1 - exp(-T/tau)) (s[k] - y[k]): its transfer function at the gait's frequency gives TE (37)."""
    bench = Bench(duration_s=2 + 8 * GAIT.period_s, ramp_s=1)
    result = bench.loop.run()
    interval = 0.01
    share = 1 - math.exp(-interval / TAU_S)
    z = complex(math.cos(GAIT.omega_rad_s * interval), math.sin(GAIT.omega_rad_s * interval))
    transfer = share / (z - (1 - share))
    predicted = abs(transfer - 1) / math.sqrt(2)
    ticks = [tick for tick in bench.memory.ticks if 1.5 <= tick.t_s < 1.5 + 7 * GAIT.period_s]
    error = np.array([tick.measured_rad for tick in ticks], float) - [tick.setpoint_rad for tick in ticks]
    measured = np.sqrt((error**2).mean(axis=0)) / GAIT.alpha_rad
    np.testing.assert_allclose(measured, predicted, rtol=0.01)
    np.testing.assert_allclose(result.progress.tracking.error, predicted, rtol=0.05)


def test_the_motion_starts_where_the_joints_are() -> None:
    bench = Bench()
    found = bench.plant.angle = [0.3, -0.2, 0.1, 0.0, -0.3]
    posture = list(found)
    bench.loop.run()
    assert bench.start == pytest.approx(posture, abs=ROBOT.rad_per_count)
    np.testing.assert_allclose(bench.sent[0], bench.start, atol=1e-3)


def test_a_motion_beyond_a_limit_moves_nothing() -> None:
    bench = Bench()
    bench.loop._make_motion = lambda start: GaitMotion(Gait.from_degrees(80, 80, 9), 5, 8, 1, start)
    with pytest.raises(BadInputError, match="joint"):
        bench.loop.run()
    assert bench.memory.ticks == []
    assert bench.board.mode is Mode.DISARMED


def test_asked_to_stop_it_ramps_down_holds_and_relaxes() -> None:
    bench = Bench(duration_s=60)
    bench.memory.at[300] = bench.loop.request_stop
    result = bench.loop.run()
    assert result.ended == "interrupted"
    assert 390 <= len(bench.memory.ticks) <= 410
    bench.assert_came_to_rest()
    assert bench.memory.kinds[-4:] == ["stopping", "holding", "disarmed", "interrupted"]


def test_ctrl_c_pressed_twice_holds_and_relaxes_at_once() -> None:
    bench = Bench(duration_s=60)
    bench.memory.at[300] = bench.loop.interrupt
    bench.memory.at[310] = bench.loop.interrupt
    assert bench.loop.run().ended == "interrupted"
    assert len(bench.memory.ticks) <= 315
    assert bench.board.mode is Mode.DISARMED


def test_a_hangup_is_one_request_however_often_it_is_sent() -> None:
    """Kernel and shell both send it, and a service manager may add a SIGTERM: the ramp is not cut short."""
    bench = Bench(duration_s=60)
    for tick in (300, 301, 320, 350):
        bench.memory.at[tick] = bench.loop.request_stop
    assert bench.loop.run().ended == "interrupted"
    assert 390 <= len(bench.memory.ticks) <= 410
    bench.assert_came_to_rest()


def test_ctrl_c_after_a_hangup_counts_from_one() -> None:
    bench = Bench(duration_s=60)
    bench.memory.at[300] = bench.loop.request_stop
    bench.memory.at[310] = bench.loop.interrupt
    assert bench.loop.run().ended == "interrupted"
    assert 390 <= len(bench.memory.ticks) <= 410


def test_a_log_that_fails_ramps_the_robot_down_before_it_is_reported() -> None:
    bench = Bench(duration_s=60)
    latches: list[int] = []

    def fail() -> None:
        raise LogError("runs/x.mcap: no space left on device")

    bench.memory.at[300] = fail
    real_send = bench.link.send

    def count(frames: Sequence[Frame]) -> None:
        latches.extend(1 for frame in frames if isinstance(decode(frame), Latch))
        real_send(frames)

    bench.link.send = count  # type: ignore[method-assign]
    with pytest.raises(LogError, match="no space"):
        bench.loop.run()
    assert 395 <= len(latches) <= 410  # another second of ramp after tick 300
    assert bench.board.mode is Mode.DISARMED
    assert max(abs(angle) for angle in bench.plant.angle) < 0.02


def test_a_pulled_cable_is_reported_and_the_boards_watchdog_freezes_the_joints() -> None:
    bench = Bench(duration_s=60)
    bench.memory.at[300] = bench.link.unplug
    with pytest.raises(LostBoardError):
        bench.loop.run()
    lost_at = bench.clock.now_s()
    frozen = list(bench.plant.angle)
    bench.sim.advance(lost_at + 0.101)
    bench.sim.advance(lost_at + 1.5)
    assert np.abs(np.subtract(bench.plant.angle, frozen)).max() < 0.1
    assert bench.sim.mode is Mode.FAULT


def test_an_emergency_stop_of_another_host_ends_the_run() -> None:
    bench = Bench(duration_s=60)

    def stop() -> None:
        bench.sim.receive(encode(EmergencyStop(StopReason.EXTERNAL, 7)), bench.clock.now_s())

    bench.memory.at[300] = stop
    with pytest.raises(BoardFaultError, match="emergency stop"):
        bench.loop.run()
    assert bench.sim.mode is Mode.STOPPED
    assert len(bench.memory.ticks) <= 305


def test_our_own_emergency_stop_cuts_the_power_without_a_ramp() -> None:
    bench = Bench(duration_s=60)
    bench.memory.at[300] = bench.loop.request_emergency_stop
    with pytest.raises(BoardFaultError, match="emergency stop"):
        bench.loop.run()
    bench.sim.advance(bench.clock.now_s())
    assert bench.sim.mode is Mode.STOPPED
    assert len(bench.memory.ticks) <= 302


def test_a_rebooted_board_is_a_fault_and_is_not_armed_again() -> None:
    bench = Bench(duration_s=60)
    bench.memory.at[300] = lambda: bench.sim.reset(bench.clock.now_s())
    with pytest.raises(BoardFaultError, match="rebooted"):
        bench.loop.run()
    bench.sim.advance(bench.clock.now_s())
    assert bench.sim.mode is Mode.DISARMED


def test_a_host_that_stalls_skips_ticks_and_never_bunches_them() -> None:
    bench = Bench(duration_s=8)
    bench.memory.at[300] = lambda: bench.clock.sleep_until(bench.clock.now_s() + 0.055)
    result = bench.loop.run()
    assert result.progress.skipped == 4
    times = np.array([tick.t_s for tick in bench.memory.ticks])
    assert (
        np.diff(times).min() > 0.004
    )  # the set-point after the stall may be up to half a tick early, no more
    assert np.diff(times).max() < 0.07


def test_a_stall_longer_than_the_watchdog_ends_the_run() -> None:
    bench = Bench(duration_s=8)
    bench.memory.at[300] = lambda: bench.clock.sleep_until(bench.clock.now_s() + 0.5)
    with pytest.raises(BoardFaultError, match="watchdog"):
        bench.loop.run()


def test_a_fault_of_our_own_still_ends_safely() -> None:
    bench = Bench(duration_s=60)

    def crash() -> None:
        raise ZeroDivisionError

    bench.memory.at[300] = crash
    with pytest.raises(ZeroDivisionError):
        bench.loop.run()
    assert bench.board.mode is Mode.DISARMED
    assert max(abs(angle) for angle in bench.plant.angle) < 0.02


def test_what_a_run_before_has_left_is_cleared() -> None:
    bench = Bench(duration_s=60)
    bench.memory.at[300] = bench.link.unplug
    with pytest.raises(LostBoardError):
        bench.loop.run()
    bench.clock.sleep_until(bench.clock.now_s() + 5)
    link = InProcessLink(bench.sim, bench.clock)
    board = Board(link, bench.clock)
    board.connect()
    assert board.mode is Mode.FAULT
    loop = RunLoop(
        board,
        ROBOT,
        lambda start: GaitMotion(GAIT, 5, 6, 1, start),
        rate_hz=100,
        clock=bench.clock,
        amplitude_rad=GAIT.alpha_rad,
    )
    assert loop.run().ended == "finished"


def test_joint_faults_reach_the_board_at_their_time() -> None:
    faults = [
        JointFault(0, (2,), JointMode.RIGID, 0.0),
        JointFault(3, (4,), JointMode.RIGID_HERE),
        JointFault(5, (1, 2, 3, 4, 5), JointMode.ACTIVE),
    ]
    bench = Bench(duration_s=9, faults=faults)
    bench.loop.run()
    t = np.array([tick.t_s for tick in bench.memory.ticks])
    measured = np.array([tick.measured_rad for tick in bench.memory.ticks])
    assert np.abs(measured[t < 5, 1]).max() < 2e-3
    stuck = measured[(t > 3.3) & (t < 5), 3]
    assert np.ptp(stuck) < 2e-3
    assert np.abs(stuck).min() > 0.05
    assert np.ptp(measured[(t > 5.5) & (t < 8), 1]) > 1.0
    applied = np.array([tick.applied_rad for tick in bench.memory.ticks])
    speed = np.abs(np.diff(applied, axis=0)) / 0.01
    assert speed.max() <= ROBOT.speed_limit_rad_s[0] + 0.05  # released joints come back within their limits


def test_a_live_change_of_gait_has_no_jump() -> None:
    bench = Bench(duration_s=20)
    bench.memory.at[400] = lambda: bench.loop.change_gait(Gait.from_degrees(40, 60, 3), 1.0)
    bench.loop.run()
    sent = bench.sent
    assert np.abs(np.diff(sent, n=2, axis=0)).max() / 0.01**2 < 25
    late = sent[800:1700]
    assert np.abs(late).max() == pytest.approx(math.radians(40), rel=0.01)


def test_changes_in_quick_succession_come_to_the_last_one_without_a_jump() -> None:
    bench = Bench(duration_s=20)
    for number in range(
        12
    ):  # twelve presses of a key within a quarter of a second: one blend takes a whole one
        gait = Gait.from_degrees(60 - 2 * number, 80, 2)
        bench.memory.at[400 + 2 * number] = partial(bench.loop.change_gait, gait, 1.0)
    bench.loop.run()
    sent = bench.sent
    assert np.abs(np.diff(sent, n=2, axis=0)).max() / 0.01**2 < 25
    assert np.abs(sent[800:1700]).max() == pytest.approx(math.radians(38), rel=0.01)


def test_a_change_beyond_a_limit_is_refused_and_the_run_goes_on() -> None:
    bench = Bench(duration_s=8)
    refused: list[str] = []

    def change() -> None:
        try:
            bench.loop.change_gait(Gait.from_degrees(90, 80, 12), 1.0)
        except BadInputError as error:
            refused.append(str(error))

    bench.memory.at[300] = change
    assert bench.loop.run().ended == "finished"
    assert "joint" in refused[0]


@pytest.mark.parametrize(("check_s", "changes"), [(0.3, True), (4.5, False)])
def test_a_change_whose_check_takes_long_never_begins_in_the_past(
    check_s: float, changes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The keyboard's thread checks while the loop goes on: what has begun already by then would be a jump."""
    from snakebot.control import streamed

    bench = Bench(duration_s=24)
    new = Gait.from_degrees(40, 60, 3)
    refused: list[str] = []

    def slow_check(*_: Any) -> None:
        bench.loop.progress.t_s += check_s

    def change() -> None:
        monkeypatch.setattr(streamed, "check_motion", slow_check)
        try:
            bench.loop.change_gait(new, 1.0)
        except BadInputError as error:
            refused.append(str(error))

    bench.memory.at[400] = change
    assert bench.loop.run().ended == "finished"
    assert [("too slow" in text) for text in refused] == ([] if changes else [True])
    assert np.abs(np.diff(bench.sent, n=2, axis=0)).max() / 0.01**2 < 25
    late = bench.sent[1200:2000]
    assert np.abs(late).max() == pytest.approx((new if changes else GAIT).alpha_rad, rel=0.01)


@pytest.mark.parametrize("rate", [5, 5000, math.nan])
def test_rates_that_cannot_be_kept_are_refused(rate: float) -> None:
    with pytest.raises(BadInputError, match="--rate"):
        Bench(rate_hz=rate)


def test_a_third_ctrl_c_ends_the_run_wherever_it_is() -> None:
    bench = Bench(duration_s=60)

    def ask_three_times() -> None:
        for _ in range(3):
            bench.loop.interrupt()

    bench.memory.at[300] = ask_three_times
    with pytest.raises(KeyboardInterrupt):
        bench.loop.run()
    assert len(bench.memory.ticks) <= 305
    assert bench.board.mode is Mode.DISARMED


def test_a_line_too_slow_for_the_rate_is_refused_before_anything_moves() -> None:
    bench = Bench()
    bench.link.frames_per_s = 500.0
    with pytest.raises(
        BadInputError, match=r"take 300 frames/s, and sim carries 500, of which they may have half"
    ):
        bench.loop.run()
    assert bench.memory.kinds == []
    assert bench.board.mode is Mode.DISARMED


def test_a_line_without_room_for_all_copies_says_so_in_the_log() -> None:
    """A bus of 125 kbit/s carries 926 frames/s: set-points of five joints at 100 Hz fit once, not twice."""
    bench = Bench(duration_s=2)
    bench.link.frames_per_s = 125_000 / 135
    bench.loop.run()
    (line,) = [event for event in bench.memory.events if event.kind == "line"]
    assert line.message.startswith("1 of the 2 copies")
