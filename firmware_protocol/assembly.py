"""Groups of three joints put together: set-points behind a latch, samples behind a state.

A set-point for all joints, and a sample of all joints, need several frames. Both ends use these classes so that no
torn mix of two ticks is ever executed or reported. They go from integers to frames and back: a tick has ten group
frames and no use for ten messages.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
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
    decode,
    encode,
    encode_values,
    frame_id,
    layout,
)
from firmware_protocol.frame import Frame, ProtocolError
from firmware_protocol.packing import function

GROUP = 3  # joints a frame
ANGLE_STEP_RAD = 1e-4  # one bit of an angle on the wire, as in the DBC
LARGEST = 32767  # integer of an angle or a count on the wire
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


def raw_angles(angles_rad: Sequence[float]) -> list[int]:
    """The angles as the integers that the wire carries.

    Raises:
        ProtocolError: one is not a number, or outside +-3.2767 rad.
    """
    try:
        raw = [round(angle / ANGLE_STEP_RAD) for angle in angles_rad]
    except (ValueError, OverflowError):
        bad = next(angle for angle in angles_rad if not math.isfinite(angle / ANGLE_STEP_RAD))
        raise ProtocolError(f"{bad} is no angle") from None
    if raw and not -LARGEST <= min(raw) <= max(raw) <= LARGEST:
        bad = max(angles_rad, key=abs)
        raise ProtocolError(f"{bad:.4f} rad is outside the wire's +-3.2767 rad")
    return raw


def to_wire(angle_rad: float) -> float:
    """The angle as the wire carries it.

    Raises:
        ProtocolError: not a number, or outside +-3.2767 rad.
    """
    return raw_angles([angle_rad])[0] * ANGLE_STEP_RAD


class _GroupFrames:
    """Group frames of one message: a number, the group's index and three integers."""

    def __init__(self, cls: type[Message], filler: int = 0) -> None:
        self.id = frame_id(cls)
        self._layout = layout(cls)
        self._split = self._layout.split
        self._filler = filler
        self._joins: dict[int, Callable[[int, Sequence[int]], list[Frame]]] = {}

    def join(self, number: int, raw: Sequence[int]) -> list[Frame]:
        """The frames that carry these integers, three each."""
        joints = len(raw)
        if joints not in self._joins:
            self._joins[joints] = self._join_of(joints)
        return self._joins[joints](number, raw)

    def _join_of(self, joints: int) -> Callable[[int, Sequence[int]], list[Frame]]:
        """All frames in one expression: what is called for every frame of every tick costs more than it does."""
        raws = [f"raw[{joint}]" for joint in range(joints)] + [str(self._filler)] * (-joints % GROUP)
        data = [
            self._layout.joined(["number", str(group), *raws[GROUP * group : GROUP * (group + 1)]])
            for group in range(groups(joints))
        ]
        return function(
            ["number", "raw"], f"[{', '.join(f'Frame({self.id}, {each})' for each in data)}]", Frame=Frame
        )

    def split(self, frame: Frame) -> tuple[int, int, list[int]]:
        """Number, group and integers.

        Raises:
            ProtocolError: the length is not the message's.
        """
        if len(frame.data) != self._layout.length:
            raise ProtocolError(f"{frame}: {len(frame.data)} bytes, not {self._layout.length}")
        number, group, *raw = self._split(frame.data)
        return number, group, raw


class _Wire:
    """What the DBC says about the frames of a tick."""

    def __init__(self) -> None:
        self.setpoint, self.applied = _GroupFrames(Setpoint), _GroupFrames(Applied)
        self.measured = _GroupFrames(Measured, NO_READING)
        self.latch_id, self.state_id = frame_id(Latch), frame_id(State)
        self.setpoint_ids = frozenset({self.setpoint.id, self.latch_id})
        self.sample_ids = frozenset({self.state_id, self.measured.id, self.applied.id})


@cache
def _wire() -> _Wire:
    return _Wire()


def setpoint_ids() -> frozenset[int]:
    """Identifiers of the frames that a ``SetpointAssembler`` takes."""
    return _wire().setpoint_ids


