"""What ``whole_tick`` does byte by byte, compiled: COBS, both checks, bit positions, and what makes a tick whole.

Nothing here keeps anything from one call to the next. Where signals are is handed in as ``wire`` (``whole_tick.Wire``
takes it from the DBC): a row a message with its identifier, its length in bytes, and start and length in bits of each
signal in the order of the fields. All integers are int64; a payload is its bytes as one little-endian integer.

Importing compiles, or loads what was compiled before.
"""

from __future__ import annotations

import binascii
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numba import njit, types

SETPOINT, LATCH, STATE, MEASURED, APPLIED, POSITION, MOTION = range(7)  # rows of ``wire``
GROUP = 3  # joints a frame
PACKET_BYTES = 14  # of a frame with eight bytes: COBS makes 13 of its 12, and one zero ends it

_LARGEST = 32767  # integer of an angle or a count on the wire
_STEP_RAD = 1e-4  # of an angle, as in the DBC
_SHORT = 0xFFF  # what a group frame keeps of a sequence number

_CRC16 = np.array([binascii.crc_hqx(bytes([byte]), 0) for byte in range(256)], dtype=np.int64)


def _crc32_row(byte: int) -> int:
    """CRC-32 of IEEE 802.3, reflected: polynomial 0xEDB88320."""
    for _ in range(8):
        byte = byte >> 1 ^ (0xEDB88320 if byte & 1 else 0)
    return byte


_CRC32 = np.array([_crc32_row(byte) for byte in range(256)], dtype=np.int64)

_BYTES = types.Bytes(types.uint8, 1, "C")
_INT64, _FLOAT64 = types.int64, types.float64
_OUT = types.Array(types.uint8, 1, "C")
_INTS, _TABLE = types.Array(_INT64, 1, "C"), types.Array(_INT64, 2, "C")
_FLOATS, _RANGES = types.Array(_FLOAT64, 1, "C"), types.Array(_FLOAT64, 2, "C")

_F = TypeVar("_F", bound=Callable[..., Any])


def _part(function: _F) -> _F:
    """A part of a kernel: compiled with it, and types as Python sees them."""
    compiled: _F = njit(function)
    return compiled


@_part
def _mask(length: int) -> int:
    return (1 << length) - 1


@_part
def _get(payload: int, wire: Any, row: int, field: int) -> int:
    bits: int = (payload >> wire[row, 2 + 2 * field]) & _mask(wire[row, 3 + 2 * field])
    return bits


@_part
def _get_signed(payload: int, wire: Any, row: int, field: int) -> int:
    sign: int = 1 << (wire[row, 3 + 2 * field] - 1)
    return (_get(payload, wire, row, field) ^ sign) - sign


@_part
def _put(value: int, wire: Any, row: int, field: int) -> int:
    bits: int = (value & _mask(wire[row, 3 + 2 * field])) << wire[row, 2 + 2 * field]
    return bits


@_part
def _int(number: Any) -> int:
    """As int64: an unsigned byte beside one would become a float."""
    whole: int = np.int64(number)  # type: ignore[assignment]  # the compiler's int
    return whole


@_part
def _ends(data: Any, at: int) -> int:
    """Where the packet that begins at ``at`` has its zero; the length of the data where it has none."""
    while at < len(data) and data[at] != 0:
        at += 1
    return at


