"""Groups of three joints put together: set-points behind a latch, samples behind a state.

A set-point for all joints, and a sample of all joints, need several frames. Both ends use these classes so that no
torn mix of two ticks is ever executed or reported.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from firmware_protocol.catalogue import (
    MAX_JOINTS,
    NO_READING,
    Applied,
    Latch,
    Measured,
    Message,
    Setpoint,
    State,
)
from firmware_protocol.frame import ProtocolError

GROUP = 3  # joints a frame
ANGLE_STEP_RAD = 1e-4  # one bit of an angle on the wire, as in the DBC
SEQUENCE_MASK = 0xFFFF
SHORT_MASK = 0xFFF  # what a group frame keeps of a sequence or sample number
_KEPT = 4  # unfinished set-points or samples that are remembered before the oldest is given up


def groups(joints: int) -> int:
    """Group frames for that many joints."""
    return -(-joints // GROUP)


def _forget_older(parts: dict[int, Any], complete: int) -> int:
    """Give up what is older than a complete number, and return how much that was.

    Groups carry 12 bits of the number: a remnant that stayed would meet the one that comes 4096 later.
    """
    older = [key for key in parts if (complete - key) & SHORT_MASK <= SHORT_MASK // 2]
    for key in older:
        del parts[key]
    return len(older)


def to_wire(angle_rad: float) -> float:
    """The angle as the wire carries it.

    Raises:
        ProtocolError: not a number, or outside +-3.2767 rad.
    """
    return _raw(angle_rad) * ANGLE_STEP_RAD


def _raw(angle_rad: float) -> int:
    if not math.isfinite(angle_rad):
        raise ProtocolError(f"{angle_rad} is no angle")
    raw = round(angle_rad / ANGLE_STEP_RAD)
    if abs(raw) > 32767:
        raise ProtocolError(f"{angle_rad:.4f} rad is outside the wire's +-3.2767 rad")
    return raw


def setpoint_crc(sequence: int, angles_rad: Sequence[float]) -> int:
    """CRC-32 over (sequence u16, joints u8, joints x i16 raw angles), little-endian.

    It spans all groups: a group frame that was corrupted and still passed its own check cannot be executed.
    """
    raw = [_raw(angle) for angle in angles_rad]
    return zlib.crc32(struct.pack(f"<HB{len(raw)}h", sequence & SEQUENCE_MASK, len(raw), *raw))


def setpoint_messages(sequence: int, angles_rad: Sequence[float], interval_s: float) -> list[Message]:
    """One tick's set-point for all joints: its groups, then the latch.

    Raises:
        ProtocolError: no joints or too many, an angle or an interval that the wire cannot carry.
    """
    joints = len(angles_rad)
    if not 1 <= joints <= MAX_JOINTS:
        raise ProtocolError(f"{joints} joints; the protocol carries 1 to {MAX_JOINTS}")
    padded = [to_wire(angle) for angle in angles_rad] + [0.0] * (-joints % GROUP)
    messages: list[Message] = [
        Setpoint(sequence & SHORT_MASK, group, *padded[GROUP * group : GROUP * (group + 1)])
        for group in range(groups(joints))
    ]
    messages.append(Latch(sequence & SEQUENCE_MASK, joints, interval_s, setpoint_crc(sequence, angles_rad)))
    return messages


@dataclass(slots=True)
class _Parts:
    latch: Latch | None = None
    groups: dict[int, Setpoint] = field(default_factory=dict)


class SetpointAssembler:
    """The board's side: releases a set-point only when latch and all groups of one sequence number are there."""

    def __init__(self, joints: int) -> None:
        self.joints = joints
        self.dropped = 0  # given up incomplete, or with a CRC that did not agree
        self._parts: dict[int, _Parts] = {}

    def reset(self) -> None:
        """Forget what is unfinished."""
        self._parts.clear()

    def add(self, message: Setpoint | Latch) -> tuple[Latch, tuple[float, ...]] | None:
        """The latch and all angles (rad) as soon as they are complete, in any order of arrival."""
        key = message.sequence & SHORT_MASK
        parts = self._parts.get(key)
        if parts is None:
            parts = self._parts[key] = _Parts()
            if len(self._parts) > _KEPT:
                del self._parts[next(iter(self._parts))]
                self.dropped += 1
        if isinstance(message, Latch):
            parts.latch = message
        else:
            parts.groups[message.group] = message
        if parts.latch is None or len(parts.groups) < groups(self.joints):
            return None
        del self._parts[key]
        ordered = [parts.groups.get(index) for index in range(groups(self.joints))]
        angles = [
            angle for part in ordered if part for angle in (part.first_rad, part.second_rad, part.third_rad)
        ][: self.joints]
        latch = parts.latch
        if latch.joints != self.joints or len(angles) < self.joints:
            self.dropped += 1
            return None
        if setpoint_crc(latch.sequence, angles) != latch.crc32:
            self.dropped += 1
            return None
        self.dropped += _forget_older(self._parts, key)
        return latch, tuple(angles)


