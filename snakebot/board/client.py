"""One board at the other end of a link: what the host asks of it."""

from __future__ import annotations

import contextlib
import math
import secrets
from collections.abc import Callable, Sequence

from firmware_protocol import catalogue as msg
from firmware_protocol.assembly import SampleAssembler, to_wire
from firmware_protocol.catalogue import Fault, JointMode, Message, Mode
from snakebot.board.connection import BoardConnection, Claim
from snakebot.board.faults import LATCHED
from snakebot.board.handshake import Handshake
from snakebot.board.readings import BoardInfo, Received
from snakebot.board.setpoints import MadeSetpoint
from snakebot.board.wire_limits import wire_limits
from snakebot.errors import BadInputError, BoardFaultError, LostBoardError, NoBoardError
from snakebot.robot import Robot

HANDSHAKE_S = 2.0  # for a board to answer; chosen
FIRST_SAMPLE_S = 10.0  # a sample of many joints is many frames: on a bad line few are whole
HEARTBEAT_S = 0.1  # of a host that holds the board, which lets go after 1 s without (PROTOCOL.md)
SILENCE_S = 0.5  # a board beats ten times a second: after this long without a frame it is lost
_ANSWERS_S = 0.02  # after the handshake: a second board on the line answers too
_REPORT_S = 0.005  # all limits of an armed board have come by then, or some are lost
_REPORTS_SHARE = 0.6  # of the watchdog's time, the longest to get them: nothing feeds it meanwhile


