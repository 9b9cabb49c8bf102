"""A host's hands on a board it knows nothing of: ask who it is, bring it into a mode, limit it, move its joints."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence

from firmware_protocol import catalogue as msg
from firmware_protocol.assembly import Sample, setpoint_messages
from firmware_protocol.catalogue import Fault, JointMode, LimitKind, Mode, Result
from snakebot.clock import Clock
from snakebot.conformance.exchange import Exchange
from snakebot.conformance.lab import Lab
from snakebot.conformance.violations import HostStalledError, ViolationError, expect
from snakebot.links.base import Link

LIMIT_STEP = 0.002  # one bit of a limit on the wire
MOST_LIMIT = ((1 << 17) - 1) * LIMIT_STEP  # what its 17 bits carry
_TIME_MASK = 0xFFFFFFFF  # the board's clock has 32 bits of us (PROTOCOL.md)


def passed_us(later: int, earlier: int) -> int:
    """Microseconds between two readings of the board's clock, across its wrap."""
    return (later - earlier) & _TIME_MASK


def growth(later: int, earlier: int) -> int:
    """By how much a counter of 16 bits has grown, across its wrap."""
    return (later - earlier) & 0xFFFF


class Bench(Exchange):
    """A board at the end of a link, and what a lab can do to it.

    Args:
        link: open; the caller closes it.
        clock: ``VirtualClock`` where the board lives on one.
        send_bytes: puts raw bytes on a serial line; None on CAN.
        reset: switches the board off and on; None where nobody can.
        lab: what else can be done to the board.
        tolerance_s: by how much this computer and the wire may blur a time.
        nudge_rad: how far a joint is moved at most.
    """

    def __init__(
        self,
        link: Link,
        clock: Clock,
        *,
        send_bytes: Callable[[bytes], None] | None = None,
        reset: Callable[[], None] | None = None,
        lab: Lab | None = None,
        tolerance_s: float = 0.02,
        nudge_rad: float = 0.05,
        seed: int = 0,
    ) -> None:
        super().__init__(link, clock)
        self.send_bytes = send_bytes
        self.reset = reset
        self.lab = lab or Lab()
        self.tolerance_s = tolerance_s
        self.stall_s = max(tolerance_s, 0.015)
        self.nudge_rad = nudge_rad
        self.draw = random.Random(seed)
        self.host, self.other = 0x5EED0001, 0x5EED0002
        self.info: msg.InfoProtocol | None = None
        self.firmware: msg.InfoFirmware | None = None
        self.sequence = 0
        self._built_in: dict[tuple[int, LimitKind], float] = {}
        self._tightened: set[tuple[int, LimitKind]] = set()
        self._turned: set[int] = set()  # joints whose mode was changed

    # -- state -------------------------------------------------------------------------------------------------------

    @property
    def joints(self) -> int:
        assert self.info is not None
        return self.info.joints

    @property
    def rad_per_count(self) -> float:
        assert self.firmware is not None
        return 2 * math.pi / self.firmware.counts_per_rev

    @property
    def simulated(self) -> bool:
        return bool(self.info and self.info.simulated)

    def can(self, need: str) -> bool:
        """Whether this bench has what a case needs: ``send_bytes``, ``reset``, or something of the lab."""
        return getattr(self if need in ("send_bytes", "reset") else self.lab, need) is not None

    def identify(self) -> tuple[msg.InfoProtocol, msg.InfoFirmware, msg.InfoSerial]:
        """The three answers to an InfoRequest."""
        for attempt in range(5):
            start = len(self.heard)
            self.send(msg.InfoRequest(self.host))
            try:
                serial = self.wait(msg.InfoSerial, 0.4)
            except ViolationError:
                if attempt == 4:
                    raise
                continue
            found = self.heard[start:]
            protocol = next((m for m in found if isinstance(m, msg.InfoProtocol)), None)
            firmware = next((m for m in found if isinstance(m, msg.InfoFirmware)), None)
            if protocol is not None and firmware is not None:
                self.info, self.firmware = protocol, firmware
                self.sample_joints(protocol.joints)
                return protocol, firmware, serial
        raise ViolationError(
            "InfoRequest must be answered by InfoProtocol, InfoFirmware and InfoSerial, all three"
        )

    def beat(self) -> msg.BoardHeartbeat:
        """The next heartbeat: the mode that the board says it is in."""
        return self.wait(msg.BoardHeartbeat, 0.5)

    def go(self, mode: Mode, host: int | None = None) -> msg.Acknowledge:
        return self.ask(msg.ModeRequest(self.token(), mode, self.host if host is None else host))

    def must_go(self, mode: Mode, host: int | None = None) -> None:
        answer = self.go(mode, host)
        expect(
            answer.result is Result.OK,
            f"{mode.name.lower()} was requested and answered {_shown(answer)}, not ok",
        )

    def stop(self) -> msg.FaultEvent:
        """An emergency stop, and the latch that it raises: the last one that comes before a ping's answer."""
        start = len(self.heard)
        self.send(msg.EmergencyStop())
        self.ping()
        events = [m for m in self.heard[start:] if isinstance(m, msg.FaultEvent)]
        expect(
            events and events[-1].code is Fault.EMERGENCY_STOP,
            "an emergency stop is answered by a FaultEvent",
        )
        return events[-1]

    def clear(self, number: int | None = None, host: int | None = None) -> msg.Acknowledge:
        """Ask the board to leave a latch; without a number the one that it reports now."""
        if number is None:
            number = self.wait(msg.FaultEvent, 0.5).number
        return self.ask(msg.ClearRequest(self.token(), number, self.host if host is None else host))

    def start_anew(self) -> None:
        """Switch the board off and on, where somebody can: what it said before is forgotten."""
        assert self.reset is not None
        self.reset()
        self.identify()
        self.begin()

    def fresh(self) -> None:
        """Disarmed, nobody's, joints active, limits as built in: how every case begins and ends."""
        if self.info is None:
            self.identify()
        self.make_safe()
        for joint in sorted(self._turned):
            self.ask(msg.JointModeRequest(self.token(), joint, JointMode.ACTIVE, 0.0, self.host))
        self._turned.clear()
        for joint, kind in sorted(self._tightened):
            self.ask(msg.LimitRequest(self.token(), joint, kind, self._built_in[joint, kind], self.host))
        self._tightened.clear()
        self.begin()

    def make_safe(self) -> None:
        """Disarm, by an emergency stop where another host holds the board; clear what it is stopped by."""
        if self.lab.fail is not None:
            self.lab.fail(Fault.NONE, 0, 0)
        answer = self.go(Mode.DISARMED)
        if answer.result is Result.HELD:
            self.stop()
        if answer.result in (Result.HELD, Result.FORBIDDEN):
            answer = self.clear()
        expect(answer.result is Result.OK, f"the board cannot be disarmed: it answers {_shown(answer)}")

    def enter(self, mode: Mode) -> None:
        """Bring a disarmed board into any mode."""
        if mode is Mode.STOPPED:
            self.stop()
        elif mode is not Mode.DISARMED:
            self.must_go(Mode.ARMED)
            if mode is Mode.HOLDING:
                self.must_go(Mode.HOLDING)
            elif mode is Mode.FAULT:
                self.wait(msg.FaultEvent, code=Fault.WATCHDOG)

    def set_joint_mode(
        self, joint: int, mode: JointMode, angle_rad: float = 0.0, host: int | None = None
    ) -> msg.Acknowledge:
        self._turned.add(joint)
        host = self.host if host is None else host
        return self.ask(msg.JointModeRequest(self.token(), joint, mode, round(angle_rad, 4), host))

    def set_limit(
        self, joint: int, kind: LimitKind, value: float, host: int | None = None
    ) -> msg.Acknowledge:
        """Set a limit; ``fresh`` puts the built-in one back."""
        self.built_in(joint, kind)
        self._tightened.add((joint, kind))
        host = self.host if host is None else host
        return self.ask(
            msg.LimitRequest(self.token(), joint, kind, round(value / LIMIT_STEP) * LIMIT_STEP, host)
        )

    def built_in(self, joint: int, kind: LimitKind) -> float:
        """The largest limit that the board accepts, found by halving. The board must be disarmed the first time."""
        if (joint, kind) not in self._built_in:
            below, above = 0, 1 << 17  # steps: accepted, refused
            while above - below > 1:
                middle = (below + above) // 2
                request = msg.LimitRequest(self.token(), joint, kind, middle * LIMIT_STEP, self.host)
                if self.ask(request).result is Result.OK:
                    below = middle
                else:
                    above = middle
            expect(below > 0, f"the board accepts no {kind.name.lower()} limit at all for joint {joint}")
            self._built_in[joint, kind] = below * LIMIT_STEP
            self.ask(msg.LimitRequest(self.token(), joint, kind, below * LIMIT_STEP, self.host))
        return self._built_in[joint, kind]

    def counters(self) -> msg.Counters:
        """Counters that include everything sent before this call.

        The board sends them once a second, so one that is on its way already does not count.
        """
        self.ping()
        return self.wait(msg.Counters, 1.6)

    def ping(self) -> msg.Pong:
        nonce = self.draw.getrandbits(32)
        self.send(msg.Ping(nonce))
        return self.wait(msg.Pong, nonce=nonce)

    # -- set-points --------------------------------------------------------------------------------------------------

    def sample(self) -> Sample:
        """The next complete sample."""
        start = len(self.samples)
        until_s = self.clock.now_s() + 0.5
        while len(self.samples) == start:
            self._hear(until_s)
            expect(
                self.clock.now_s() < until_s or len(self.samples) > start,
                "no complete sample within 0.5 s: State, then a Measured and an Applied for every group of joints",
            )
        return self.samples[start]

    def arm(self) -> list[float]:
        """Arm; the angles to start from (rad), as a host must."""
        here = list(self.sample().applied_rad)
        self.must_go(Mode.ARMED)
        return here

    def tick(self, angles_rad: Sequence[float], interval_s: float = 0.01, step: int = 1) -> int:
        """Send one set-point; its sequence number."""
        self.sequence = (self.sequence + step) & 0xFFFF
        self.send(*setpoint_messages(self.sequence, angles_rad, interval_s))
        return self.sequence

    def answered(self, sequence: int, within_s: float = 0.06) -> Sample | None:
        """The sample that answers a set-point, or None: it was not executed.

        Unasked samples repeat the last number, so the search begins with what has come since the case began.
        """
        until_s = self.clock.now_s() + within_s
        while True:
            for sample in self.samples:
                if sample.state.sequence == sequence:
                    return sample
            if self.clock.now_s() >= until_s:
                return None
            self._hear(until_s)

    def executed(
        self, angles_rad: Sequence[float], why: str, interval_s: float = 0.01, step: int = 1
    ) -> Sample:
        """Send one set-point that must be executed."""
        sample = self.answered(self.tick(angles_rad, interval_s, step))
        if sample is None:
            self.blame_the_watchdog()
            raise ViolationError(f"a set-point was not executed: {why}")
        return sample

    def blame_the_watchdog(self) -> None:
        """Raise if, by the board's own clock, we let 100 ms pass: what it did then proves nothing."""
        fed = [m for m in self.heard if isinstance(m, msg.State) and m.mode is Mode.ARMED]
        for event in self.heard:
            if isinstance(event, msg.FaultEvent) and event.code is Fault.WATCHDOG and fed:
                last = next(m for m in fed if m.sequence == fed[-1].sequence)  # later ones are unasked
                silent_us = passed_us(event.board_time_us, last.board_time_us)
                if silent_us >= 1000 * (self.firmware.watchdog_ms if self.firmware else 100) - 1000:
                    raise HostStalledError("the watchdog ran out between two set-points of the host")

    def refused(self, sequence: int, why: str) -> None:
        """A set-point that was sent must not have been executed.

        A ping goes after it: once that is answered, the set-point has been dealt with.
        """
        self.ping()
        for message in self.heard:
            if isinstance(message, msg.State) and message.sequence == sequence:
                raise ViolationError(f"a set-point was executed: {why}")

    def stream(
        self, seconds: float, target: Callable[[float], Sequence[float]], interval_s: float = 0.01
    ) -> list[tuple[int, list[float]]]:
        """Keep set-points coming on time; (sequence number, angles) of each."""
        start_s = self.clock.now_s()
        sent = []
        for index in range(1, round(seconds / interval_s) + 1):
            due_s = start_s + index * interval_s
            while self.clock.now_s() < due_s:
                self._hear(due_s)
            if self.clock.now_s() > due_s + self.stall_s:
                raise HostStalledError(f"a tick was {1e3 * (self.clock.now_s() - due_s):.0f} ms late")
            angles = list(target(index * interval_s))
            sent.append((self.tick(angles, interval_s), angles))
        self._hear(self.clock.now_s())
        return sent

    def stand_at(self, angles_rad: Sequence[float], seconds: float, why: str) -> Sample:
        """Stream one posture for a while; the sample that answers the last set-point, which must be executed."""
        last = self.answered(self.stream(seconds, lambda t: angles_rad)[-1][0])
        if last is None:
            raise ViolationError(f"{why} was not executed")
        return last

    def hold_heartbeat(self, seconds: float, host: int) -> None:
        """Let a host's heartbeat come for a while."""
        for number in range(round(seconds / 0.1)):
            self.send(msg.HostHeartbeat(host, number))
            self.listen(0.1)


def _shown(answer: msg.Acknowledge) -> str:
    return f"{answer.result.name.lower()} (mode {answer.mode.name.lower()}, detail {answer.detail})"
