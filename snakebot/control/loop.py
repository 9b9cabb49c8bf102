"""Stream a motion to a board and end it safely.

Every way out leads through the same door, in this order as far as the link lives: ramp down, hold, relax. What a late
host does is in ``lateness``, what becomes of set-points without an answer in ``inflight``.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

from firmware_protocol.catalogue import Counters, FaultEvent, JointMode, JointSupply, Mode, StopReason, Supply
from snakebot.board import Board, Pose, Reading, Received, check_limits
from snakebot.clock import Clock, MonotonicClock, urgent
from snakebot.control.copies import Copies
from snakebot.control.faults import JointFault
from snakebot.control.inflight import InFlight
from snakebot.control.journal import Journal, Recorder
from snakebot.control.lateness import LATE_ROW_HOLD, Lateness
from snakebot.control.posture import read_posture
from snakebot.control.progress import Progress, TrackingSoFar
from snakebot.errors import BadInputError, BoardFaultError, HostLateError, LostBoardError, SnakebotError
from snakebot.gait import Gait, GaitMotion, Motion, SlewLimiter, check_motion
from snakebot.robot import Robot
from snakebot.runlog import records

HOLD_BEFORE_RELAX_S = 0.2
_WAKE_EARLY_S = 0.0003  # leave the wait for frames this much before a deadline, and sleep the rest exactly
_LAST_ANSWERS_S = 0.02  # listened to after the last set-point: nothing feeds the watchdog meanwhile
_SHORTEST_WAIT_S = 1e-6  # a wait that rounding may swallow would never end in virtual time
_CHANGE_AHEAD_S = (0.25, 1.0, 4.0)  # time to check a new gait before it begins; more for a long run
# Below 20 Hz the board's watchdog (100 ms) would trip between two ticks that both arrive.
MIN_RATE_HZ, MAX_RATE_HZ = 20.0, 1000.0


@dataclass(frozen=True, slots=True)
class RunResult:
    """How a run went. ``ended`` is "finished" or "interrupted"; errors are raised instead."""

    ended: str
    duration_s: float
    progress: Progress


def check_rate(rate_hz: float) -> None:
    """Raises: BadInputError: the loop, or the board's watchdog, cannot keep this rate."""
    if not MIN_RATE_HZ <= rate_hz <= MAX_RATE_HZ:
        raise BadInputError(f"--rate {rate_hz:g}: give {MIN_RATE_HZ:g} to {MAX_RATE_HZ:g} Hz")


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

        Raises:
            BadInputError: the rate is one that the loop or the board's watchdog cannot keep, or a limit of the robot
                one that the wire cannot carry.
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
        self._lateness = Lateness(self.interval_s, self.progress)
        self._copies = Copies(self.interval_s, robot.joints, board.link.frames_per_s)
        self._in_flight = InFlight(
            self.interval_s, clock, self.progress, self._journal, self._copies, settle_s
        )
        self._faults = sorted(faults, key=lambda fault: fault.at_s)
        self._log_frames = log_frames
        self._wall_start_ns = start_time_ns
        self._keep_stop = keep_stop
        # The motion is not rounded yet: the slack is left to the board, which sees it rounded.
        self._limiter = SlewLimiter(
            robot.angle_limit_rad, robot.speed_limit_rad_s, robot.acceleration_limit_rad_s2, slack_rad=0.0
        )
        self._motion: Motion = GaitMotion(
            Gait(0, 0, 0), robot.joints, 0, 0
        )  # the real one is made when armed
        self._changing = threading.Lock()  # of the motion: keys and signals come from elsewhere
        self._stop_requests = 0

    # -- asked for from outside (signal handlers, other threads) -----------------------------------------------------

    def request_stop(self) -> None:
        """Ramp down and end. Asked for a second time: hold and relax at once.

        Raises:
            KeyboardInterrupt: asked for a third time. Raised in the loop's thread (from a signal handler), it ends
                even a loop that hangs.
        """
        self._stop_requests += 1
        if self._stop_requests > 2:
            raise KeyboardInterrupt

    def request_emergency_stop(self) -> None:
        """Cut the power of all joints at the next opportunity, without a ramp."""
        self.board.request_emergency_stop(StopReason.EXTERNAL)

    def change_gait(self, gait: Gait, blend_s: float) -> None:
        """Go over to another gait without a jump, beginning shortly from now.

        Raises:
            BadInputError: the motion is not a gait, the last change has not ended yet, the new gait breaks a limit, or
                checking that took so long that the change would begin in the past; the run goes on as it was.
        """
        motion = self._motion
        if not isinstance(motion, GaitMotion):
            raise BadInputError("only a running gait can be changed")
        for ahead_s in _CHANGE_AHEAD_S:
            start_s = self.progress.t_s + ahead_s
            changed = motion.changed(start_s, gait, blend_s)
            check_motion(changed, self.robot, start_s)
            if self.progress.t_s < start_s:
                break
        else:
            raise BadInputError("this computer was too slow to check the new gait in time: try again")
        with self._changing:
            if self._motion is not motion:  # a stop came in between
                return
            self._motion = changed
        self._journal.event("gait", f"changed to {gait}", data=asdict(gait))

    # -- the run -----------------------------------------------------------------------------------------------------

    def run(self) -> RunResult:
        """Do the whole run; the board must be connected.

        Raises:
            BadInputError: the motion breaks a limit of the robot; nothing has moved.
            BoardFaultError: the board refused, faulted, rebooted or was stopped.
            LostBoardError: the link or the board went away.
            HostLateError: this computer could not keep the tick.
        """
        if self._log_frames:
            self.board.on_frame = self._journal.frame
        self._journal.origin_s = self.clock.now_s()
        try:
            with urgent() if isinstance(self.clock, MonotonicClock) else contextlib.nullcontext():
                motion = self._prepare()
                ended = self._stream(motion)
            self._journal.event("finished" if ended == "finished" else "interrupted", f"run {ended}")
        except (LostBoardError, BoardFaultError, HostLateError) as error:
            self._journal.event("error", str(error), "error")
            self._abandon(lost=isinstance(error, LostBoardError))
            raise
        except BaseException:
            self._abandon()
            raise
        finally:
            self.board.on_frame = None
        return RunResult(ended, self.progress.t_s, self.progress)

    def _prepare(self) -> Motion:
        """Everything before the first set-point: clear what a run before has left, limits, faults, arm.

        Raises:
            BoardFaultError: the board is stopped or in a fault and that is not to be cleared; a joint cannot be read.
        """
        board = self.board
        if board.mode is not Mode.DISARMED:
            found = board.mode.name.lower() if board.mode is not None else "unknown"
            if self._keep_stop and board.mode in (Mode.STOPPED, Mode.FAULT):
                raise BoardFaultError(
                    f"{board.where}: the board is in mode {found} already: nothing was moved"
                )
            self._journal.event("cleared", f"the board was {found}; disarmed it first", "warning")
            board.disarm()
        modes = dict.fromkeys(range(1, self.robot.joints + 1), (JointMode.ACTIVE, 0.0))
        for joint, (mode, angle_rad) in modes.items():
            board.set_joint_mode(joint, mode, angle_rad)
        board.set_limits(self.robot)
        while self._faults and self._faults[0].at_s <= 0:
            fault = self._faults.pop(0)
            self._set_fault(fault, wait=True)
            modes |= dict.fromkeys(fault.joints, (fault.mode, fault.angle_rad))
        found_rad = read_posture(
            board, self.clock, [mode is not JointMode.FREE for mode, _ in modes.values()], self._take
        )
        limits = self.robot.angle_limit_rad
        start = [min(max(angle, -limit), limit) for angle, limit in zip(found_rad, limits, strict=True)]
        motion = self._make_motion(start)
        check_motion(motion, self.robot)
        self._limiter.reset(start)
        self.progress.duration_s = motion.duration_s
        board.arm()
        for joint, (mode, angle_rad) in modes.items():  # until now another host could set them otherwise
            board.set_joint_mode(joint, mode, angle_rad, wait=False)
        self._journal.event("armed", "joints powered where they are", data={"start_rad": start})
        return motion

    def _stream(self, motion: Motion) -> str:
        """Send the motion tick by tick. Returns how it ended, with the joints at rest and relaxed."""
        self._motion = motion
        self._journal.origin_s = self.clock.now_s()
        if self.board.lossy:
            self._copies.lost(self._journal.origin_s)
        if self._wall_start_ns is None:
            self._wall_start_ns = time.time_ns()
        ended = "finished"
        failure: Exception | None = None
        tick, previous = 0, -1
        while True:
            t_s = tick * self.interval_s
            try:
                tick = self._wait_for(tick)
                t_s = tick * self.interval_s
                if self._stop_requests and ended == "finished":
                    ended = "interrupted"
                    self._ramp_down(t_s)
                    self._journal.event("stopping", "asked to stop: ramping down", "warning")
                if self._stop_requests > 1 or t_s > self._motion.duration_s + self.interval_s / 2:
                    break
                while self._faults and self._faults[0].at_s <= t_s:
                    self._set_fault(self._faults.pop(0), wait=False)
                self._send_tick(t_s, (tick - previous) * self.interval_s)
            except (LostBoardError, BoardFaultError, HostLateError):
                raise
            except (
                Exception
            ) as error:  # the log's disk is full, or a fault of ours: the link lives, so ramp down
                if failure is not None:
                    raise
                failure = error
                self._journal.stop()
                self._ramp_down(t_s)
            previous = tick
            tick += 1
        self._listen(min(2 * self.interval_s, _LAST_ANSWERS_S))
        self._in_flight.give_up()
        self._relax()
        if failure is not None:
            raise failure
        return ended

    def _ramp_down(self, t_s: float) -> None:
        with self._changing:
            self._motion = self._motion.ended(t_s)

    def _wait_for(self, tick: int) -> int:
        """Wait for a tick's deadline. Returns the tick that is due then: a later one if this one was slept through."""
        deadline = self._journal.origin_s + tick * self.interval_s
        self._listen_until(deadline)
        self._lateness.judge(self.clock.now_s() - deadline)
        if self._lateness.hopeless:
            self.board.hold()
            self._journal.event("holding", f"{LATE_ROW_HOLD} late ticks in a row", "error")
            raise self._lateness.error()
        return tick + self._lateness.skip()

    def _send_tick(self, t_s: float, interval_s: float) -> None:
        wanted = self._motion.angles(t_s)
        interval_s = min(interval_s, 0.1)
        executed = self._limiter.execute(wanted, interval_s, 1, interval_s)
        assert executed is not None  # the loop's own interval is never too short
        limited, clamped = executed
        now = self.clock.now_s()
        sequence, sent = self.board.send_setpoints(limited, interval_s, self._copies.number(now))
        progress = self.progress
        progress.ticks += 1
        progress.late += self._lateness.late
        progress.clamped += clamped
        progress.t_s = t_s
        progress.mode = self.board.mode
        progress.starts_s.append(now)
        assert self._wall_start_ns is not None
        record = records.Tick(
            sequence=sequence,
            t_s=now - self._journal.origin_s,
            host_time_ns=self._wall_start_ns + round((now - self._journal.origin_s) * 1e9),
            setpoint_rad=wanted,
            sent_rad=sent,
            late=self._lateness.late,
        )
        self._in_flight.sent(record, wanted, now)

    # -- what comes back ---------------------------------------------------------------------------------------------

    def _listen_until(self, deadline_s: float) -> None:
        """Take in frames until shortly before the deadline, then sleep up to it exactly."""
        while (left := deadline_s - self.clock.now_s() - _WAKE_EARLY_S) > _SHORTEST_WAIT_S:
            self._take(self.board.poll(left))
        self._take(self.board.poll(0.0))
        self.clock.sleep_until(deadline_s)

    def _listen(self, duration_s: float) -> None:
        deadline = self.clock.now_s() + duration_s
        while (left := deadline - self.clock.now_s()) > _SHORTEST_WAIT_S:
            self._take(self.board.poll(left))

    def _take(self, received: Sequence[Received]) -> None:
        for item in received:
            match item:
                case Reading():
                    self._in_flight.answered(item)
                case Pose():
                    self.progress.pose = item
                    self._journal.pose(item)
                case Supply():
                    self.progress.supply = item
                    self._journal.telemetry({"supply_v": item.voltage_v, "supply_a": item.current_a})
                case JointSupply():
                    values = {
                        f"current_{item.joint}_a": item.current_a,
                        f"temperature_{item.joint}_c": item.temperature_c,
                    }
                    self._journal.telemetry(values)
                case Counters():
                    self.progress.counters = item
                case FaultEvent():
                    self._journal.event("fault", f"board reports {item.code.name.lower()}", "error")
                case _:
                    pass
        self._journal.statistics()

    # -- ends --------------------------------------------------------------------------------------------------------

    def _relax(self) -> None:
        """Hold for a moment, then take the power away."""
        self.board.hold()
        self._journal.event("holding", "joints held")
        self._listen(HOLD_BEFORE_RELAX_S)
        self.board.disarm()
        self._journal.event("disarmed", "joints relaxed")
        self.progress.mode = Mode.DISARMED

    def _abandon(self, *, lost: bool = False) -> None:
        """After an error: hold and relax if the link still lives. A dead one leaves it to the watchdog, and one that
        is dead in one direction may still carry the word to relax.
        """
        with contextlib.suppress(SnakebotError, OSError):
            self._in_flight.give_up()
        if self.board.mode in (Mode.STOPPED, Mode.FAULT):
            return  # the board has stopped the joints itself; disarming would clear what it reports
        with contextlib.suppress(SnakebotError, OSError):
            if not lost:
                if self.board.mode is Mode.ARMED:
                    self.board.hold()
                self.board.disarm()
                return
        with contextlib.suppress(SnakebotError, OSError):
            self.board.disarm_unheard()

    # -- records -----------------------------------------------------------------------------------------------------

    def _set_fault(self, fault: JointFault, *, wait: bool) -> None:
        for joint in fault.joints:
            self.board.set_joint_mode(joint, fault.mode, fault.angle_rad, wait=wait)
        names = "+".join(map(str, fault.joints))
        self._journal.event(
            "joint_mode",
            f"joint {names}: {fault.mode.name.lower()}",
            data={
                "joints": list(fault.joints),
                "mode": fault.mode.name.lower(),
                "angle_rad": fault.angle_rad,
            },
        )
