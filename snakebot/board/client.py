"""One board at the other end of a link: what the host asks of it and what it has said."""

from __future__ import annotations

import math
import secrets
from collections import deque
from collections.abc import Callable, Sequence

from firmware_protocol import catalogue as msg
from firmware_protocol.assembly import SampleAssembler, setpoint_messages, to_wire
from firmware_protocol.catalogue import Fault, JointMode, Message, Mode, StopReason, decode, encode
from firmware_protocol.frame import Frame, ProtocolError
from snakebot.board.boardclock import BoardClock
from snakebot.board.handshake import Handshake
from snakebot.board.limits import wire_limits
from snakebot.board.readings import BoardInfo, Pose, Reading, Received
from snakebot.board.requests import Requests
from snakebot.clock import Clock
from snakebot.errors import BadInputError, BoardFaultError, LostBoardError, NoBoardError
from snakebot.links.base import Link
from snakebot.robot import Robot

HANDSHAKE_S = 2.0
FIRST_SAMPLE_S = 5.0  # a sample of many joints is many frames: on a bad line few are whole
HEARTBEAT_S = 0.1
SILENCE_S = 0.5  # a board beats ten times a second: after this long without a frame it is lost
_TRAFFIC_KEPT = 40


FrameListener = Callable[[str, float, Frame], None]  # "tx" or "rx", host clock, frame