def sample_ids() -> frozenset[int]:
    """Identifiers of the frames that a ``SampleAssembler`` takes."""
    return _wire().sample_ids


def setpoint_crc(sequence: int, angles_rad: Sequence[float]) -> int:
    """CRC-32 over (sequence u16, joints u8, joints x i16 raw angles), little-endian.

    It spans all groups: a group frame that was corrupted and still passed its own check cannot be executed.
    """
    return _raw_crc(sequence, raw_angles(angles_rad))


def _raw_crc(sequence: int, raw: Sequence[int]) -> int:
    return zlib.crc32(struct.pack(f"<HB{len(raw)}h", sequence & SEQUENCE_MASK, len(raw), *raw))


def setpoint_frames(sequence: int, raw: Sequence[int], interval_s: float) -> list[Frame]:
    """One tick's set-point for all joints, as ``raw_angles`` gives it: its groups, then the latch.

    Raises:
        ProtocolError: no joints or too many, an interval that the wire cannot carry.
    """
    joints = len(raw)
    if not 1 <= joints <= MAX_JOINTS:
        raise ProtocolError(f"{joints} joints; the protocol carries 1 to {MAX_JOINTS}")
    frames = _wire().setpoint.join(sequence & SHORT_MASK, raw)
    crc = _raw_crc(sequence, raw)
    frames.append(encode_values(Latch, sequence & SEQUENCE_MASK, joints, interval_s, crc))
    return frames


def setpoint_messages(sequence: int, angles_rad: Sequence[float], interval_s: float) -> list[Message]:
    """The messages in ``setpoint_frames``, for whoever wants to change one.

    Raises:
        ProtocolError: no joints or too many, an angle or an interval that the wire cannot carry.
    """
    return [decode(frame) for frame in setpoint_frames(sequence, raw_angles(angles_rad), interval_s)]


@dataclass(slots=True)
class _Parts:
    latch: Latch | None = None
    groups: dict[int, list[int]] = field(default_factory=dict)


class SetpointAssembler:
    """The board's side: releases a set-point only when latch and all groups of one sequence number are there."""

    def __init__(self, joints: int) -> None:
        self.joints = joints
        self.dropped = 0  # given up incomplete, or with a CRC that did not agree
        self._groups = groups(joints)
        self._parts: dict[int, _Parts] = {}
        self._wire = _wire()

    @property
    def idle(self) -> bool:
        """Nothing is unfinished."""
        return not self._parts

    def reset(self) -> None:
        """Forget what is unfinished."""
        self._parts.clear()

    def add(self, message: Setpoint | Latch) -> tuple[Latch, tuple[float, ...]] | None:
        """``take`` for a message."""
        return self.take(encode(message))

    def take(self, frame: Frame) -> tuple[Latch, tuple[float, ...]] | None:
        """The latch and all angles (rad) as soon as they are complete, in any order of arrival.

        Raises:
            ProtocolError: the frame is no Setpoint or Latch.
        """
        if frame.id == self._wire.setpoint.id:
            key, group, raw = self._wire.setpoint.split(frame)
            parts = self._parts_of(key)
            parts.groups[group] = raw
        else:
            latch = decode(frame)
            if not isinstance(latch, Latch):
                raise ProtocolError(f"{frame}: no part of a set-point")
            key = latch.sequence & SHORT_MASK
            parts = self._parts_of(key)
            parts.latch = latch
        if parts.latch is None or len(parts.groups) < self._groups:
            return None
        del self._parts[key]
        return self._complete(parts.latch, parts.groups)

    def _parts_of(self, key: int) -> _Parts:
        parts = self._parts.get(key)
        if parts is None:
            parts = self._parts[key] = _Parts()
            if len(self._parts) > _KEPT:
                del self._parts[next(iter(self._parts))]
                self.dropped += 1
        return parts

    def _complete(self, latch: Latch, parts: dict[int, list[int]]) -> tuple[Latch, tuple[float, ...]] | None:
        raw = [angle for group in range(self._groups) for angle in parts.get(group, ())][: self.joints]
        if (
            latch.joints != self.joints
            or len(raw) < self.joints
            or _raw_crc(latch.sequence, raw) != latch.crc32
        ):
            self.dropped += 1
            return None
        if self._parts:
            self.dropped += _forget_older(self._parts, latch.sequence & SHORT_MASK)
        return latch, tuple([angle * ANGLE_STEP_RAD for angle in raw])


