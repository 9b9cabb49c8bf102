"""A board in software: the protocol of PROTOCOL.md in front of joints that are simulated, or on a servo bus.

It does no input or output of its own and reads no clock: frames and times are handed in, frames come out. A transport
(``inprocess``, ``serve``) carries them.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from typing import Any

from firmware_protocol import catalogue as msg
from firmware_protocol.assembly import SHORT_MASK, setpoint_ids
from firmware_protocol.catalogue import (
    Fault,
    JointMode,
    Message,
    Mode,
    decode,
    encode,
    frame_id,
)
from firmware_protocol.frame import Frame, ProtocolError
from firmware_protocol.framing import Packed
from firmware_protocol.whole_tick import AnswerWriter
from snakebot.robot import Robot
from snakebot.softboard import reports
from snakebot.softboard.buildable import check_board
from snakebot.softboard.configuration import Configuration
from snakebot.softboard.hardware import Hardware, HardwareFault
from snakebot.softboard.joints import DrivenJoints
from snakebot.softboard.modes import WATCHDOG_MS, ModeMachine
from snakebot.softboard.ownclock import OwnClock
from snakebot.softboard.plant import JointPlant, make_plant
from snakebot.softboard.register import AssembledTick, SetpointRegister

BEAT_S = 0.1  # heartbeats, and samples while nothing streams
COUNTERS_S = 1.0  # counters come once a second (PROTOCOL.md)
_EARLY_S = 1e-7  # a timer may run out this early: a year's clock resolves no better


class SoftBoard:
    """One board. It is reset by the first call that brings a time.

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
        start_pose: x, y (m) of the centre of mass and mean link angle (rad) at the start.
        plant: stands in for ``snakebot.effects.Plant``.
        watchdog_ms: how long the armed board waits for a set-point.

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
        start_pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        plant: JointPlant | None = None,
        watchdog_ms: int = WATCHDOG_MS,
    ) -> None:
        check_board(robot, drift_ppm, serial_number, start_rad, watchdog_ms)
        self.robot = robot
        self._watchdog_ms = watchdog_ms
        self.serial_number = serial_number
        self.boot_id = 0
        self._plant = plant if plant is not None else make_plant(robot, specs, seed, start_rad, start_pose)
        self._hardware = Hardware(self._plant)
        self._drift_ppm = drift_ppm + self._plant.clock_ppm
        self._clock_offset_us = clock_offset_us
        self._boots: random.Random = random.SystemRandom() if boot_seed is None else random.Random(boot_seed)
        self._joints = DrivenJoints(self._plant, robot)
        self._outbox: Sequence[Frame] = []
        self._answers = AnswerWriter(robot.joints)
        self._clock: OwnClock | None = None
        self._t_s = 0.0  # on the board's clock since its reset, at ``_now_s``
        self._start_s = 0.0  # when the plant's time began
        self._now_s = self._next_setpoint_s = -math.inf
        self._stop_id = frame_id(msg.EmergencyStop)
        self._setpoint_ids = setpoint_ids()
        self._handlers: dict[type[Message], Callable[[Any, float], None]] = {
            msg.HostHeartbeat: lambda message, t: self._machine.heartbeat(message.host, t),
            msg.ModeRequest: self._mode_request,
            msg.ClearRequest: self._clear_request,
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
        if self._clock is None:
            return -math.inf
        return min(self._clock.true_s(self._due_s()), self._start_s + self._hardware.due_s)

    @property
    def next_setpoint_s(self) -> float:
        """When the next set-point comes if the host goes on as it has planned; -infinity before the first."""
        return self._next_setpoint_s

    @property
    def mode(self) -> Mode:
        return self._machine.mode

    @property
    def joint_modes(self) -> tuple[JointMode, ...]:
        return self._register.joint_modes

    @property
    def simulated(self) -> bool:
        """Whether there are no joints behind the board but simulated ones."""
        return self._hardware.simulated

    @property
    def plant(self) -> JointPlant:
        """The joints behind the board, for those who may look behind the scenes."""
        return self._plant

    def take(self, frames: Sequence[Frame], now_s: float) -> None:
        """Take all frames that arrive in one read at ``now_s``; the answer comes out of ``advance``."""
        if isinstance(frames, Packed):
            t_s = self._run_to(now_s)
            if self._machine.mode is Mode.ARMED:
                whole = self._register.read_whole(frames.data)
                if whole is not None:
                    self._received += len(frames)
                    self._execute(whole[0], t_s)
                    return
        for frame in frames:
            self.receive(frame, now_s)

    def receive(self, frame: Frame, now_s: float) -> None:
        """Take one frame that arrives at ``now_s``; what it is answered with comes out of ``advance``."""
        t_s = self._run_to(now_s)
        self._received += 1
        if frame.id == self._stop_id:
            self._stop(t_s)
            return
        try:
            if frame.id in self._setpoint_ids:
                self._setpoint(frame, t_s)
                return
            message = decode(frame)
        except ProtocolError:
            self._corrupt += 1
            return
        handler = self._handlers.get(type(message))
        if handler is not None:
            handler(message, t_s)

    def advance(self, now_s: float) -> Sequence[Frame]:
        """Do what is due until ``now_s``; all frames that the board has sent since the last call."""
        self._run_to(now_s)
        sent, self._outbox = self._outbox, []
        return sent

    def integrate(self, now_s: float) -> None:
        """Let the joints go on while nobody waits for an answer. Of simulated ones nothing that can be seen changes."""
        if self._clock is not None and (now_s < self.next_event_s or not self._hardware.simulated):
            self._go_on(now_s)

    def note_corrupt(self, packets: int) -> None:
        """Packets that the transport had to drop: the board reports them in its counters."""
        self._corrupt += packets

    def reset(self, now_s: float, clock_offset_us: int | None = None) -> None:
        """Switch the board off and on: only trim and encoder zeros are kept; the joints stay where they are.

        With ``clock_offset_us`` its clock shows that from this reset on.
        """
        self._run_to(now_s)
        if clock_offset_us is not None:
            self._clock_offset_us = clock_offset_us
        self._clock = None
        self._run_to(now_s)

    def fail(self, fault: HardwareFault, now_s: float) -> None:
        """Simulate a fault of the hardware from now on, ``Fault.NONE`` to end it. An emergency stop is a button."""
        t_s = self._run_to(now_s)
        self._hardware.simulated_fault = fault
        if self._hardware.button_is_pressed:
            self._stop(t_s)
        self._watch_hardware()

    # -- time --------------------------------------------------------------------------------------------------------

    def _fresh(self) -> None:
        """All that a reset forgets."""
        robot = self.robot
        limits = (robot.angle_limit_rad, robot.speed_limit_rad_s, robot.acceleration_limit_rad_s2)
        self._machine = ModeMachine(self._watchdog_ms * 1e-3)
        self._register = SetpointRegister(*limits, self._joints.trim_rad)
        self._configuration = Configuration(
            self._machine, self._register, self._joints.trim_rad, self._joints.zero_counts
        )
        self._joints.reset()
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
        if now_s > self._now_s or self._clock is None:  # not the next frame of the same read
            self._pass_time(now_s)
        self._watch_hardware()
        return self._t_s

    def _pass_time(self, now_s: float) -> None:
        self._now_s = max(self._now_s, now_s)
        if self._clock is None:
            self._boot(self._now_s)
        assert self._clock is not None
        t_s = self._clock.since_reset_s(self._now_s)
        while (due_s := self._due_s()) <= t_s + _EARLY_S:
            self._go_on(min(self._clock.true_s(due_s), self._now_s))
            self._do_due(due_s)
        if self._now_s >= self._start_s + self._hardware.due_s:
            self._go_on(self._now_s)
        self._t_s = t_s

    def _watch_hardware(self) -> None:
        """A fault of the joints freezes an armed or holding board; while it lasts, no board is armed."""
        fault = self._hardware.fault()
        self._machine.broken = Fault.NONE if fault is None else fault.code
        if fault is not None and self._machine.mode in (Mode.ARMED, Mode.HOLDING):
            self._hardware_failed(fault)

    def _hardware_failed(self, fault: HardwareFault) -> None:
        self._hardware.latched = fault
        self._machine.fail(fault.code, self._t_s)
        self._fault_event()

    def _go_on(self, true_s: float) -> None:
        """Bring the plant to a moment."""
        self._plant.advance(true_s - self._start_s)

    def _stop(self, t_s: float) -> None:
        self._go_on(self._now_s)
        self._machine.emergency_stop(t_s)
        self._power()
        self._fault_event()

    def _due_s(self) -> float:
        return min(self._machine.due_s, self._beat_due_s, self._sample_due_s, self._counters_due_s)

    def _do_due(self, t_s: float) -> None:
        if self._machine.due_s <= t_s:
            if self._machine.expire(t_s):
                self._fault_event()
            else:
                self._power()
        elif self._beat_due_s <= t_s:
            self._beat_due_s += BEAT_S
            self._beat()
        elif self._sample_due_s <= t_s:
            self._sample_due_s += BEAT_S
            self._report(t_s, self._joints.read(self._register))
        else:
            self._counters_due_s += COUNTERS_S
            self._send(*self._hardware.supply())
            self._send(reports.counters(self._received, self._corrupt, self._register))

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
        if message.mode is Mode.ARMED and acknowledge.result is msg.Result.OK:
            # After the answer: what the host hears now is in force until it disarms.
            self._send(*self._configuration.limits())

    def _clear_request(self, message: msg.ClearRequest, t_s: float) -> None:
        self._go_on(self._now_s)
        self._send(self._configuration.clear(message, t_s))
        self._power()
        if self._hardware.button_is_pressed and self._machine.mode is not Mode.STOPPED:
            self._stop(t_s)

    def _configure(self, message: Message, t_s: float) -> None:
        self._go_on(self._now_s)
        self._send(self._configuration.take(message))
        self._power()

    # -- set-points --------------------------------------------------------------------------------------------------

    def _setpoint(self, frame: Frame, t_s: float) -> None:
        if self._machine.mode is not Mode.ARMED:
            self._register.refuse(decode(frame))
            return
        self._execute(self._register.assemble(frame), t_s)

    def _execute(self, tick: AssembledTick | None, t_s: float) -> None:
        if tick is None:
            return
        self._go_on(self._now_s)
        counts = self._joints.read(self._register)
        if not self._register.execute(tick, t_s):
            return
        self._machine.executed(t_s)
        self._sample_due_s = t_s + self._watchdog_ms * 1e-3
        self._next_setpoint_s = self._now_s + tick.interval_s
        self._joints.command(self._register, self._now_s - self._start_s)
        self._report(t_s, counts)

    def _power(self) -> None:
        """Power as the modes of board and joints have it, at this moment of the plant."""
        self._joints.power(self._register, self._now_s - self._start_s, powered=self._machine.powered)

    # -- what the board says -----------------------------------------------------------------------------------------

    def _report(self, t_s: float, counts: Sequence[int | None]) -> None:
        state = self._register.sequence, self._sample, self._machine.mode, self._shows_us(t_s)
        register = self._register
        self._say(self._answers.write(state, counts, register.servo, register.trim_rad, self._plant.pose()))
        self._sample = (self._sample + 1) & SHORT_MASK

    def _beat(self) -> None:
        self._send(reports.heartbeat(self._machine, self.boot_id, simulated=self._hardware.simulated))
        if self._machine.fault is not Fault.NONE:
            self._fault_event()

    def _fault_event(self) -> None:
        about = self._hardware.about(self._machine.fault)
        self._send(reports.fault_event(self._machine, about, self._shows_us(self._machine.fault_since_s)))

    def _info(self) -> None:
        who = self.robot, self.serial_number, self.boot_id, self._watchdog_ms
        self._send(*reports.identity(*who, simulated=self._hardware.simulated), *self._configuration.limits())

    def _send(self, *messages: Message) -> None:
        self._say([encode(message) for message in messages])

    def _say(self, frames: Sequence[Frame]) -> None:
        self._outbox = [*self._outbox, *frames] if self._outbox else frames
