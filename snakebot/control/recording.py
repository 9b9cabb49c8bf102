"""One motion on one connected board, logged: ``record``."""

from __future__ import annotations

import contextlib
import math
import platform
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from firmware_protocol.catalogue import Fault, StopReason
from snakebot.board import Board, check_limits
from snakebot.board.faults import fault_line
from snakebot.board.stopping import stop_board
from snakebot.clock import RATE_HZ, VirtualClock
from snakebot.control.attending import Attendant
from snakebot.control.faults import JointFault, check_faults
from snakebot.control.guiding import check_course
from snakebot.control.loop import RunLoop, RunResult
from snakebot.control.plans import RunPlan, settle_s
from snakebot.control.pose_intake import PoseSource
from snakebot.control.progress import Progress
from snakebot.control.rate import check_rate
from snakebot.errors import BadInputError, BoardFaultError, SnakebotError
from snakebot.gait import check_motion
from snakebot.robot import Robot
from snakebot.runlog import RunWriter, gait_to_mapping, new_log_path, read_log
from snakebot.runlog.naming import check_new_log, stamped_path
from snakebot.steering import Course

if TYPE_CHECKING:
    from snakebot.runlog import Run
    from snakebot.steering.pose_udp import UdpAddress

_STEADY_SHARE = 0.5  # speed is averaged over the last half of the cycles at full amplitude, as the paper does


@dataclass(frozen=True)
class RunSettings:
    """How a run is made and what its log keeps.

    Attributes:
        rate_hz: ticks a second.
        faults: joint faults; those at 0 s hold from before the robot is armed.
        log_path: of the new log; None: ``runs/<time>_<label>.mcap``.
        log_frames: also log every frame of the wire.
        keep_stop: move nothing where the board is found stopped or in a fault.
        forward_speed_m_s: measured by hand; stored with the log.
        notes: stored with the log.
        about: further metadata of the log.
        course: steer for it: a heading, or a line.
        pose: where the robot is told from outside (``udp://127.0.0.1:9000``); None: the board tells, if anyone.
    """

    rate_hz: float = RATE_HZ
    faults: Sequence[JointFault] = ()
    log_path: Path | None = None
    log_frames: bool = False
    keep_stop: bool = False
    forward_speed_m_s: float | None = None
    notes: str | None = None
    about: Mapping[str, object] = field(default_factory=dict)
    course: Course | None = None
    pose: UdpAddress | None = None


@dataclass(frozen=True)
class RecordedRun:
    """A run that was made, and its log.

    Attributes:
        result: how it went.
        log_path: its log; a run that was interrupted before its first set-point has none.
        forward_speed_m_s: over the last cycles, from the logged pose; None where there is none, or too little.
        doubts: what its readings say of the robot's wiring, in words: channels that are dead or swapped.
        asked_late: whether its end was asked for when the motion was over, while the log was closed. This run could not
            obey it any more: it is meant for whatever would follow.
    """

    result: RunResult
    log_path: Path
    forward_speed_m_s: float | None = None
    doubts: tuple[str, ...] = ()
    asked_late: bool = False

    @property
    def ended(self) -> str:
        """``finished`` or ``interrupted``."""
        return self.result.ended

    @property
    def progress(self) -> Progress:
        """Ticks, losses, tracking error so far."""
        return self.result.progress

    def read(self) -> Run:
        """The samples of the log. Raises: LogError: there is none, or it cannot be read."""
        return read_log(self.log_path).to_run()


def check_run(robot: Robot, plan: RunPlan, settings: RunSettings) -> None:
    """All that can be checked without a board.

    Raises:
        BadInputError: rate, limits, motion or faults that the run would refuse.
        LogError: the log's name is taken, or cannot be one.
    """
    check_rate(settings.rate_hz)
    check_limits(robot)
    if plan.joints != robot.joints:
        raise BadInputError(
            f"the motion is one of {plan.joints} joints, robot {robot.name!r} has {robot.joints}"
        )
    motion = plan.from_straight()
    check_motion(motion, robot)
    check_faults(settings.faults, robot, motion.duration_s)
    if settings.course is not None:
        check_course(settings.course, plan, robot)
    check_new_log(settings.log_path or new_log_path())


def record(
    board: Board,
    robot: Robot,
    plan: RunPlan,
    settings: RunSettings | None = None,
    attendant: Attendant | None = None,
) -> RecordedRun:
    """Make a run and log it. However it ends, the joints end relaxed or stopped, and the log is closed.

    The robot moves at once: whoever calls this has asked whether everyone is clear of it.

    Args:
        board: connected, see ``open_board``.
        robot: its limits hold.
        plan: what to do, see ``plan_run`` and ``plan_replay``.
        attendant: what else is done meanwhile; without one, ``snakebot stop`` finds the run.

    Raises:
        BadInputError: see ``check_run``; nothing has moved.
        LogError: the log cannot be made (nothing has moved), or not be written (the robot was ramped down).
        BoardFaultError: the board refused, faulted, rebooted or was stopped; or a stop was asked for when the motion
            was over, while the log was closed: the board is stopped then, and the log is whole.
        LostBoardError: the link or the board went away.
        HostLateError: this computer could not keep the tick.
    """
    settings = settings or RunSettings()
    attendant = attendant or Attendant(board.link.port)
    check_run(robot, plan, settings)
    with _poses(board, settings) as source:
        return _record(board, robot, plan, settings, attendant, source)