@dataclass(frozen=True, slots=True)
class Sample:
    """What the board reports of all joints at one moment."""

    state: State
    measured_counts: tuple[int | None, ...]  # None: no reading
    applied_rad: tuple[float, ...]


def sample_messages(
    state: State, measured_counts: Sequence[int | None], applied_rad: Sequence[float]
) -> list[Message]:
    """The frames of one sample: state, then the groups of measured and applied angles.

    Counts beyond 16 bits are reported as no reading: a wrong angle would be worse than none.
    """
    joints = len(measured_counts)
    counts = [NO_READING if c is None or abs(c) > 32767 else c for c in measured_counts]
    counts += [NO_READING] * (-joints % GROUP)
    applied = [to_wire(angle) for angle in applied_rad] + [0.0] * (-joints % GROUP)
    messages: list[Message] = [state]
    for group in range(groups(joints)):
        part = slice(GROUP * group, GROUP * (group + 1))
        messages.append(Measured(state.sample, group, *counts[part]))
    for group in range(groups(joints)):
        part = slice(GROUP * group, GROUP * (group + 1))
        messages.append(Applied(state.sample, group, *applied[part]))
    return messages


@dataclass(slots=True)
class _SampleParts:
    state: State | None = None
    measured: dict[int, Measured] = field(default_factory=dict)
    applied: dict[int, Applied] = field(default_factory=dict)


class SampleAssembler:
    """The host's side: releases a sample only when all its frames are there."""

    def __init__(self, joints: int) -> None:
        self.joints = joints
        self.dropped = 0
        self._parts: dict[int, _SampleParts] = {}

    def reset(self) -> None:
        """Forget what is unfinished: the board has rebooted or the link was opened anew."""
        self._parts.clear()

    def add(self, message: State | Measured | Applied) -> Sample | None:
        """The sample as soon as it is complete, in any order of arrival."""
        parts = self._parts.get(message.sample)
        if parts is None:
            parts = self._parts[message.sample] = _SampleParts()
            if len(self._parts) > _KEPT:
                del self._parts[next(iter(self._parts))]
                self.dropped += 1
        if isinstance(message, State):
            parts.state = message
        elif isinstance(message, Measured):
            parts.measured[message.group] = message
        else:
            parts.applied[message.group] = message
        count = groups(self.joints)
        if parts.state is None or len(parts.measured) < count or len(parts.applied) < count:
            return None
        del self._parts[message.sample]
        self.dropped += _forget_older(self._parts, message.sample)
        if any(index not in parts.measured or index not in parts.applied for index in range(count)):
            self.dropped += 1
            return None
        counts: list[int | None] = []
        applied: list[float] = []
        for index in range(count):
            m, a = parts.measured[index], parts.applied[index]
            counts += [
                None if c == NO_READING else c for c in (m.first_counts, m.second_counts, m.third_counts)
            ]
            applied += [a.first_rad, a.second_rad, a.third_rad]
        return Sample(parts.state, tuple(counts[: self.joints]), tuple(applied[: self.joints]))
