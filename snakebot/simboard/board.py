"""A servo board that is not there: the protocol of PROTOCOL.md in front of simulated joints.

It does no input or output of its own and reads no clock: frames and times are handed in, frames come out. A transport
(``inprocess``, ``serve``) carries them.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from typing import Any

import snakebot
from firmware_protocol import catalogue as msg
from firmware_protocol.assembly import ANGLE_STEP_RAD, SHORT_MASK, sample_messages
from firmware_protocol.catalogue import Fault, JointMode, Message, Mode, decode, encode, frame_id
from firmware_protocol.frame import Frame, ProtocolError
from snakebot.errors import BadInputError
from snakebot.robot import Robot
from snakebot.simboard.configuration import Configuration
from snakebot.simboard.modes import WATCHDOG_S, Expiry, ModeMachine
from snakebot.simboard.ownclock import OwnClock
from snakebot.simboard.plant import JointPlant
from snakebot.simboard.register import SetpointRegister

BEAT_S = 0.1  # heartbeats, and samples while nothing streams
COUNTERS_S = 1.0
MAX_DRIFT_PPM = 100_000.0
_EARLY_S = 1e-7  # a timer may run out this early: a year's clock resolves no better
_MASK16 = 0xFFFF
_WIRE_ANGLE_RAD = 32767 * ANGLE_STEP_RAD
_MAX_COUNTS_PER_REV = 0xFFFF  # what InfoFirmware carries


class SimBoard:
    """One simulated board. It is reset by the first call that brings a time.

    Args:
        robot: what is behind the board; its limits are the board's built-in ones.
        specs: unmodelled effects to inject (``snakebot.effects.EffectSpec``).
        seed: of everything random in the plant.
        clock_offset_us: what the board's clock shows at a reset.
        drift_ppm: by how much the board's clock runs fast.
        serial_number: as the board reports it.
        boot_seed: makes boot ids repeatable; without it they come from the system, so that a process that is started
            again is seen as a reset.
        start_rad: joint angles at the start, (joints,); straight without it. The robot is at rest.
        plant: stands in for ``snakebot.effects.Plant``.

    Raises:
        BadInputError: the protocol cannot carry this robot (more than 16 joints, more than 65535 counts a turn),
            or a value that no board has.
    """

    def __init__(
        self,
        robot: Robot,
        specs: Sequence[Any] = (),
        seed: int = 0,
        *,
        clock_offset_us: int = 0,
        drift_ppm: float = 0.0,
        serial_number: int = 1,
        boot_seed: int | None = None,
        start_rad: Sequence[float] | None = None,
        plant: JointPlant | None = None,
    ) -> None:
        if robot.joints > msg.MAX_JOINTS:
            raise BadInputError(
                f"robot {robot.name!r} has {robot.joints} joints; a board has at most {msg.MAX_JOINTS}"
            )
        if not abs(drift_ppm) <= MAX_DRIFT_PPM:
            raise BadInputError(
                f"a clock drift of {drift_ppm} ppm; a board's clock is at most {MAX_DRIFT_PPM} ppm off"
            )
        if not 0 <= serial_number < 1 << 64:
            raise BadInputError(f"serial number {serial_number}: it has 64 bits")
        if start_rad is not None and len(start_rad) != robot.joints:
            raise BadInputError(
                f"{len(start_rad)} start angles for robot {robot.name!r} with {robot.joints} joints"
            )
        if robot.encoder_counts_per_rev > _MAX_COUNTS_PER_REV:
            raise BadInputError(
                f"robot {robot.name!r}: {robot.encoder_counts_per_rev} encoder counts a turn; "
                f"the protocol reports at most {_MAX_COUNTS_PER_REV}"
            )
        self.robot = robot
        self.serial_number = serial_number
        self.boot_id = 0
        self._plant = plant if plant is not None else make_plant(robot, specs, seed, start_rad)
        self._drift_ppm = drift_ppm + self._plant.clock_ppm
        self._clock_offset_us = clock_offset_us
        self._boots: random.Random = random.SystemRandom() if boot_seed is None else random.Random(boot_seed)
        self._trim_rad = [0.0] * robot.joints
        self._zero_counts = [0] * robot.joints
        self._free: list[bool | None] = [None] * robot.joints  # as the plant was told
        self._outbox: list[Frame] = []
        self._clock: OwnClock | None = None
        self._start_s = 0.0  # when the plant's time began
        self._now_s = -math.inf
        self._stop_id = frame_id(msg.EmergencyStop)
        self._handlers: dict[type[Message], Callable[[Any, float], None]] = {
            msg.Setpoint: self._setpoint,
            msg.Latch: self._setpoint,
            msg.HostHeartbeat: lambda message, t: self._machine.heartbeat(message.host, t),
            msg.ModeRequest: self._mode_request,
            msg.JointModeRequest: self._configure,
            msg.LimitRequest: self._configure,
            msg.TrimRequest: self._configure,
            msg.ZeroRequest: self._configure,
            msg.Ping: lambda message, t: self._send(msg.Pong(message.nonce, self._shows_us(t))),
            msg.InfoRequest: lambda message, t: self._info(),
        }
        self._fresh()

    # -- what a transport calls --------------------------------------------------------------------------------------

    @property
    def next_event_s(self) -> float:
        """When the board next wants ``advance``, in the caller's time; -infinity before its first reset."""
        return -math.inf if self._clock is None else self._clock.true_s(self._due_s())

    @property
    def mode(self) -> Mode:
        return self._machine.mode

    @property
    def joint_modes(self) -> tuple[JointMode, ...]:
        return self._register.joint_modes

    @property
    def plant(self) -> JointPlant:
        """The joints behind the board, for those who may look behind the scenes."""
        return self._plant

    def receive(self, frame: Frame, now_s: float) -> None:
        """Take one frame that arrives at ``now_s``; what it is answered with comes out of ``advance``."""
        t_s = self._run_to(now_s)
        self._received += 1
        if frame.id == self._stop_id:
            self._go_on(self._now_s)
            self._machine.emergency_stop(t_s)
            self._power()
            self._fault_event()
            return
        try:
            message = decode(frame)
        except ProtocolError:
            self._corrupt += 1
            return
        handler = self._handlers.get(type(message))
        if handler is not None:
            handler(message, t_s)

    def advance(self, now_s: float) -> list[Frame]:
        """Do what is due until ``now_s``; all frames that the board has sent since the last call."""
        self._run_to(now_s)
        sent, self._outbox = self._outbox, []
        return sent

    def integrate(self, now_s: float) -> None:
        """Let the simulated world catch up while nobody waits for an answer. Changes nothing that can be seen."""
        if self._clock is not None and now_s < self.next_event_s:
            self._go_on(now_s)

    def note_corrupt(self, packets: int) -> None:
        """Packets that the transport had to drop: the board reports them in its counters."""
        self._corrupt += packets

    def reset(self, now_s: float) -> None:
        """Switch the board off and on: only trim and encoder zeros are kept; the joints stay where they are."""
        self._run_to(now_s)
        self._clock = None
        self._run_to(now_s)

    def fail(self, fault: Fault, now_s: float) -> None:
        """A fault of the simulated hardware."""
        t_s = self._run_to(now_s)
        if self._machine.mode in (Mode.ARMED, Mode.HOLDING):
            self._machine.fail(fault, t_s)
            self._fault_event()

    # -- time --------------------------------------------------------------------------------------------------------

    def _fresh(self) -> None:
        """All that a reset forgets."""
        robot = self.robot
        limits = (robot.angle_limit_rad, robot.speed_limit_rad_s, robot.acceleration_limit_rad_s2)
        self._machine = ModeMachine()
        self._register = SetpointRegister(*limits)
        self._configuration = Configuration(self._machine, self._register, self._trim_rad, self._zero_counts)
        self._known = [False] * robot.joints  # read since the reset
        self._received = self._corrupt = 0
        self._sample = 0
        self._sample_due_s = 0.0
        self._beat_due_s = 0.0
        self._counters_due_s = COUNTERS_S

    def _boot(self, now_s: float) -> None:
        if self.boot_id == 0:
            self._start_s = now_s
        before = self.boot_id
        while self.boot_id == before:
            self.boot_id = self._boots.randrange(1, 0x10000)
        self._clock = OwnClock(now_s, self._clock_offset_us, self._drift_ppm)
        self._fresh()
        self._go_on(now_s)
        self._power()

    def _run_to(self, now_s: float) -> float:
        """Do what is due until ``now_s``, each at its time; that time on the board's clock, since its reset."""
        self._now_s = max(self._now_s, now_s)
        if self._clock is None:
            self._boot(self._now_s)
        assert self._clock is not None
        t_s = self._clock.since_reset_s(self._now_s)
        while (due_s := self._due_s()) <= t_s + _EARLY_S:
            self._go_on(min(self._clock.true_s(due_s), self._now_s))
            self._do_due(due_s)
        return t_s

    def _go_on(self, true_s: float) -> None:
        """Bring the plant to a moment."""
        self._plant.advance(true_s - self._start_s)

    def _due_s(self) -> float:
        return min(self._machine.due_s, self._beat_due_s, self._sample_due_s, self._counters_due_s)

    def _do_due(self, t_s: float) -> None:
        if self._machine.due_s <= t_s:
            if self._machine.expire(t_s) is Expiry.WATCHDOG:
                self._fault_event()
            else:
                self._power()
        elif self._beat_due_s <= t_s:
            self._beat_due_s += BEAT_S
            self._beat()
        elif self._sample_due_s <= t_s:
            self._sample_due_s += BEAT_S
            self._report(t_s, self._read())
        else:
            self._counters_due_s += COUNTERS_S
            self._send(
                msg.Counters(
                    self._received & _MASK16,
                    self._corrupt & _MASK16,
                    self._register.dropped & _MASK16,
                    self._register.clamped & _MASK16,
                )
            )

    def _shows_us(self, t_s: float) -> int:
        assert self._clock is not None
        return self._clock.shows_us(t_s)

    # -- requests ----------------------------------------------------------------------------------------------------

    def _mode_request(self, message: msg.ModeRequest, t_s: float) -> None:
        before = self._machine.mode
        acknowledge = self._configuration.mode(message, t_s)
        if self._machine.mode is not before:
            self._go_on(self._now_s)
            self._power()
            if self._machine.mode is Mode.ARMED:
                self._register.start(t_s)
        self._send(acknowledge)

    def _configure(self, message: Message, t_s: float) -> None:
        self._go_on(self._now_s)
        self._send(self._configuration.take(message))
        self._power()

    # -- set-points --------------------------------------------------------------------------------------------------

    def _setpoint(self, message: msg.Setpoint | msg.Latch, t_s: float) -> None:
        if self._machine.mode is not Mode.ARMED:
            self._register.refuse(message)
            return
        tick = self._register.assemble(message)
        if tick is None:
            return
        self._go_on(self._now_s)
        counts = self._read()
        if not self._register.execute(tick, t_s):
            return
        self._machine.executed(t_s)
        self._sample_due_s = t_s + WATCHDOG_S
        self._command()
        self._report(t_s, counts)

    def _command(self) -> None:
        """The servo pulses: what the register holds, and each servo's trim."""
        self._plant.command(
            self._now_s - self._start_s,
            [angle + trim for angle, trim in zip(self._register.applied_rad, self._trim_rad, strict=True)],
        )

    def _power(self) -> None:
        """Tell the plant, which stands at this moment, which joints have power, where that has changed.

        A joint that gets power is told to stay where it is: nothing jumps. One that has never been read gets none.
        """
        modes = self._register.joint_modes
        free = [not self._machine.powered or mode is JointMode.FREE for mode in modes]
        switched_on = any(was and not now for was, now in zip(self._free, free, strict=True))
        if switched_on:
            self._read()
            free = [unpowered or not known for unpowered, known in zip(free, self._known, strict=True)]
        if free == self._free:
            return
        for index, (was, now) in enumerate(zip(self._free, free, strict=True)):
            if was is not now:
                self._plant.set_joint_mode(index + 1, "free" if now else "active")
        self._free = [*free]
        if switched_on:
            self._command()

    # -- encoders and samples ----------------------------------------------------------------------------------------

    def _read(self) -> list[int | None]:
        """Encoder counts from their zeros; the register follows those of joints without power.

        The plant has been brought to the moment of the reading.
        """
        counts = [
            None if raw is None else int(raw) - zero
            for raw, zero in zip(self._plant.encoder_counts(), self._zero_counts, strict=True)
        ]
        for index, count in enumerate(counts):
            self._known[index] |= count is not None
            if self._free[index] and count is not None:
                self._register.follow(index, count * self.robot.rad_per_count)
        return counts

    def _report(self, t_s: float, counts: Sequence[int | None]) -> None:
        state = msg.State(self._register.sequence, self._sample, self._machine.mode, self._shows_us(t_s))
        applied = [min(max(a, -_WIRE_ANGLE_RAD), _WIRE_ANGLE_RAD) for a in self._register.applied_rad]
        self._send(*sample_messages(state, counts, applied))
        pose = self._plant.pose()
        if pose is not None:
            x_m, y_m, heading_rad, speed_m_s = pose
            try:
                frames = [
                    encode(msg.PosePosition(self._sample, x_m, y_m)),
                    encode(msg.PoseMotion(self._sample, heading_rad, speed_m_s)),
                ]
            except ProtocolError:
                frames = []  # it has left the range of the wire: no pose is better than a wrong one
            self._outbox += frames
        self._sample = (self._sample + 1) & SHORT_MASK

    # -- what the board says unasked ---------------------------------------------------------------------------------

    def _beat(self) -> None:
        machine = self._machine
        self._send(
            msg.BoardHeartbeat(self.boot_id, machine.mode, machine.powered, 1, machine.fault, machine.holder)
        )
        if machine.fault is not Fault.NONE:
            self._fault_event()

    def _fault_event(self) -> None:
        self._send(msg.FaultEvent(self._machine.fault, 0, 0, self._shows_us(self._machine.fault_since_s)))

    def _info(self) -> None:
        major, minor, patch = (int(part) for part in snakebot.__version__.split(".")[:3])
        self._send(
            msg.InfoProtocol(
                msg.PROTOCOL_MAJOR, msg.PROTOCOL_MINOR, self.robot.joints, 1, msg.catalogue_hash()
            ),
            msg.InfoFirmware(
                major, minor, patch, round(WATCHDOG_S * 1e3), self.robot.encoder_counts_per_rev, self.boot_id
            ),
            msg.InfoSerial(self.serial_number),
        )

    def _send(self, *messages: Message) -> None:
        self._outbox += [encode(message) for message in messages]


def make_plant(
    robot: Robot, specs: Sequence[Any], seed: int, start_rad: Sequence[float] | None
) -> JointPlant:
    """The plant, with everything compiled: the first tick must not wait for a compiler."""
    from snakebot.effects import Plant

    angles_rad = [0.0] * robot.joints if start_rad is None else list(start_rad)
    trial = Plant(robot, specs, seed, initial_rad=angles_rad)
    trial.set_joint_mode(1, "free")
    trial.command(0.0, angles_rad)
    trial.advance(0.01)
    trial.encoder_counts()
    trial.pose()
    return Plant(robot, specs, seed, initial_rad=angles_rad)