def _record(
    board: Board,
    robot: Robot,
    plan: RunPlan,
    settings: RunSettings,
    attendant: Attendant,
    source: PoseSource | None,
) -> RecordedRun:
    start_ns = time.time_ns()
    writer = RunWriter(
        settings.log_path or stamped_path(plan.label),
        robot,
        _metadata(board, plan, settings),
        or_numbered=settings.log_path is None,
        attachments=_attachments(),
        start_time_ns=start_ns,
        tap=attendant.tap,
    )
    loop = RunLoop(
        board,
        robot,
        plan.motion_from,
        rate_hz=settings.rate_hz,
        clock=board.clock,
        amplitude_rad=plan.amplitude_rad,
        settle_s=plan.settle_s,
        faults=settings.faults,
        recorder=writer,
        log_frames=settings.log_frames,
        start_time_ns=start_ns,
        keep_stop=settings.keep_stop,
        course=settings.course,
        pose_source=source,
    )
    with attendant.until_logged(loop):
        try:
            with attendant.while_running(loop, writer):
                result = loop.run()
        except BaseException as error:
            why = error if isinstance(error, SnakebotError) else type(error).__name__
            with contextlib.suppress(SnakebotError):  # what ended the run is told, not what became of its log
                _end_log(writer, loop, f"error: {why}", robot)
            raise
        finally:
            for host in sorted(board.neighbours.hosts):
                attendant.tell(f"another host ({host:08x}) spoke on the line of {board.where}")
        speed_m_s, doubts = _end_log(writer, loop, result.ended, robot)
    if loop.emergency_asked:
        # The joints are relaxed already. But whoever asked is told that it was obeyed: nothing may move until it is
        # cleared.
        stop_board(board.link, board.clock, StopReason.EXTERNAL)
        raise BoardFaultError(
            f"{board.where}: {fault_line(Fault.EMERGENCY_STOP)}; the motion was over, its log is {writer.path}"
        )
    late = loop.end_asked and result.ended == "finished"
    return RecordedRun(result, writer.path, speed_m_s, tuple(doubts), late)


@contextlib.contextmanager
def _poses(board: Board, settings: RunSettings) -> Iterator[PoseSource | None]:
    """Listen where poses are to come from.

    Raises:
        BadInputError: that cannot be.
    """
    if settings.pose is None:
        yield None
        return
    from snakebot.steering.pose_udp import UdpPoses

    if isinstance(board.clock, VirtualClock):
        raise BadInputError(f"--pose {settings.pose} comes in real time: leave out --fast")
    source = UdpPoses(settings.pose, board.clock.now_s)
    try:
        yield source
    finally:
        source.close()


def _metadata(board: Board, plan: RunPlan, settings: RunSettings) -> dict[str, Any]:
    from firmware_protocol.catalogue import catalogue_hash
    from snakebot import __version__

    assert board.info is not None, "the board is not connected"
    metadata = {
        "gait": gait_to_mapping(plan.gait) if plan.gait is not None else None,
        "ramp_s": plan.ramp_s,
        "settle_s": plan.settle_s if plan.settle_s != plan.ramp_s else None,
        "lifted": plan.lifted or None,
        "rate_hz": settings.rate_hz,
        "port": board.link.port,
        "faults": [str(fault) for fault in settings.faults],
        "simulated": board.info.simulated,
        "virtual_time": isinstance(board.clock, VirtualClock),
        "forward_speed_m_s": settings.forward_speed_m_s,
        "notes": settings.notes,
        "course": settings.course.about() if settings.course is not None else None,
        "pose_source": str(settings.pose) if settings.pose is not None else None,
        "board": asdict(board.info),
        "catalogue_hash": f"{catalogue_hash():08x}",
        "snakebot_version": __version__,
        "python_version": platform.python_version(),
        "platform": platform.platform(),
        **board.link.about(),
        **plan.about,
        **settings.about,
    }
    return {key: value for key, value in metadata.items() if value is not None}


def _attachments() -> dict[str, bytes]:
    from firmware_protocol.catalogue import dbc_text

    return {"snakebot.dbc": dbc_text().encode()}


def _end_log(writer: RunWriter, loop: RunLoop, ended: str, robot: Robot) -> tuple[float | None, list[str]]:
    """Close the log, or forget it where no set-point was sent.

    Returns:
        The steady speed, m/s, where it is known, and what the readings say of the robot's wiring.
    """
    from snakebot.analysis.channels import channel_doubts

    if not loop.progress.ticks:
        writer.discard()
        return None, []
    speed_m_s: float | None = None
    doubts: list[str] = []
    try:
        run = _read_back(writer)
        if run is not None:
            speed_m_s = _steady_speed(run)
            doubts = [doubt.text for doubt in channel_doubts(run, robot)]
        writer.add_metadata({"ended": ended, "steady_speed_m_s": speed_m_s})
        if doubts:
            writer.add_metadata({"doubts": doubts})
        if (standstill := loop.progress.standstill).times:
            writer.add_metadata({"standstill": asdict(standstill)})
    finally:
        writer.close()
    return speed_m_s, doubts


def _read_back(writer: RunWriter) -> Run | None:
    """What has been logged so far; None where it cannot be read: the run does not fail by it."""
    writer.flush()
    try:
        return read_log(writer.part_path).to_run()
    except SnakebotError:  # nothing that was recorded, or a disk that fails
        return None


def _steady_speed(run: Run) -> float | None:
    """Forward speed over the last cycles, m/s, from the logged pose; None where there is none, or too little."""
    from snakebot.analysis.speed import forward_speed

    if run.pose is None or run.gait is None or not math.isfinite(run.gait.period_s):
        return None
    unsteady_s = settle_s(run.metadata)
    period = run.gait.period_s
    start, end = float(run.t_s[0]) + unsteady_s, float(run.t_s[-1]) - unsteady_s
    cycles = math.floor((end - start) / period * _STEADY_SHARE + 1e-6)
    if cycles < 1:
        return None
    speed = forward_speed(run.t_s, run.pose, end - cycles * period, end, period)
    return None if speed is None else round(speed.forward_m_s, 6)
