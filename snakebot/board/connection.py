"""One end of the link to a board: frames out, frames in, and the picture of the board that they give."""

from __future__ import annotations

import math
import secrets
from collections.abc import Sequence
from enum import Enum, auto
from typing import TYPE_CHECKING

from firmware_protocol import catalogue as msg
from firmware_protocol.assembly import Sample, SampleAssembler, sample_ids
from firmware_protocol.catalogue import Fault, Message, Mode, Result, StopReason, decode, encode
from firmware_protocol.checks import out_of_range, said_by_boards
from firmware_protocol.frame import Frame, ProtocolError
from firmware_protocol.framing import Packed
from snakebot.board.boardclock import BoardClock
from snakebot.board.faults import LATCHED, fault_line
from snakebot.board.handshake import Handshake
from snakebot.board.neighbours import Beat, Neighbours
from snakebot.board.readings import BoardInfo, OtherHost, PoseReading, Reading, Received, reading_of
from snakebot.board.requests import Requests
from snakebot.board.setpoints import Numbering
from snakebot.board.traffic import Traffic
from snakebot.board.wire_limits import LimitsInForce
from snakebot.clock import Clock
from snakebot.errors import BoardFaultError
from snakebot.links.base import Link

if TYPE_CHECKING:
    from firmware_protocol.whole_tick import AnswerReader

# A wait for frames is cut into pieces of this length: a stop from another thread, or from a signal handler, is seen
# between two of them. At 100 Hz and more no wait is longer.
_STOP_LOOK_S = 0.01


class Claim(Enum):
    """Whether the board is ours to drive."""

    NONE = auto()
    ASKED = auto()  # it may have heard us, and be armed
    HELD = auto()  # it has said that it is