@_part
def _packet(data: Any, at: int, end: int) -> tuple[int, int, int]:
    """Identifier (-1: no packet), length and payload of the COBS bytes from ``at`` to ``end``; none of them is zero."""
    head, payload, tail = 0, 0, 0  # bytes 0 and 1; the next eight; the last two of a full packet
    size = 0
    while at < end:
        code = _int(data[at])
        stop = at + code
        if stop > end:
            return -1, 0, 0
        at += 1
        while at <= stop:
            if at < stop:
                byte = _int(data[at])
            elif stop == end or code == 255:
                break
            else:
                byte = 0
            if size < 2:
                head |= byte << (8 * size)
            elif size < 10:
                payload |= byte << (8 * (size - 2))
            elif size < 12:
                tail |= byte << (8 * (size - 10))
            else:
                return -1, 0, 0
            size += 1
            at += 1
        at = stop
    if size < 4 or head > 0x7FF:
        return -1, 0, 0
    length = size - 4
    crc = 0xFFFF
    crc = (crc << 8 & 0xFF00) ^ _CRC16[crc >> 8 ^ head & 0xFF]
    crc = (crc << 8 & 0xFF00) ^ _CRC16[crc >> 8 ^ head >> 8]
    for byte_number in range(length):
        crc = (crc << 8 & 0xFF00) ^ _CRC16[crc >> 8 ^ (payload >> (8 * byte_number) & 0xFF)]
    if length == 8:
        said = tail
    elif length == 7:
        said = (payload >> 56 & 0xFF) | (tail & 0xFF) << 8
    else:
        said = payload >> (8 * length) & 0xFFFF
    if said != crc:
        return -1, 0, 0
    if length < 8:
        payload &= _mask(8 * length)
    return head, length, payload


@_part
def _crc32_of(crc: int, value: int, size: int) -> int:
    """Go on with the low bytes of a value."""
    for number in range(size):
        crc = crc >> 8 ^ _CRC32[(crc ^ value >> (8 * number)) & 0xFF]
    return crc


@_part
def _setpoint_crc(sequence: int, raw: Any, joints: int) -> int:
    crc = _crc32_of(0xFFFFFFFF, sequence, 2)
    crc = _crc32_of(crc, joints, 1)
    for joint in range(joints):
        crc = _crc32_of(crc, raw[joint], 2)
    return crc ^ 0xFFFFFFFF


@njit(_INT64(_BYTES), cache=True)
def count(data: Any) -> int:
    """How many packets these are, all undamaged and the last one ended; -1 where that is not so."""
    frames, at = 0, 0
    while at < len(data):
        end = _ends(data, at)
        if end == len(data):
            return -1
        if end > at:
            if _packet(data, at, end)[0] < 0:
                return -1
            frames += 1
        at = end + 1
    return frames


@_part
def _take_group(payload: int, wire: Any, row: int, seen: int, raw: Any) -> int:
    """Put the joints of a group frame into ``raw``; groups ``seen`` with it, -1 where it is no group or one again."""
    group = _get(payload, wire, row, 1)
    if group >= raw.size // GROUP or seen >> group & 1:
        return -1
    for joint in range(GROUP):
        raw[GROUP * group + joint] = _get_signed(payload, wire, row, 2 + joint)
    return seen | 1 << group


@njit(_INT64(_BYTES, _TABLE, _INTS, _FLOATS), cache=True)
def read_setpoint(data: Any, wire: Any, raw: Any, angles: Any) -> int:
    """One set-point of all joints, nothing missing and nothing else.

    Args:
        raw: (3 a group,) gets the angles as integers, in the steps of the wire.
        angles: (joints,) gets the angles, rad.

    Returns:
        256 x its sequence number + the interval in steps of the wire; -1 where the data are anything else.
    """
    groups, joints = raw.size // GROUP, angles.size
    seen, latch, number, at = 0, -1, -1, 0
    while at < len(data):
        end = _ends(data, at)
        if end == len(data):
            return -1
        if end > at:
            identifier, length, payload = _packet(data, at, end)
            if identifier == wire[SETPOINT, 0]:
                row = SETPOINT
                seen = _take_group(payload, wire, row, seen, raw)
                if seen < 0:
                    return -1
            elif identifier == wire[LATCH, 0] and latch < 0:
                row = LATCH
                latch = _get(payload, wire, row, 0) << 8 | _get(payload, wire, row, 2)
                if _get(payload, wire, row, 1) != joints:
                    return -1
                crc = _get(payload, wire, row, 3)
            else:
                return -1
            if length != wire[row, 1]:
                return -1
            its = _get(payload, wire, row, 0) & _SHORT
            if number >= 0 and its != number:
                return -1
            number = its
        at = end + 1
    if latch < 0 or seen != _mask(groups) or _setpoint_crc(latch >> 8, raw, joints) != crc:
        return -1
    for joint in range(joints):
        angles[joint] = raw[joint] * _STEP_RAD
    return latch