class Board:
    """A board behind a link.

    The constructor does not speak; ``connect`` does the handshake. Set-points are sent and forgotten; requests are
    repeated until they are acknowledged. ``poll`` must be called often: it reads, keeps the heartbeat, and raises when
    the board is gone, has rebooted, or has entered a fault while it was armed.
    """

    def __init__(self, link: Link, clock: Clock, host: int | None = None) -> None:
        self.link = link
        self.clock = clock
        self.where = link.port.removesuffix(":")  # how messages name this board
        self.host = host if host is not None else secrets.randbelow(0xFFFFFFFF) + 1
        self.info: BoardInfo | None = None
        self.mode: Mode | None = None
        self.fault = Fault.NONE
        self.holder = 0
        self.boot_id: int | None = None
        self.last_reading: Reading | None = None
        self.supply: msg.Supply | None = None
        self.counters: msg.Counters | None = None
        self.board_clock = BoardClock()
        self.unreadable = 0  # frames that were no message of the catalogue
        self.on_frame: FrameListener | None = None
        self._assembler: SampleAssembler | None = None
        self._positions: dict[int, msg.PosePosition] = {}
        self._handshake = Handshake(self.where)
        self._requests = Requests(self.where)
        self._pings: dict[int, float] = {}
        self._sequence = secrets.randbelow(0x10000)
        self._heartbeats = 0
        self._heartbeat_due_s = -math.inf
        self._heard_s = clock.now_s()
        self._armed = False  # by us, and not yet disarmed: a fault is then an error
        self._not_ours = 0  # heartbeats in a row that say we do not hold the board that we have armed
        self._stop_wanted: StopReason | None = None
        self._traffic: deque[tuple[str, float, Frame]] = deque(maxlen=_TRAFFIC_KEPT)

    # -- handshake ---------------------------------------------------------------------------------------------------

    def connect(self, timeout_s: float = HANDSHAKE_S) -> BoardInfo:
        """Ask the board who it is, compare versions and catalogues, and wait for the first sample.

        Raises:
            NoBoardError: nobody answers, or the two ends do not speak the same catalogue (both sides are named).
        """
        deadline = self.clock.now_s() + timeout_s
        ask_s = -math.inf
        while (info := self._handshake.board()) is None:
            now = self.clock.now_s()
            if now >= deadline:
                raise self._handshake.nobody(timeout_s, self.link.statistics, self.unreadable)
            if now >= ask_s:
                self._send([msg.InfoRequest(self.host)])
                ask_s = now + 0.1
            self._read(min(0.05, deadline - now))
        self.info, self.boot_id = info, info.boot_id
        self._assembler = SampleAssembler(info.joints)
        for _ in range(4):
            self.ping()
        deadline = max(deadline, self.clock.now_s() + FIRST_SAMPLE_S)
        while self.last_reading is None or self.mode is None:
            if self.clock.now_s() >= deadline:
                raise NoBoardError(f"{self.where}: the board answers, but sends no joint angles")
            self._read(0.05)
        return info

    # -- requests ----------------------------------------------------------------------------------------------------

    def arm(self) -> None:
        """Power the servos where the joints are; from now on set-points are executed, and must keep coming.

        Raises:
            BoardFaultError: the board refuses: another host holds it, or it is stopped or in a fault.
        """
        self._request(lambda token: msg.ModeRequest(token, Mode.ARMED, self.host), "to arm")
        self._armed = True

    def hold(self) -> None:
        """Freeze the joints where they are, powered. Asked four times over: nothing feeds the watchdog meanwhile."""
        self._request(lambda token: msg.ModeRequest(token, Mode.HOLDING, self.host), "to hold", copies=4)

    def disarm(self) -> None:
        """Relax: the servos lose power. Also clears a fault or an emergency stop."""
        self._armed = False
        self._request(lambda token: msg.ModeRequest(token, Mode.DISARMED, self.host), "to disarm")

    def emergency_stop(self, reason: StopReason = StopReason.USER) -> None:
        """Send the emergency stop three times over: it is not acknowledged, and no wire is perfect."""
        self._armed = False
        self.mode = Mode.STOPPED
        for _ in range(3):
            self._send([msg.EmergencyStop(reason, self.host)])

    def request_emergency_stop(self, reason: StopReason = StopReason.USER) -> None:
        """Have the emergency stop sent by whoever speaks to the board now, before anything else; that one then raises.

        For signal handlers and other threads.
        """
        self._stop_wanted = reason

    def _stop_if_wanted(self) -> None:
        if self._stop_wanted is not None:
            reason, self._stop_wanted = self._stop_wanted, None
            self.emergency_stop(reason)
            raise BoardFaultError(f"{self.where}: {_FAULT_LINES[Fault.EMERGENCY_STOP]}")

    def disarm_unheard(self) -> None:
        """Relax, three times over and without waiting: the board may hear us although we do not hear it."""
        self._armed = False
        self._send([msg.ModeRequest(0, Mode.DISARMED, self.host)] * 3)

    @property
    def lossy(self) -> bool:
        """Whether anything has got lost or damaged on this line so far."""
        return self._requests.repeated + self.unreadable + self.link.statistics.corrupt > 0

    def set_joint_mode(
        self, joint: int, mode: JointMode, angle_rad: float = 0.0, *, wait: bool = True
    ) -> None:
        """Make a joint (from 1) active, free or rigid (at ``angle_rad``, or where it is with RIGID_HERE).

        With ``wait=False`` the answer is awaited by the following ``poll`` calls, which then raise what this would.
        """
        self._request(
            lambda token: msg.JointModeRequest(token, joint, mode, to_wire(angle_rad), self.host),
            f"to make joint {joint} {mode.name.lower()}",
            wait,
        )

    def set_limits(self, robot: Robot) -> None:
        """Hand the robot's angle, speed and acceleration limits to the board.

        Raises:
            BadInputError: a limit that the wire cannot carry; the board has been told none.
        """
        for kind, joint, value in list(wire_limits(robot)):
            self._request(
                lambda token, k=kind, j=joint, v=value: msg.LimitRequest(token, j, k, v, self.host),  # type: ignore[misc]
                f"the {kind.name.lower()} limit {value:.4g} of joint {joint}",
            )

    def set_trim(self, joint: int, trim_rad: float) -> None:
        """Add a trim to a joint's set-point before it becomes a servo pulse. Only while disarmed."""
        self._request(
            lambda token: msg.TrimRequest(token, joint, to_wire(trim_rad), self.host),
            f"the trim of joint {joint}",
        )

    def set_zero(self, joint: int, zero_counts: int) -> None:
        """Take this encoder count as zero. Only while disarmed."""
        self._request(
            lambda token: msg.ZeroRequest(token, joint, zero_counts, self.host), f"the zero of joint {joint}"
        )

    def _request(self, make: Callable[[int], Message], what: str, wait: bool = True, copies: int = 1) -> None:
        self._stop_if_wanted()
        token, message = self._requests.make(make, what, self.clock.now_s())
        self._send([message] * copies)
        while wait and (repeat_s := self._requests.waits_for(token)) is not None:
            self._read(max(1e-4, repeat_s - self.clock.now_s()))

    # -- streaming ---------------------------------------------------------------------------------------------------

    def send_setpoints(
        self, angles_rad: Sequence[float], interval_s: float, copies: int = 1
    ) -> tuple[int, tuple[float, ...]]:
        """Send one tick. It is never repeated later: the next tick supersedes it.

        On a line that loses frames ``copies`` go out at once: the board executes the first that is whole, from frames
        of either, and drops the rest as stale.

        Returns:
            The sequence number, and the angles as the wire carries them.

        Raises:
            ProtocolError: an angle is not a number or beyond what the wire carries (a fault of the caller).
            LostBoardError: the link is gone.
        """
        self._sequence = (self._sequence + 1) & 0xFFFF
        self._send(setpoint_messages(self._sequence, angles_rad, interval_s) * copies)
        return self._sequence, tuple(to_wire(angle) for angle in angles_rad)

    def ping(self) -> None:
        """Ask for the board's clock; the answer is taken in by ``poll``."""
        nonce = secrets.randbits(32)
        self._pings[nonce] = self.clock.now_s()
        if len(self._pings) > 16:
            del self._pings[next(iter(self._pings))]
        self._send([msg.Ping(nonce)])

    def poll(self, timeout_s: float = 0.0) -> list[Received]:
        """Read what has come in, waiting up to ``timeout_s`` for the first frame; keep the heartbeat.

        Raises:
            LostBoardError: the link is gone, or the board has been silent for half a second.
            BoardFaultError: the board rebooted, or entered a fault or was stopped while we had it armed.
        """
        now = self.clock.now_s()
        if now >= self._heartbeat_due_s:
            self._heartbeat_due_s = now + HEARTBEAT_S
            self._heartbeats = (self._heartbeats + 1) & 0xFFFF
            self._send([msg.HostHeartbeat(self.host, self._heartbeats)])
            self.ping()
        received = self._read(timeout_s)
        if self.clock.now_s() - self._heard_s > SILENCE_S:
            raise LostBoardError(
                f"{self.where}: the board has been silent for {SILENCE_S:g} s: "
                "its watchdog has stopped the joints; check cable and supply, then start again"
            )
        return received

    def _send(self, messages: Sequence[Message]) -> None:
        frames = [encode(message) for message in messages]
        now = self.clock.now_s()
        for frame in frames:
            self._note("tx", now, frame)
        self.link.send(frames)

    def _note(self, direction: str, now_s: float, frame: Frame) -> None:
        self._traffic.append((direction, now_s, frame))
        if self.on_frame is not None:
            self.on_frame(direction, now_s, frame)

    def _read(self, timeout_s: float) -> list[Received]:
        received: list[Received] = []
        self._stop_if_wanted()
        frames = self.link.receive(timeout_s)
        now = self.clock.now_s()
        if repeated := self._requests.due(now):
            self._send(repeated)
        for frame in frames:
            self._note("rx", now, frame)
            try:
                message = decode(frame)
            except ProtocolError:
                self.unreadable += 1
                continue
            self._heard_s = now
            item = self._take(message, now)
            if item is not None:
                received.append(item)
        return received

    def _take(self, message: Message, now: float) -> Received | None:
        """Bring the picture of the board up to date; hand on what a caller wants to see."""
        match message:
            case msg.State() | msg.Measured() | msg.Applied():
                return self._sample(message, now)
            case msg.PosePosition():
                self._positions[message.sample] = message
                if len(self._positions) > 8:
                    del self._positions[next(iter(self._positions))]
            case msg.PoseMotion():
                position = self._positions.pop(message.sample, None)
                if position is not None:
                    return Pose(
                        message.sample, position.x_m, position.y_m, message.heading_rad, message.speed_m_s
                    )
            case msg.BoardHeartbeat():
                self._beat(message)
            case msg.Acknowledge():
                mode = self._requests.answered(message)
                self.mode = self.mode if mode is None else mode
            case msg.Pong():
                sent = self._pings.pop(message.nonce, None)
                if sent is not None:
                    self.board_clock.round_trip(sent, now, self.board_clock.unwrap(message.board_time_us))
            case msg.FaultEvent():
                self._fault(message.code, message.joint)
                return message
            case msg.Supply():
                self.supply = message
                return message
            case msg.Counters():
                self.counters = message
                return message
            case msg.JointSupply():
                return message
            case msg.InfoProtocol() | msg.InfoFirmware() | msg.InfoSerial():
                self._handshake.take(message)
            case _:
                pass  # another host's frames on a shared bus
        return None

    def _sample(self, message: msg.State | msg.Measured | msg.Applied, now: float) -> Reading | None:
        if self._assembler is None or self.info is None:
            return None
        sample = self._assembler.add(message)
        if sample is None:
            return None
        rad_per_count = 2 * math.pi / self.info.counts_per_rev
        self.mode = sample.state.mode
        self.last_reading = Reading(
            sequence=sample.state.sequence,
            sample=sample.state.sample,
            mode=sample.state.mode,
            received_s=now,
            board_time_us=self.board_clock.unwrap(sample.state.board_time_us),
            measured_rad=tuple(math.nan if c is None else c * rad_per_count for c in sample.measured_counts),
            applied_rad=sample.applied_rad,
        )
        return self.last_reading

    def _beat(self, beat: msg.BoardHeartbeat) -> None:
        if self.boot_id is not None and beat.boot_id != self.boot_id:
            self._armed = False
            self.mode = beat.mode
            raise BoardFaultError(
                f"{self.where}: the board has rebooted (boot {self.boot_id:04x}, now {beat.boot_id:04x}): "
                "its joints are without power; check its supply, then start again"
            )
        self.mode, self.fault, self.holder = beat.mode, beat.fault, beat.holder
        self._check_that_it_is_ours(beat)
        if beat.mode in (Mode.FAULT, Mode.STOPPED):
            self._fault(beat.fault, 0)

    def _check_that_it_is_ours(self, beat: msg.BoardHeartbeat) -> None:
        """One beat may be from before we armed it."""
        ours = beat.mode not in (Mode.DISARMED, Mode.ARMED, Mode.HOLDING) or beat.holder == self.host
        self._not_ours = 0 if ours or not self._armed else self._not_ours + 1
        if self._not_ours > 1:
            self._armed = False
            now = f"host {beat.holder:08x} holds it" if beat.holder else "it is disarmed"
            raise BoardFaultError(
                f"{self.where}: the board is no longer ours: {now}: it was reset, or another host took it over"
            )

    def _fault(self, code: Fault, joint: int) -> None:
        self.fault = code
        self.mode = Mode.STOPPED if code is Fault.EMERGENCY_STOP else Mode.FAULT
        if not self._armed:
            return
        self._armed = False
        where = f" on joint {joint}" if joint else ""
        raise BoardFaultError(f"{self.where}: {_FAULT_LINES[code]}{where}")

    def recent_traffic(self) -> list[str]:
        """The last frames, decoded, oldest first: what to look at after a failure."""
        lines = []
        for direction, at_s, frame in self._traffic:
            try:
                text = str(decode(frame))
            except ProtocolError as error:
                text = f"unreadable: {error}"
            lines.append(f"{at_s:12.6f} {direction} {frame} {text}")
        return lines

    def check_robot(self, robot: Robot) -> None:
        """Raises: BadInputError: the board is not this robot's (joints or encoder resolution differ)."""
        assert self.info is not None
        for what, ours, theirs in (
            ("joints", robot.joints, self.info.joints),
            ("encoder counts a turn", robot.encoder_counts_per_rev, self.info.counts_per_rev),
        ):
            if ours != theirs:
                raise BadInputError(
                    f"{self.where}: the board has {theirs} {what}, robot {robot.name!r} has {ours}: "
                    "give the robot's own description with --robot"
                )


_FAULT_LINES = {
    Fault.NONE: "the board reports a fault without a code",
    Fault.WATCHDOG: "the board's watchdog stopped the joints: no set-point reached it for 100 ms",
    Fault.EMERGENCY_STOP: "emergency stop: the joints are without power",
    Fault.SERVO: "the board reports a servo fault",
    Fault.UNDERVOLTAGE: "the board reports that the supply voltage is too low",
    Fault.OVERCURRENT: "the board reports too much current",
    Fault.OVERTEMPERATURE: "the board reports that it is too hot",
    Fault.ENCODER: "the board reports an encoder fault",
    Fault.INTERNAL: "the board reports an internal fault",
}