class BoardConnection:
    """What has passed between this host and one board, and what the board is and does by that.

    Reading goes on to the end of what has come in; only then is what was found in it raised.
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
        self.latch: int | None = None  # number of the stop or fault that the board reported last
        self.found_latch: int | None = None  # of the one that it was in when we connected
        self.boot_id: int | None = None
        self.last_reading: Reading | None = None
        self.supply: msg.Supply | None = None
        self.counters: msg.Counters | None = None
        self.board_clock = BoardClock()
        self.unreadable = 0  # frames that were no message of the catalogue
        self.traffic = Traffic()
        self.neighbours = Neighbours(self.host)
        self._assembler: SampleAssembler | None = None
        self._sample_ids = sample_ids()
        self._reader: AnswerReader | None = None
        self._positions: dict[int, msg.PosePosition] = {}
        self._handshake = Handshake(self.where)
        self._requests = Requests(self.where)
        self._limits = LimitsInForce(self.where)
        self._pings: dict[int, float] = {}
        self._numbering = Numbering()
        self._heartbeats = 0
        self._heartbeat_due_s = -math.inf
        self._heard_s = clock.now_s()
        self._claim = Claim.NONE
        self._not_ours = 0  # heartbeats in a row that say we do not hold the board that we have armed
        self._stop_wanted: StopReason | None = None
        self._listened: tuple[float, Sequence[Frame]] | None = None  # come, and not taken in yet
        self._received: list[Received] = []  # read, and not handed out yet
        self._connecting = True
        self._trouble: BoardFaultError | None = None  # found while reading; raised when all is taken in

    @property
    def _watchdog_ms(self) -> int | None:
        return None if self.info is None else self.info.watchdog_ms

    @property
    def claimed(self) -> bool:
        """Whether we may have it armed: until then, and once it is disarmed or stopped, it is not ours to stop."""
        return self._claim is not Claim.NONE

    @property
    def lossy(self) -> bool:
        """Whether anything has got lost or damaged on this line so far."""
        return self._requests.repeated + self.unreadable + self.link.statistics.corrupt > 0

    def quicken(self) -> None:
        """From now on whole ticks are written and read by compiled code; the board must be connected."""
        # Brings the compiler in: only who runs a tick needs it.
        from firmware_protocol.whole_tick import AnswerReader

        assert self.info is not None
        self.link.quicken()
        self._numbering.quicken(self.info.joints)
        self._reader = AnswerReader(self.info.joints)

    def emergency_stop(self, reason: StopReason = StopReason.USER) -> None:
        """Send the emergency stop three times over: it is not acknowledged, and no wire is perfect.

        The board may hear us although we do not hear it.
        """
        self._claim = Claim.NONE
        self._requests.forget()
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
            raise BoardFaultError(f"{self.where}: {fault_line(Fault.EMERGENCY_STOP)}")

    def recent_traffic(self) -> list[str]:
        """The last frames, decoded, oldest first: what to look at after a failure."""
        return self.traffic.lines()

    def heard(self) -> list[Received]:
        """What has been read and not been handed out yet. Reads nothing, raises nothing."""
        received, self._received = self._received, []
        return received

    def _send(self, messages: Sequence[Message]) -> None:
        self._send_frames([encode(message) for message in messages])

    def _send_frames(self, frames: Sequence[Frame]) -> None:
        self.traffic.note("tx", self.clock.now_s(), frames)
        self.link.send(frames)

    def await_answer(self, timeout_s: float) -> None:
        """Wait up to ``timeout_s`` for the next frames and keep them, with their time, for whatever reads next.

        For a loop that has work to do after a set-point: the processor is the wire's until the answer is here, and the
        answer does not wait for that work either.

        Raises:
            LostBoardError: the link is gone.
            BoardFaultError: a stop was asked for meanwhile.
        """
        if self._listened is None and (frames := self._wait(timeout_s)):
            self._listened = self.clock.now_s(), frames

    def _read(self, timeout_s: float) -> None:
        """Take in what comes, all of it; then raise what was found in it."""
        if self._listened is not None:
            self._stop_if_wanted()
            (now, frames), self._listened = self._listened, None
        else:
            frames = self._wait(timeout_s)
            now = self.clock.now_s()
        self.traffic.note("rx", now, frames)
        for frame in () if self._take_whole(frames, now) else frames:
            try:
                item = self._take_frame(frame, now)
            except ProtocolError:
                self.unreadable += 1
                continue
            if item is not None:
                self._received.append(item)
        trouble, self._trouble = self._trouble, None
        if trouble is not None:
            raise trouble
        if repeated := self._requests.due(now):
            self._send(repeated)

    def _take_whole(self, frames: Sequence[Frame], now: float) -> bool:
        """Take in what is one whole answer to a set-point; False: it is not, or something unfinished waits."""
        if self._reader is None or not isinstance(frames, Packed):
            return False
        assert self._assembler is not None
        answer = self._reader.read(frames.data) if self._assembler.idle else None
        if answer is None:
            return False
        self._heard_s = now
        reading = self._sampled(answer.sample, now)
        if reading is not None:
            self._received.append(reading)
        if answer.pose is not None:
            self._received.append(PoseReading(answer.sample.state.sample, *answer.pose))
        return True

    def _wait(self, timeout_s: float) -> Sequence[Frame]:
        """The frames that come first, after at most so long; a stop that is asked for meanwhile does not wait."""
        deadline_s = self.clock.now_s() + timeout_s
        while True:
            self._stop_if_wanted()
            frames = self.link.receive(min(timeout_s, _STOP_LOOK_S))
            if frames or timeout_s <= _STOP_LOOK_S:
                return frames
            # A piece that ends late is not waited for again; one that a link cuts short does not add up to for ever.
            timeout_s = max(0.0, min(timeout_s - _STOP_LOOK_S, deadline_s - self.clock.now_s()))

    def _take_frame(self, frame: Frame, now: float) -> Received | None:
        """Raises: ProtocolError: a frame that is no message, or has values that no board may report."""
        if frame.id in self._sample_ids and self._assembler is not None:
            sample = self._assembler.take(frame)
            self._heard_s = now
            return None if sample is None else self._sampled(sample, now)
        message = decode(frame)
        if isinstance(message, msg.JointSupply | msg.JointLimits) and (wrong := out_of_range(message)):
            raise ProtocolError(wrong)
        if type(message) in said_by_boards() and self._is_ours(message):
            self._heard_s = now
        return self._take(message, now)

    def _is_ours(self, message: Message) -> bool:
        """Not another board's, as far as the message can tell."""
        return self.boot_id is None or getattr(message, "boot_id", self.boot_id) == self.boot_id

    def _take(self, message: Message, now: float) -> Received | None:
        """Bring the picture of the board up to date; hand on what a caller wants to see."""
        match message:
            case msg.PosePosition():
                self._positions[message.sample] = message
                if len(self._positions) > 8:
                    del self._positions[next(iter(self._positions))]
            case msg.PoseMotion():
                position = self._positions.pop(message.sample, None)
                if position is not None:
                    return PoseReading(
                        message.sample, position.x_m, position.y_m, message.heading_rad, message.speed_m_s
                    )
            case msg.BoardHeartbeat():
                self._beat(message)
            case msg.Acknowledge():
                self._answered(message)
            case msg.Pong():
                sent = self._pings.pop(message.nonce, None)
                if sent is not None:
                    self.board_clock.round_trip(sent, now, self.board_clock.unwrap(message.board_time_us))
            case msg.FaultEvent():
                self.latch = message.number
                self._fault(message.code, message.joint, message.detail)
                return message
            case msg.Supply():
                self.supply = message
                return message
            case msg.Counters():
                self.counters = message
                return message
            case msg.JointSupply():
                return message
            case msg.JointLimits():
                self._limits.take(message)
            case msg.InfoProtocol() | msg.InfoFirmware() | msg.InfoSerial():
                if self._connecting:
                    self._handshake.take(message)
            case msg.HostHeartbeat():
                return OtherHost(message.host) if self.neighbours.host(message.host) else None
            case _:
                pass  # another host's frames on a shared bus
        return None

    def _sampled(self, sample: Sample, now: float) -> Reading | None:
        if self.info is None:
            return None
        board_time_us = self.board_clock.unwrap(sample.state.board_time_us)
        self.mode = sample.state.mode
        self.last_reading = reading_of(sample, self.info.counts_per_rev, board_time_us, now)
        return self.last_reading

    def _answered(self, answer: msg.Acknowledge) -> None:
        request = self._requests.answered(answer)
        if request is None:
            return
        self.mode = answer.mode
        to_arm = isinstance(request.message, msg.ModeRequest) and request.message.mode is Mode.ARMED
        if answer.result is not Result.OK:
            if to_arm or answer.result is Result.HELD or answer.mode in LATCHED:
                self._claim = Claim.NONE
            holder = self.holder if self.holder != self.host else 0
            self._fail(self._requests.refusal(request, answer, holder, self._watchdog_ms))
        elif to_arm:
            self._claim = Claim.HELD
            self._limits.begin()

    def _fail(self, error: BoardFaultError) -> None:
        """The first of what is found counts; it is raised when everything that has come in is taken."""
        self._trouble = self._trouble or error

    def _beat(self, beat: msg.BoardHeartbeat) -> None:
        whose = Beat.OURS if self.boot_id is None else self.neighbours.board(beat.boot_id, self.boot_id)
        if whose is Beat.SECOND_BOARD:
            self._fail(
                BoardFaultError(
                    f"{self.where}: two boards speak on this line (boot {self.boot_id:04x} and "
                    f"{self.neighbours.stranger:04x}): leave one board on it, then start again"
                )
            )
        elif whose is Beat.REBOOTED:
            self._claim = Claim.NONE
            self.mode = beat.mode
            self._fail(
                BoardFaultError(
                    f"{self.where}: the board has rebooted (boot {self.boot_id:04x}, now {beat.boot_id:04x}): "
                    "its joints are without power; check its supply, then start again"
                )
            )
        if whose is Beat.STRANGE or whose is Beat.REBOOTED:
            return
        self.mode, self.fault, self.holder = beat.mode, beat.fault, beat.holder
        self._check_that_it_is_ours(beat)
        if beat.mode in LATCHED:
            self._fault(beat.fault, 0)

    def _check_that_it_is_ours(self, beat: msg.BoardHeartbeat) -> None:
        """One beat may be from before we armed it."""
        ours = beat.mode in LATCHED or beat.holder == self.host
        self._not_ours = 0 if ours or self._claim is not Claim.HELD else self._not_ours + 1
        if self._not_ours > 1:
            self._claim = Claim.NONE
            now = f"host {beat.holder:08x} holds it" if beat.holder else "it is disarmed"
            self._fail(
                BoardFaultError(
                    f"{self.where}: the board is no longer ours: {now}: "
                    "it was reset, or another host took it over"
                )
            )

    def _fault(self, code: Fault, joint: int, detail: int = 0) -> None:
        self.fault = code
        self.mode = Mode.STOPPED if code is Fault.EMERGENCY_STOP else Mode.FAULT
        if self._claim is not Claim.NONE:
            self._claim = Claim.NONE
            line = fault_line(code, joint, detail, watchdog_ms=self._watchdog_ms)
            self._fail(BoardFaultError(f"{self.where}: {line}"))