@njit(_INT64(_BYTES, _TABLE, _INTS, _INTS, _INTS, _INTS), cache=True)
def read_answer(data: Any, wire: Any, state: Any, counts: Any, applied: Any, pose: Any) -> int:
    """One sample of all joints, perhaps with the pose after it, nothing missing and nothing else.

    Args:
        state: (4,) gets sequence, sample, mode and board time.
        counts, applied: (3 a group,) get what was measured and applied, as on the wire.
        pose: (4,) gets x, y, heading and speed, as on the wire.

    Returns:
        2: with a pose, 1: without, -1: the data are anything else.
    """
    groups = counts.size // GROUP
    seen_measured, seen_applied, seen_state, number, at = 0, 0, 0, -1, 0
    whole, poses = False, 0
    while at < len(data):
        end = _ends(data, at)
        if end == len(data):
            return -1
        if end > at:
            identifier, length, payload = _packet(data, at, end)
            number_field = 0
            if not whole:
                if identifier == wire[STATE, 0] and seen_state == 0:
                    row, number_field, seen_state = STATE, 1, 1
                    for field in range(4):
                        state[field] = _get(payload, wire, row, field)
                elif identifier == wire[MEASURED, 0]:
                    row = MEASURED
                    seen_measured = _take_group(payload, wire, row, seen_measured, counts)
                    if seen_measured < 0:
                        return -1
                elif identifier == wire[APPLIED, 0]:
                    row = APPLIED
                    seen_applied = _take_group(payload, wire, row, seen_applied, applied)
                    if seen_applied < 0:
                        return -1
                else:
                    return -1
                all_groups = _mask(groups)
                whole = seen_state == 1 and seen_measured == all_groups and seen_applied == all_groups
            elif poses < 2 and identifier == wire[POSITION + poses, 0]:
                row = POSITION + poses
                for field in range(2):
                    pose[2 * poses + field] = _get_signed(payload, wire, row, 1 + field)
                poses += 1
            else:
                return -1
            if length != wire[row, 1]:
                return -1
            its = _get(payload, wire, row, number_field)
            if number >= 0 and its != number:
                return -1
            number = its
        at = end + 1
    if not whole or poses == 1:
        return -1
    return 1 + poses // 2


@_part
def _emit(out: Any, at: int, identifier: int, payload: int) -> int:
    """A frame with eight bytes as one packet; where the next one goes."""
    crc = 0xFFFF
    code_at, code = at, 1
    at += 1
    for number in range(12):
        if number < 2:
            byte = identifier >> (8 * number) & 0xFF
        elif number < 10:
            byte = payload >> (8 * (number - 2)) & 0xFF
        else:
            byte = crc >> (8 * (number - 10)) & 0xFF
        if number < 10:
            crc = (crc << 8 & 0xFF00) ^ _CRC16[crc >> 8 ^ byte]
        if byte == 0:
            out[code_at] = code
            code_at, code = at, 1
        else:
            out[at] = byte
            code += 1
        at += 1
    out[code_at] = code
    out[at] = 0
    return at + 1


@_part
def _fits(value: float, ranges: Any, row: int) -> bool:
    fits: bool = ranges[row, 2] <= value <= ranges[row, 3]
    return fits


@_part
def _raw(value: float, ranges: Any, row: int) -> int:
    return _int(np.rint((value - ranges[row, 1]) / ranges[row, 0]))