@dataclass(frozen=True, slots=True)
class Sample:
    """What the board reports of all joints at one moment."""

    state: State
    measured_counts: tuple[int | None, ...]  # None: no reading
    applied_rad: tuple[float, ...]


def sample_frames(
    state: State, measured_counts: Sequence[int | None], applied_rad: Sequence[float]
) -> list[Frame]:
    """The frames of one sample: state, then the groups of measured and applied angles.

    Counts beyond 16 bits are reported as no reading: a wrong angle would be worse than none.

    Raises:
        ProtocolError: an angle or a value of the state that the wire cannot carry.
    """
    wire = _wire()
    counts = [
        NO_READING if count is None or not -LARGEST <= count <= LARGEST else count
        for count in measured_counts
    ]
    return [
        encode(state),
        *wire.measured.join(state.sample, counts),
        *wire.applied.join(state.sample, raw_angles(applied_rad)),
    ]


def sample_messages(
    state: State, measured_counts: Sequence[int | None], applied_rad: Sequence[float]
) -> list[Message]:
    """The messages in ``sample_frames``, for whoever wants to change one."""
    return [decode(frame) for frame in sample_frames(state, measured_counts, applied_rad)]


@dataclass(slots=True)
class _SampleParts:
    state: State | None = None
    measured: dict[int, list[int]] = field(default_factory=dict)
    applied: dict[int, list[int]] = field(default_factory=dict)


class SampleAssembler:
    """The host's side: releases a sample only when all its frames are there."""

    def __init__(self, joints: int) -> None:
        self.joints = joints
        self.dropped = 0
        self._groups = groups(joints)
        self._parts: dict[int, _SampleParts] = {}
        self._wire = _wire()

    @property
    def idle(self) -> bool:
        """Nothing is unfinished."""
        return not self._parts

    def reset(self) -> None:
        """Forget what is unfinished: the board has rebooted or the link was opened anew."""
        self._parts.clear()

    def add(self, message: State | Measured | Applied) -> Sample | None:
        """``take`` for a message."""
        return self.take(encode(message))

    def take(self, frame: Frame) -> Sample | None:
        """The sample as soon as it is complete, in any order of arrival.

        Raises:
            ProtocolError: the frame is no State, Measured or Applied.
        """
        wire = self._wire
        if frame.id == wire.measured.id:
            key, group, raw = wire.measured.split(frame)
            parts = self._parts_of(key)
            parts.measured[group] = raw
        elif frame.id == wire.applied.id:
            key, group, raw = wire.applied.split(frame)
            parts = self._parts_of(key)
            parts.applied[group] = raw
        else:
            state = decode(frame)
            if not isinstance(state, State):
                raise ProtocolError(f"{frame}: no part of a sample")
            key = state.sample
            parts = self._parts_of(key)
            parts.state = state
        if parts.state is None or len(parts.measured) < self._groups or len(parts.applied) < self._groups:
            return None
        del self._parts[key]
        if self._parts:
            self.dropped += _forget_older(self._parts, key)
        return self._complete(parts.state, parts)

    def _parts_of(self, key: int) -> _SampleParts:
        parts = self._parts.get(key)
        if parts is None:
            parts = self._parts[key] = _SampleParts()
            if len(self._parts) > _KEPT:
                del self._parts[next(iter(self._parts))]
                self.dropped += 1
        return parts

    def _complete(self, state: State, parts: _SampleParts) -> Sample | None:
        counts = [count for group in range(self._groups) for count in parts.measured.get(group, ())]
        applied = [angle for group in range(self._groups) for angle in parts.applied.get(group, ())]
        if min(len(counts), len(applied)) < GROUP * self._groups:
            self.dropped += 1
            return None
        return Sample(
            state,
            tuple([None if count == NO_READING else count for count in counts[: self.joints]]),
            tuple([angle * ANGLE_STEP_RAD for angle in applied[: self.joints]]),
        )
