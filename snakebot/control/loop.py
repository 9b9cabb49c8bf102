"""Stream a motion to a board and end it safely.

Every way out leads through the same door, in this order as far as the link lives: ramp down, hold, relax (``ends``).
What a late host does is in ``lateness``, what comes back in ``intake``, what becomes of set-points without an answer in
``inflight``, how the motion changes meanwhile in ``streamed``.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from firmware_protocol.catalogue import JointMode, StopReason
from snakebot.board import Board, check_limits
from snakebot.clock import Clock, MonotonicClock, urgent
from snakebot.control.copies import Copies
from snakebot.control.ends import Ends
from snakebot.control.fault_schedule import FaultSchedule
from snakebot.control.faults import JointFault
from snakebot.control.guiding import Guide
from snakebot.control.inflight import InFlight
from snakebot.control.intake import Intake
from snakebot.control.journal import Journal, Recorder
from snakebot.control.lateness import Lateness
from snakebot.control.making import Maker, Ready
from snakebot.control.pose_intake import WAIT_S, PoseIntake, PoseSource
from snakebot.control.posture import read_posture
from snakebot.control.progress import Progress, TrackingSoFar
from snakebot.control.rate import check_rate, watchdog_s
from snakebot.control.standstill import Standstills
from snakebot.control.stop_requests import StopRequests
from snakebot.control.streamed import StreamedMotion
from snakebot.control.takeover import take_over
from snakebot.errors import BoardFaultError, HostLateError, LostBoardError
from snakebot.gait import Gait, Motion, check_motion
from snakebot.heap import settled_heap
from snakebot.robot import Robot
from snakebot.runlog import records
from snakebot.steering import Course

# Share of the interval in which nothing else is done after a set-point, until its answer comes; chosen.
LISTEN_SHARE = 0.5
_LAST_ANSWERS_S = 0.02  # listened to after the last tick: nothing feeds the watchdog meanwhile
GAIT_BLEND_S = 1.0  # a change of gait is spread over this time; chosen
_POSE_POLL_S = 0.05  # of the wait for a first pose; chosen


@dataclass(frozen=True, slots=True)
class RunResult:
    """How a run went. ``ended`` is "finished" or "interrupted"; errors are raised instead."""

    ended: str
    duration_s: float
    progress: Progress


class RunLoop:
    """One run of one motion on one connected board."""

    def __init__(
        self,
        board: Board,
        robot: Robot,
        make_motion: Callable[[Sequence[float]], Motion],
        *,
        rate_hz: float,
        clock: Clock,
        amplitude_rad: float,
        settle_s: float = 0.0,
        faults: Sequence[JointFault] = (),
        recorder: Recorder | None = None,
        log_frames: bool = False,
        start_time_ns: int | None = None,
        keep_stop: bool = False,
        course: Course | None = None,
        pose_source: PoseSource | None = None,
    ) -> None:
        """
        Args:
            make_motion: gives the motion that begins in the posture (rad a joint) that the robot is found in.
            rate_hz: ticks a second.
            amplitude_rad: what tracking error is divided by (37).
            settle_s: tracking error so far counts from here on (the ramp).
            faults: joint faults; those at 0 s are set before the robot is armed.
            recorder: where the run is logged.
            log_frames: also record every frame of the wire.
            start_time_ns: wall clock at t = 0 of the log, for logs in virtual time.
            keep_stop: leave a board alone that is found stopped or in a fault.
            course: steer for it.
            pose_source: where poses come from, if not from the board.

        Raises:
            BadInputError: the rate is one that the loop or the board's watchdog cannot keep, a limit of the robot one
                that the wire cannot carry, or a joint fault one that the robot cannot have.
        """
        check_rate(rate_hz)
        check_limits(robot)
        self.board = board
        self.robot = robot
        self.clock = clock
        self.interval_s = 1.0 / rate_hz
        self.progress = Progress(0.0, TrackingSoFar(robot.joints, amplitude_rad))
        self._journal = Journal(recorder, board, clock, self.progress)
        self._make_motion = make_motion
        self._standstills = Standstills(clock, self.progress, self._journal)
        self._settle_s = settle_s
        self._faults = FaultSchedule(faults, robot, board, self._journal)
        self._log_frames = log_frames
        self._wall_start_ns = start_time_ns
        self._keep_stop = keep_stop
        self._guide = (
            None if course is None else Guide(course, robot, self.interval_s, self.progress, self._journal)
        )
        self._poses = PoseIntake(pose_source, self._guide, self.progress, self._journal)
        self._maker = Maker(board, robot, self.interval_s, self.progress)
        self._streamed = StreamedMotion(robot, self.progress, self._journal, self._guide)
        self._stop = StopRequests()
        self.emergency_asked = False

    # -- asked for from outside (signal handlers, other threads) -----------------------------------------------------

    def request_stop(self) -> None:
        """Ramp down and end. However often it is asked for, it is one request."""
        self._stop.request()

    @property
    def end_asked(self) -> bool:
        """Whether anybody has asked for the motion's end."""
        return self._stop.urgency > 0

    def interrupt(self) -> None:
        """Ctrl-C: ramp down and end; pressed again: hold and relax at once.

        Raises:
            KeyboardInterrupt: pressed for the third time. Raised in the loop's thread (from a signal handler), it ends
                even a loop that hangs.
        """
        self._stop.interrupt()

    def request_fault(self, fault: JointFault) -> None:
        """Bring about a joint fault with the next tick, whatever its own time is.

        Raises:
            BadInputError: no such joint, or held beyond its limit.
        """
        self._faults.request(fault)

    @property
    def gait(self) -> Gait | None:
        """The gait that was asked for last; None for a motion that is no gait."""
        return self._streamed.gait

    def request_emergency_stop(self) -> None:
        """Cut the power of all joints at the next opportunity, without a ramp."""
        self.emergency_asked = True
        self.board.request_emergency_stop(StopReason.EXTERNAL)

    def change_gait(self, gait: Gait, blend_s: float = GAIT_BLEND_S) -> None:
        """Go over to another gait without a jump, as soon as the change before has blended in.

        Asked for several times meanwhile, the last one counts.

        Raises:
            BadInputError: the motion is not a gait, the new gait breaks a limit, or checking that took so long that the
                change would begin in the past; the run goes on as it was.
        """
        self._streamed.change(gait, blend_s)

    # -- the run -----------------------------------------------------------------------------------------------------

    def run(self) -> RunResult:
        """Do the whole run; the board must be connected.

        Raises:
            BadInputError: the motion breaks a limit of the robot; nothing has moved.
            BoardFaultError: the board refused, faulted, rebooted or was stopped.
            LostBoardError: the link or the board went away.
            HostLateError: this computer could not keep the tick.
        """
        self._meet_watchdog()
        if self._log_frames:
            self.board.traffic.on_frame = self._journal.frame
        self._journal.origin_s = self.clock.now_s()
        try:
            with contextlib.ExitStack() as stack:
                if isinstance(self.clock, MonotonicClock):
                    stack.enter_context(settled_heap())
                    stack.enter_context(urgent())
                motion = self._prepare()
                ended = self._stream(motion)
            self._journal.event("finished" if ended == "finished" else "interrupted", f"run {ended}")
        except (LostBoardError, BoardFaultError, HostLateError) as error:
            error.args = (f"{error}{self._lateness.part_in(self.board.fault, self.clock.now_s())}",)
            self._ends.failed(error, lost=isinstance(error, LostBoardError))
            raise
        except BaseException as error:
            self._ends.failed(error)
            raise
        finally:
            self.board.traffic.on_frame = None
        return RunResult(ended, self.progress.t_s, self.progress)

    def _meet_watchdog(self) -> None:
        """What depends on what is behind the link, and on how long this board waits for a set-point."""
        self.board.link.check_rate(1.0 / self.interval_s)
        self.board.quicken()
        waits_s = watchdog_s(self.board, 1.0 / self.interval_s)
        self._lateness = Lateness(self.interval_s, waits_s, self.progress, self._journal)
        self._copies = Copies(
            self.interval_s, self.robot.joints, self.board.link.frames_per_s, waits_s, self.board.where
        )
        if self._copies.most < self._copies.wanted_on_a_bad_line:
            self._journal.event(
                "line",
                f"{self._copies.most} of the {self._copies.wanted_on_a_bad_line} copies of a set-point that a bad "
                "line would need fit into half of what this one carries",
                data={"frames_per_s": self.board.link.frames_per_s},
            )
        self._in_flight = InFlight(
            self.interval_s, self.clock, self.progress, self._journal, self._copies, self._settle_s
        )
        self._intake = Intake(
            self.board, self.clock, self.progress, self._journal, self._in_flight, self._poses
        )
        self._ends = Ends(self.board, self._intake, self._in_flight, self._journal, self.progress)

    def _prepare(self) -> Motion:
        """Everything before the first set-point: clear what a run before has left, limits, faults, arm.

        Raises:
            BoardFaultError: the board is stopped or in a fault and that is not to be cleared; a joint cannot be read.
        """
        board = self.board
        self._intake.take(board.poll())
        take_over(board, self._journal, keep_stop=self._keep_stop)
        modes = dict.fromkeys(range(1, self.robot.joints + 1), (JointMode.ACTIVE, 0.0))
        for joint, (mode, angle_rad) in modes.items():
            board.set_joint_mode(joint, mode, angle_rad)
        board.set_limits(self.robot)
        for fault in self._faults.due(0.0):
            self._faults.set(fault, wait=True)
            modes |= dict.fromkeys(fault.joints, (fault.mode, fault.angle_rad))
        found_rad = read_posture(
            board, self.clock, [mode is not JointMode.FREE for mode, _ in modes.values()], self._intake.take
        )
        limits = self.robot.angle_limit_rad
        start = [min(max(angle, -limit), limit) for angle, limit in zip(found_rad, limits, strict=True)]
        motion = self._make_motion(start)
        check_motion(motion, self.robot)
        if self._guide is not None:
            self._guide.meet(motion)
            self._wait_for_a_pose()
        self._maker.start(start)
        self.progress.duration_s = motion.duration_s
        board.arm()
        for joint, (mode, angle_rad) in modes.items():  # until now another host could set them otherwise
            board.set_joint_mode(joint, mode, angle_rad, wait=False)
        self._journal.event("armed", "joints powered where they are", data={"start_rad": start})
        return motion

    def _wait_for_a_pose(self) -> None:
        """
        Raises:
            BadInputError: none comes.
        """
        until_s = self.clock.now_s() + WAIT_S
        self._poses.look()
        while self._poses.missing:
            if self.clock.now_s() >= until_s:
                raise self._poses.refused(self.board.where)
            self._intake.take(self.board.poll(_POSE_POLL_S))
            self._poses.look()

    def _stream(self, motion: Motion) -> str:
        """Send the motion tick by tick. Returns how it ended, with the joints at rest and relaxed."""
        self._streamed.now = motion
        self._standstills.begin()
        self._journal.origin_s = self.clock.now_s()
        if self.board.lossy:
            self._copies.lost(self._journal.origin_s)
        if self._wall_start_ns is None:
            self._wall_start_ns = time.time_ns()
        if self._guide is not None:
            self._guide.begin()
        ended = "finished"
        failure: Exception | None = None
        tick = 0
        while True:
            t_s = tick * self.interval_s
            try:
                ready = self._wait_for(tick)
                tick = ready.tick
                t_s = tick * self.interval_s
                if self._stop.urgency and ended == "finished":
                    ended = "interrupted"
                    self._streamed.end(t_s)
                    self._journal.event("stopping", "asked to stop: ramping down", "warning")
                if self._stop.urgency > 1 or t_s > self._streamed.now.duration_s + self.interval_s / 2:
                    break
                for fault in self._faults.due(t_s):
                    self._faults.set(fault, wait=False)
                self._send(ready, t_s)
                self._poses.look()
                if self._guide is not None:
                    self._guide.look(t_s, self._streamed.now)
            except (LostBoardError, BoardFaultError, HostLateError):
                raise
            except (
                Exception
            ) as error:  # the log's disk is full, or a fault of ours: the link lives, so ramp down
                if failure is not None:
                    raise
                failure = error
                self._journal.stop()
                self._streamed.end(t_s)
            tick += 1
        self._intake.during(min(_LAST_ANSWERS_S, self._lateness.spare_s(self.clock.now_s())))
        self._in_flight.give_up()
        self._ends.relax()
        self._standstills.look(last=True)
        if failure is not None:
            raise failure
        return ended

    def _wait_for(self, tick: int) -> Ready:
        """Wait for a tick's deadline. Returns what is due then: a later tick if this one was slept through."""
        deadline = self._journal.origin_s + tick * self.interval_s
        self._intake.until(deadline)
        ready = self._maker.make(self._streamed.now, tick)
        self.clock.sleep_until(deadline)
        now = self.clock.now_s()
        self._standstills.look()
        self._lateness.judge(now - deadline, now)
        if self._lateness.hopeless:
            self.board.hold()
            self._journal.event("holding", "too many ticks came far too late", "error")
            raise self._lateness.error()
        skipped = self._lateness.skip()
        return self._maker.make(self._streamed.now, tick + skipped) if skipped else ready

    def _send(self, ready: Ready, t_s: float) -> None:
        now = self.clock.now_s()
        self.board.send_made(ready.made, self._copies.number(now))
        try:
            self.board.await_answer(LISTEN_SHARE * self.interval_s)
        finally:  # it is on its way, whatever is heard
            self._sent(ready, t_s, now)

    def _sent(self, ready: Ready, t_s: float, now: float) -> None:
        """Put down what went out at ``now``."""
        self._maker.sent(ready)
        progress = self.progress
        progress.ticks += 1
        progress.late += self._lateness.late
        progress.t_s = t_s
        progress.mode = self.board.mode
        progress.starts_s.append(now)
        assert self._wall_start_ns is not None
        stood_still_s = progress.standstill.total_s
        record = records.Tick(
            sequence=ready.made.sequence,
            t_s=now - self._journal.origin_s,
            host_time_ns=self._wall_start_ns + round((now - self._journal.origin_s + stood_still_s) * 1e9),
            setpoint_rad=ready.wanted_rad,
            sent_rad=ready.made.angles_rad,
            late=self._lateness.late,
        )
        self._in_flight.sent(record, ready.wanted_rad, now)
