"""A whole tick in one go: a set-point, or the answer to it, to and from the bytes of one write, without a frame each.

Nearly all that passes in a run comes as one undamaged set-point, or one undamaged answer, in one read. Such a read is
taken here as it is. Anything else (damage, half a packet, one message more) is none of this module's business: it says
so and has changed nothing, and ``framing`` and ``assembly`` take it frame by frame. What both would take, they take for
the same; tests hold one against the other.

Importing brings the compiler in: only those who run a tick need it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firmware_protocol import tick_kernels
from firmware_protocol.assembly import ANGLE_STEP_RAD, LARGEST, Sample, groups
from firmware_protocol.catalogue import (
    NO_READING,
    Applied,
    Latch,
    Measured,
    Mode,
    PoseMotion,
    PosePosition,
    Setpoint,
    State,
    frame_id,
    layout,
)
from firmware_protocol.frame import ProtocolError
from firmware_protocol.framing import Packed

Floats = NDArray[np.float64]

_ROWS = (Setpoint, Latch, State, Measured, Applied, PosePosition, PoseMotion)  # as tick_kernels counts them
_MODES = {int(mode): mode for mode in Mode}
_NO_POSE = (math.nan,) * 4


class Wire:
    """What the DBC says of the messages of a tick, as the kernels take it."""

    def __init__(self) -> None:
        layouts = [layout(cls) for cls in _ROWS]
        self.signals = np.zeros((len(_ROWS), 2 + 2 * max(len(each.fields) for each in layouts)), np.int64)
        for row, (cls, each) in enumerate(zip(_ROWS, layouts, strict=True)):
            places = [place for field in each.fields for place in (field.start, field.length)]
            self.signals[row, : 2 + len(places)] = [frame_id(cls), each.length, *places]
        interval, x, y = layouts[1].fields[2], *layouts[5].fields[1:]
        scaled = (interval, x, y, *layouts[6].fields[1:])
        self.ranges = np.array([(f.scale, f.offset, f.low, f.high) for f in scaled])
        self.interval = interval.scale, interval.offset
        self.pose = [(f.scale, f.offset) for f in scaled[1:]]


@cache
def wire() -> Wire:
    """Looked up once."""
    return Wire()


class SetpointReader:
    """Reads the set-points of so many joints.

    Attributes:
        angles_rad: (joints,) of the set-point read last; the next one overwrites it.
    """

    def __init__(self, joints: int) -> None:
        self._wire = wire()
        self._raw = np.zeros(3 * groups(joints), np.int64)
        self.angles_rad: Floats = np.zeros(joints)

    def read(self, data: bytes) -> tuple[int, float] | None:
        """Sequence number and interval (s) of the set-point that these bytes are; None: they are anything else."""
        wire = self._wire
        found = tick_kernels.read_setpoint(data, wire.signals, self._raw, self.angles_rad)
        if found < 0:
            return None
        scale, offset = wire.interval
        return found >> 8, (found & 0xFF) * scale + offset


class SetpointWriter:
    """Writes the set-points of so many joints."""

    def __init__(self, joints: int) -> None:
        self._wire = wire()
        self._joints, self._frames = joints, groups(joints) + 1
        self._angles, self._raw = np.zeros(joints), np.zeros(3 * groups(joints), np.int64)
        self._buffer = bytearray(1 + tick_kernels.PACKET_BYTES * self._frames)
        self._out = np.frombuffer(self._buffer, np.uint8)

    def write(
        self, sequence: int, angles_rad: Sequence[float], interval_s: float
    ) -> tuple[Packed, tuple[float, ...]] | None:
        """The frames of a set-point, and its angles as the wire carries them; None: something does not fit."""
        if len(angles_rad) != self._joints:
            return None
        self._angles[:] = angles_rad
        wire, raw = self._wire, self._raw
        size = tick_kernels.write_setpoint(
            self._out, wire.signals, wire.ranges, sequence, interval_s, self._angles, raw
        )
        if size < 0:
            return None
        carried = tuple([angle * ANGLE_STEP_RAD for angle in raw.tolist()[: self._joints]])
        return Packed(bytes(self._buffer), self._frames), carried


class WholeAnswer(NamedTuple):
    """What a board answers: a sample, and x, y (m), heading (rad) and speed (m/s) where it tells its pose."""

    sample: Sample
    pose: tuple[float, ...] | None


class AnswerReader:
    """Reads the answers of a board with so many joints."""

    def __init__(self, joints: int) -> None:
        self._joints = joints
        self._wire = wire()
        self._state, self._pose = np.zeros(4, np.int64), np.zeros(4, np.int64)
        self._counts, self._applied = np.zeros((2, 3 * groups(joints)), np.int64)

    def read(self, data: bytes) -> WholeAnswer | None:
        """The answer that these bytes are; None: they are anything else."""
        found = tick_kernels.read_answer(
            data, self._wire.signals, self._state, self._counts, self._applied, self._pose
        )
        if found < 0:
            return None
        sequence, number, mode_number, board_time_us = self._state.tolist()
        mode = _MODES.get(mode_number)
        if mode is None:
            return None
        counts, applied = self._counts.tolist()[: self._joints], self._applied.tolist()[: self._joints]
        sample = Sample(
            State(sequence, number, mode, board_time_us),
            tuple([None if count == NO_READING else count for count in counts]),
            tuple([angle * ANGLE_STEP_RAD for angle in applied]),
        )
        if found == 1:
            return WholeAnswer(sample, None)
        scaled = zip(self._pose.tolist(), self._wire.pose, strict=True)
        return WholeAnswer(sample, tuple([raw * scale + offset for raw, (scale, offset) in scaled]))


class AnswerWriter:
    """Writes the answers of a board with so many joints."""

    def __init__(self, joints: int) -> None:
        self._wire = wire()
        self._counts, self._raw = np.zeros((2, 3 * groups(joints)), np.int64)
        self._counts[joints:] = NO_READING
        self._measured = self._counts[:joints]
        self._buffer = bytearray(1 + tick_kernels.PACKET_BYTES * (1 + 2 * groups(joints) + 2))
        self._out, self._view = np.frombuffer(self._buffer, np.uint8), memoryview(self._buffer)

    def write(
        self,
        state: tuple[int, int, int, int],
        counts: Sequence[int | None],
        servo_rad: Floats,
        trim_rad: Floats,
        pose: tuple[float, float, float, float] | None,
    ) -> Packed:
        """The frames of a sample and of the pose after it.

        Counts beyond 16 bits are reported as no reading: a wrong angle would be worse than none. A joint without power
        may be anywhere: its applied angle stays at the edge of what the wire carries. A pose that has left the range of
        the wire is left out.

        Args:
            state: sequence, sample, mode and board time, each within its bits.
            servo_rad, trim_rad: (joints,) what servos are told, and the part of it that is trim.

        Raises:
            ProtocolError: an applied angle is no number.
        """
        self._measured[:] = [
            NO_READING if count is None or abs(count) > LARGEST else count for count in counts
        ]
        wire = self._wire
        sequence, sample, mode, board_time_us = state
        size = tick_kernels.write_answer(  # int: a call with an enumeration's item takes ten times as long
            self._out, wire.signals, wire.ranges, sequence, sample, int(mode), board_time_us, self._counts,
            servo_rad, trim_rad, self._raw, *(pose or _NO_POSE),
        )  # fmt: skip
        if size < 0:
            raise ProtocolError(f"{math.nan} is no angle")
        return Packed(bytes(self._view[:size]), size // tick_kernels.PACKET_BYTES)