@njit(_INT64(_OUT, _TABLE, _RANGES, _INT64, _FLOAT64, _FLOATS, _INTS), cache=True)
def write_setpoint(
    out: Any, wire: Any, ranges: Any, sequence: int, interval_s: float, angles: Any, raw: Any
) -> int:
    """One set-point as the bytes of one write.

    Args:
        out: gets the bytes.
        ranges: row 0: scale, offset, lowest and highest of the interval.
        angles: (joints,) rad.
        raw: (3 a group,) gets the angles as integers; what is beyond the joints stays as it is, zero.

    Returns:
        How many bytes they are; -1: an angle or the interval is none that the wire carries.
    """
    if not _fits(interval_s, ranges, 0):
        return -1
    for joint in range(angles.size):
        steps = angles[joint] / _STEP_RAD
        if not abs(np.rint(steps)) <= _LARGEST:
            return -1
        raw[joint] = np.int64(np.rint(steps))
    out[0] = 0
    at = 1
    for group in range(raw.size // GROUP):
        payload = _put(sequence, wire, SETPOINT, 0) | _put(group, wire, SETPOINT, 1)
        for joint in range(GROUP):
            payload |= _put(raw[GROUP * group + joint], wire, SETPOINT, 2 + joint)
        at = _emit(out, at, wire[SETPOINT, 0], payload)
    payload = _put(sequence, wire, LATCH, 0) | _put(angles.size, wire, LATCH, 1)
    payload |= _put(_raw(interval_s, ranges, 0), wire, LATCH, 2)
    payload |= _put(_setpoint_crc(sequence, raw, angles.size), wire, LATCH, 3)
    return _emit(out, at, wire[LATCH, 0], payload)


@_part
def _emit_groups(out: Any, at: int, wire: Any, row: int, sample: int, raw: Any) -> int:
    for group in range(raw.size // GROUP):
        payload = _put(sample, wire, row, 0) | _put(group, wire, row, 1)
        for joint in range(GROUP):
            payload |= _put(raw[GROUP * group + joint], wire, row, 2 + joint)
        at = _emit(out, at, wire[row, 0], payload)
    return at


@njit(
    _INT64(
        _OUT,
        _TABLE,
        _RANGES,
        _INT64,
        _INT64,
        _INT64,
        _INT64,
        _INTS,
        _FLOATS,
        _FLOATS,
        _INTS,
        _FLOAT64,
        _FLOAT64,
        _FLOAT64,
        _FLOAT64,
    ),
    cache=True,
)
def write_answer(
    out: Any, wire: Any, ranges: Any, sequence: int, sample: int, mode: int, time_us: int,
    counts: Any, servo: Any, trim: Any, raw: Any, x: float, y: float, heading: float, speed: float,
) -> int:  # fmt: skip
    """One sample, with its pose, as the bytes of one write.

    Args:
        out: gets the bytes.
        ranges: scale, offset, lowest and highest of (interval,) x, y, heading and speed.
        sequence, sample, mode, time_us: of the state.
        counts: (3 a group,) what was measured, each within 16 bits.
        servo, trim: (joints,) rad; their difference is what is applied. Beyond the wire it stays at the edge.
        raw: (3 a group,) scratch; zero beyond the joints.
        x, y, heading, speed: the pose; left out where one of them is beyond the wire, or NaN.

    Returns:
        How many bytes they are; -1: an applied angle is no number.
    """
    most = _LARGEST * _STEP_RAD
    for joint in range(servo.size):
        angle = servo[joint] - trim[joint]
        if np.isnan(angle):
            return -1
        raw[joint] = np.int64(np.rint(min(max(angle, -most), most) / _STEP_RAD))
    out[0] = 0
    payload = _put(sequence, wire, STATE, 0) | _put(sample, wire, STATE, 1)
    payload |= _put(mode, wire, STATE, 2) | _put(time_us, wire, STATE, 3)
    at = _emit(out, 1, wire[STATE, 0], payload)
    at = _emit_groups(out, at, wire, MEASURED, sample, counts)
    at = _emit_groups(out, at, wire, APPLIED, sample, raw)
    if not (
        _fits(x, ranges, 1) and _fits(y, ranges, 2) and _fits(heading, ranges, 3) and _fits(speed, ranges, 4)
    ):
        return at
    payload = _put(sample, wire, POSITION, 0) | _put(_raw(x, ranges, 1), wire, POSITION, 1)
    payload |= _put(_raw(y, ranges, 2), wire, POSITION, 2)
    at = _emit(out, at, wire[POSITION, 0], payload)
    payload = _put(sample, wire, MOTION, 0) | _put(_raw(heading, ranges, 3), wire, MOTION, 1)
    payload |= _put(_raw(speed, ranges, 4), wire, MOTION, 2)
    return _emit(out, at, wire[MOTION, 0], payload)
