"""The set-point register: what arrives, in what order it counts, and what the joints' limits make of it.

No wire and no plant: messages come in decoded, what is executed goes out as angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from firmware_protocol.assembly import ANGLE_STEP_RAD, SEQUENCE_MASK, SetpointAssembler
from firmware_protocol.catalogue import JointMode, Latch, LimitKind, Message
from firmware_protocol.frame import Frame
from firmware_protocol.whole_tick import SetpointReader
from snakebot.arrays import Floats
from snakebot.gait.limits import SlewLimiter

_HALF = 0x8000  # sequence steps of up to half the range are forward


@dataclass(slots=True)
class _Joint:
    mode: JointMode = JointMode.ACTIVE
    hold_rad: float | None = None  # RIGID: where to


class AssembledTick(NamedTuple):
    """One complete set-point of all joints."""

    sequence: int
    step: int  # of the sequence number since the set-point executed before; 1 at the first
    interval_s: float
    angles_rad: Sequence[float] | Floats


class SetpointRegister:
    """The angles that the servos are told, one a joint, and how set-points reach them.

    A servo is told its joint's angle and the trim in force: the limits are kept by that sum. Hosts know joint angles.

    Args:
        angle_rad, speed_rad_s, acceleration_rad_s2: the board's built-in limits, one a joint.
        trim_rad: the trims that are stored, one a joint.
    """

    def __init__(
        self,
        angle_rad: Sequence[float],
        speed_rad_s: Sequence[float],
        acceleration_rad_s2: Sequence[float],
        trim_rad: Sequence[float],
    ) -> None:
        self._built_in = (tuple(angle_rad), tuple(speed_rad_s), tuple(acceleration_rad_s2))
        self.joints = len(self._built_in[0])
        self.sequence = 0  # of the set-point that was executed last
        self.clamped = 0
        self._refused = 0
        self._assembler = SetpointAssembler(self.joints)
        self._reader = SetpointReader(self.joints)
        self._limiter = SlewLimiter(*self._built_in)
        self._modes = [_Joint() for _ in range(self.joints)]
        self._all_active = True
        # In force: as stored when it got power last.
        self.trim_rad: Floats = np.array(trim_rad, dtype=np.float64)
        self._limiter.reset(self.trim_rad.tolist())
        self._first = True  # since arming
        self._executed_s = 0.0  # or armed, or reset

    @property
    def dropped(self) -> int:
        """Set-points that were incomplete, corrupt, stale, too early, or came in a mode that drops them."""
        return self._refused + self._assembler.dropped

    @property
    def servo_rad(self) -> tuple[float, ...]:
        """What the servos are told now: after the limits, with their trims."""
        return tuple(self._limiter.applied.tolist())

    @property
    def servo(self) -> Floats:
        """``servo_rad`` as the (joints,) array that goes with it; not to be changed."""
        return self._limiter.applied

    @property
    def applied_rad(self) -> tuple[float, ...]:
        """The same in joint angles."""
        return tuple((self._limiter.applied - self.trim_rad).tolist())

    @property
    def joint_modes(self) -> tuple[JointMode, ...]:
        return tuple(joint.mode for joint in self._modes)

    def start(self, t_s: float) -> None:
        """The board is armed: at rest, from where the register is, with no more time than has passed."""
        self._assembler.reset()
        self._limiter.rest(t_s - self._executed_s)
        self._first = True
        self._executed_s = t_s

    def follow(self, joint: int, measured_rad: float) -> None:
        """A joint without power (counted from 0): its angle in the register is the measured one."""
        self._limiter.follow(joint, measured_rad + self.trim_rad[joint])

    def put_trim_in_force(self, joint: int, trim_rad: float) -> None:
        """A joint (from 0) gets power. Its servo is told the same as before: the change is made under the limits."""
        self.trim_rad[joint] = trim_rad

    def refuse(self, message: Message) -> None:
        """A part of a set-point in a mode that drops them; the latch stands for all its frames."""
        self._refused += isinstance(message, Latch)

    def assemble(self, frame: Frame) -> AssembledTick | None:
        """The set-point that this frame completes, if it is newer than the last one executed.

        Raises:
            ProtocolError: the frame is no Setpoint or Latch.
        """
        complete = self._assembler.take(frame)
        if complete is None:
            return None
        latch, angles_rad = complete
        return self._newer(latch.sequence, latch.interval_s, angles_rad)

    def read_whole(self, data: bytes) -> tuple[AssembledTick | None] | None:
        """The same for bytes that are one whole set-point; None: they are not, and ``assemble`` takes their frames."""
        whole = self._reader.read(data) if self._assembler.idle else None
        return None if whole is None else (self._newer(*whole, self._reader.angles_rad),)

    def _newer(
        self, sequence: int, interval_s: float, angles_rad: Sequence[float] | Floats
    ) -> AssembledTick | None:
        step = (sequence - self.sequence) & SEQUENCE_MASK
        if self._first:
            step = 1
        elif not 0 < step < _HALF:
            self._refused += 1
            return None
        return AssembledTick(sequence, step, interval_s, angles_rad)

    def execute(self, tick: AssembledTick, t_s: float) -> bool:
        """Move ``applied_rad`` towards the set-point as far as the limits let it; False if it comes too early."""
        limiter = self._limiter
        if self._all_active:
            np.add(tick.angles_rad, self.trim_rad, out=limiter.wanted)
        else:
            limiter.wanted[:] = [self._target(index, angle) for index, angle in enumerate(tick.angles_rad)]
        changed = limiter.execute_wanted(tick.interval_s, tick.step, t_s - self._executed_s)
        if changed is None:
            self._refused += 1
            return False
        self._first = False
        self._executed_s = t_s
        self.sequence = tick.sequence
        self.clamped += changed > 0 if self._all_active else self._is_changed()
        return True

    def _is_changed(self) -> bool:
        """A limit has changed where an active joint is sent; a rigid one is on its way."""
        return any(
            joint.mode is JointMode.ACTIVE and abs(now - wanted) > ANGLE_STEP_RAD / 2
            for joint, now, wanted in zip(
                self._modes, self._limiter.applied, self._limiter.wanted, strict=True
            )
        )

    def _target(self, index: int, angle_rad: float) -> float:
        """Where the servo is to be."""
        joint = self._modes[index]
        if joint.mode is JointMode.ACTIVE:
            return angle_rad + float(self.trim_rad[index])
        if joint.hold_rad is not None:
            return joint.hold_rad + float(self.trim_rad[index])
        return float(self._limiter.applied[index])

    def may_go_to(self, index: int, angle_rad: float) -> bool:
        """The angle is within the joint's limit, to half a step of the wire."""
        return abs(angle_rad) <= self.limit(index, LimitKind.ANGLE) + ANGLE_STEP_RAD / 2

    def set_joint_mode(self, index: int, mode: JointMode, angle_rad: float) -> None:
        """Change how a joint (counted from 0) follows; only ``rigid`` goes to the angle."""
        self._modes[index] = _Joint(mode, angle_rad if mode is JointMode.RIGID else None)
        self._all_active = all(joint.mode is JointMode.ACTIVE for joint in self._modes)

    def _limits(self, kind: LimitKind) -> Floats:
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
        return float(self._limits(kind)[index])

    def set_limit(self, index: int, kind: LimitKind, value: float) -> None:
        """Put a limit in force; the caller has checked that it may."""
        self._limits(kind)[index] = min(value, self.built_in(index, kind))