class Board(BoardConnection):
    """A board behind a link.

    The constructor does not speak; ``connect`` does the handshake. Set-points are sent and forgotten; requests are
    repeated until they are acknowledged. ``poll`` must be called often: it reads, keeps the heartbeat, and raises when
    the board is gone, has rebooted, or has entered a fault while it was armed. What a request reads while it waits is
    handed out by the next ``poll``.
    """

    # -- handshake ---------------------------------------------------------------------------------------------------

    def connect(self, timeout_s: float = HANDSHAKE_S) -> BoardInfo:
        """Ask the board who it is, compare versions and catalogues, and wait for the first sample.

        Raises:
            NoBoardError: nobody answers, two boards do, or the two ends do not speak the same catalogue (both sides
                are named).
        """
        self._connecting, self._handshake = True, Handshake(self.where)
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
        self._assembler, self._reader = SampleAssembler(info.joints), None
        for _ in range(4):
            self.ping()
        others_s = self.clock.now_s() + _ANSWERS_S
        deadline = max(deadline, self.clock.now_s() + FIRST_SAMPLE_S)
        while not self._known() or self.clock.now_s() < others_s:
            if self.clock.now_s() >= deadline:
                raise NoBoardError(f"{self.where}: the board answers, but sends no joint angles")
            self._read(0.05 if not self._known() else max(1e-4, others_s - self.clock.now_s()))
        if self.neighbours.stranger is not None:
            self._wait_for_the_next_beat()
        self.found_latch = self.latch if self.mode in LATCHED else None
        self._connecting = False
        return info

    def _known(self) -> bool:
        """Angles and mode have come, and the number of the stop or fault that it is in."""
        named = self.mode is not None and (self.mode not in LATCHED or self.latch is not None)
        return named and self.last_reading is not None

    def _wait_for_the_next_beat(self) -> None:
        """A second boot id was heard: read on until it is known whether there are two boards."""
        end_s = self.clock.now_s() + 3 * HEARTBEAT_S
        try:
            while self.clock.now_s() < end_s:
                self._read(max(1e-4, end_s - self.clock.now_s()))
        except BoardFaultError as error:
            raise NoBoardError(str(error)) from None

    # -- requests ----------------------------------------------------------------------------------------------------

    def arm(self) -> None:
        """Power the servos where the joints are; from now on set-points are executed, and must keep coming.

        Raises:
            BoardFaultError: the board refuses (another host holds it, it is stopped or faulty), or the limits that it
                reports are not those that it was asked for; it is disarmed again.
        """
        self._claim = Claim.ASKED
        self._limits.forget_reports()
        self._ask_to_arm()
        try:
            self._wait_for_the_limits()
            self._limits.check()
        except BoardFaultError:
            with contextlib.suppress(BoardFaultError, LostBoardError):
                if self.claimed:
                    self.disarm()
            raise

    def _ask_to_arm(self) -> None:
        self._request(
            lambda token: msg.ModeRequest(token, Mode.ARMED, self.host),
            "to arm",
            copies=2 if self.lossy else 1,
        )

    def _wait_for_the_limits(self) -> None:
        """The board reports them after its answer, and again each time it is asked to arm."""
        assert self.info is not None
        end_s = self.clock.now_s() + _REPORTS_SHARE * self.info.watchdog_ms * 1e-3
        while True:
            until_s = self.clock.now_s() + _REPORT_S
            while self._limits.missing() and (left_s := until_s - self.clock.now_s()) > 0:
                self._read(max(1e-4, left_s))
            if not self._limits.missing() or self.clock.now_s() >= end_s:
                return
            self._ask_to_arm()

    def hold(self) -> None:
        """Freeze the joints where they are, powered. Asked four times over: nothing feeds the watchdog meanwhile."""
        self._request(lambda token: msg.ModeRequest(token, Mode.HOLDING, self.host), "to hold", copies=4)

    def disarm(self) -> None:
        """Relax: the servos lose power. A stop or a fault stays, and is raised.

        Raises:
            BoardFaultError: the board is stopped or in a fault, or another host holds it.
        """
        self._request(lambda token: msg.ModeRequest(token, Mode.DISARMED, self.host), "to disarm")
        self._claim = Claim.NONE

    def clear(self) -> None:
        """Leave the stop or fault in which ``connect`` found the board, and no newer one.

        Only for a run that a person has just started: whoever stopped the robot must not find it moving again.

        Raises:
            BoardFaultError: it was stopped again since.
        """
        number = self.found_latch
        assert number is not None, "the board was not stopped when it was connected"
        self._request(lambda token: msg.ClearRequest(token, number, self.host), "to clear the stop")
        self.fault = Fault.NONE

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
                f"to set the {kind.name.lower()} limit of joint {joint} to {value:.4g}",
            )
            self._limits.asked(joint, kind, value)

    def set_trim(self, joint: int, trim_rad: float) -> None:
        """Add a trim to a joint's set-point before it becomes a servo pulse. Only while disarmed."""
        self._request(
            lambda token: msg.TrimRequest(token, joint, to_wire(trim_rad), self.host),
            f"to set the trim of joint {joint} to {trim_rad:.4g} rad",
        )

    def set_zero(self, joint: int, zero_counts: int) -> None:
        """Take this encoder count as zero. Only while disarmed."""
        self._request(
            lambda token: msg.ZeroRequest(token, joint, zero_counts, self.host),
            f"to set the zero of joint {joint}",
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
        made = self.make_setpoint(angles_rad, interval_s)
        self.send_made(made, copies)
        return made.sequence, made.angles_rad

    def make_setpoint(self, angles_rad: Sequence[float], interval_s: float) -> MadeSetpoint:
        """What ``send_setpoints`` would send: a loop makes it before its deadline, and sends it then.

        Raises:
            ProtocolError: as ``send_setpoints``.
        """
        return self._numbering.make(angles_rad, interval_s)

    def send_made(self, made: MadeSetpoint, copies: int = 1) -> None:
        """Send the set-point that was made last. Raises: LostBoardError: the link is gone."""
        self._numbering.sent(made)
        self._send_frames(made.frames if copies == 1 else [*made.frames] * copies)

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
        self._read(timeout_s)
        if self._silent:  # or this computer stood still: what was said meanwhile waits in the line
            self._read(0.0)
        if self._silent:
            raise LostBoardError(
                f"{self.where}: the board has been silent for {SILENCE_S:g} s: "
                "its watchdog has stopped the joints; check cable and supply, then start again"
            )
        return self.heard()

    @property
    def _silent(self) -> bool:
        return self.clock.now_s() - self._heard_s > SILENCE_S

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
