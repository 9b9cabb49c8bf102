"""The set-point register: what arrives, in what order it counts, and what the joints' limits make of it.

No wire and no plant: messages come in decoded, what is executed goes out as angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from firmware_protocol.assembly import ANGLE_STEP_RAD, SEQUENCE_MASK, SetpointAssembler
from firmware_protocol.catalogue import JointMode, Latch, LimitKind, Setpoint
from snakebot.gait.limits import SlewLimiter

_HALF = 0x8000  # sequence steps of up to half the range are forward


@dataclass(slots=True)
class _Joint:
    mode: JointMode = JointMode.ACTIVE
    hold_rad: float | None = None  # RIGID: where to


@dataclass(frozen=True, slots=True)
class Tick:
    """One complete set-point of all joints."""

    sequence: int
    step: int  # of the sequence number since the set-point executed before; 1 at the first
    interval_s: float
    angles_rad: tuple[float, ...]


class SetpointRegister:
    """The angles that the servos are told, one a joint, and how set-points reach them.

    Args:
        angle_rad, speed_rad_s, acceleration_rad_s2: the board's built-in limits, one a joint.
    """

    def __init__(
        self,
        angle_rad: Sequence[float],
        speed_rad_s: Sequence[float],
        acceleration_rad_s2: Sequence[float],
    ) -> None:
        self._built_in = (tuple(angle_rad), tuple(speed_rad_s), tuple(acceleration_rad_s2))
        self.joints = len(self._built_in[0])
        self.sequence = 0  # of the set-point that was executed last
        self.clamped = 0
        self._refused = 0
        self._assembler = SetpointAssembler(self.joints)
        self._limiter = SlewLimiter(*self._built_in)
        self._modes = [_Joint() for _ in range(self.joints)]
        self._first = True  # since arming
        self._executed_s = 0.0  # or armed

    @property
    def dropped(self) -> int:
        """Set-points that were incomplete, corrupt, stale, too early, or came in a mode that drops them."""
        return self._refused + self._assembler.dropped

    @property
    def applied_rad(self) -> tuple[float, ...]:
        """What the joints are told now, after the limits."""
        return tuple(self._limiter.applied_rad)

    @property
    def joint_modes(self) -> tuple[JointMode, ...]:
        return tuple(joint.mode for joint in self._modes)

    def start(self, t_s: float) -> None:
        """The board is armed: at rest, from where the register is."""
        self._assembler.reset()
        self._limiter.reset(self.applied_rad)
        self._first = True
        self._executed_s = t_s

    def follow(self, joint: int, measured_rad: float) -> None:
        """A joint without power (counted from 0): its angle in the register is the measured one."""
        self._limiter.follow(joint, measured_rad)

    def refuse(self, message: Setpoint | Latch) -> None:
        """A set-point in a mode that drops them; the latch stands for all its frames."""
        self._refused += isinstance(message, Latch)

    def assemble(self, message: Setpoint | Latch) -> Tick | None:
        """The set-point that this message completes, if it is newer than the last one executed."""
        complete = self._assembler.add(message)
        if complete is None:
            return None
        latch, angles_rad = complete
        step = (latch.sequence - self.sequence) & SEQUENCE_MASK
        if self._first:
            step = 1
        elif not 0 < step < _HALF:
            self._refused += 1
            return None
        return Tick(latch.sequence, step, latch.interval_s, angles_rad)

    def execute(self, tick: Tick, t_s: float) -> bool:
        """Move ``applied_rad`` towards the set-point as far as the limits let it; False if it comes too early."""
        targets = [self._target(index, angle_rad) for index, angle_rad in enumerate(tick.angles_rad)]
        executed = self._limiter.execute(targets, tick.interval_s, tick.step, t_s - self._executed_s)
        if executed is None:
            self._refused += 1
            return False
        self._first = False
        self._executed_s = t_s
        self.sequence = tick.sequence
        self.clamped += any(
            joint.mode is JointMode.ACTIVE and abs(now - wanted) > ANGLE_STEP_RAD / 2
            for joint, now, wanted in zip(self._modes, executed[0], tick.angles_rad, strict=True)
        )
        return True

    def _target(self, index: int, angle_rad: float) -> float:
        joint = self._modes[index]
        if joint.mode is JointMode.ACTIVE:
            return angle_rad
        if joint.hold_rad is not None:
            return joint.hold_rad
        return self._limiter.applied_rad[index]

    def may_go_to(self, index: int, angle_rad: float) -> bool:
        """The angle is within the joint's limit, to half a step of the wire."""
        return abs(angle_rad) <= self._limiter.angle_rad[index] + ANGLE_STEP_RAD / 2

    def set_joint_mode(self, index: int, mode: JointMode, angle_rad: float) -> None:
        """Change how a joint (counted from 0) follows; only ``rigid`` goes to the angle."""
        self._modes[index] = _Joint(mode, angle_rad if mode is JointMode.RIGID else None)

    def _limits(self, kind: LimitKind) -> list[float]:
        return {
            LimitKind.ANGLE: self._limiter.angle_rad,
            LimitKind.SPEED: self._limiter.speed_rad_s,
            LimitKind.ACCELERATION: self._limiter.acceleration_rad_s2,
        }[kind]

    def built_in(self, index: int, kind: LimitKind) -> float:
        """The limit that no request can exceed."""
        return self._built_in[kind][index]

    def limit(self, index: int, kind: LimitKind) -> float:
        """The limit in force."""
        return self._limits(kind)[index]

    def set_limit(self, index: int, kind: LimitKind, value: float) -> None:
        """Put a limit in force; the caller has checked that it may."""
        self._limits(kind)[index] = min(value, self.built_in(index, kind))
