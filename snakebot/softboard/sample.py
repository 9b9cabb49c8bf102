"""The frames of one sample of a simulated board: state, readings, register and pose."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.assembly import ANGLE_STEP_RAD, LARGEST, sample_frames
from firmware_protocol.catalogue import PoseMotion, PosePosition, State, encode_values
from firmware_protocol.frame import Frame, ProtocolError

_WIRE_ANGLE_RAD = LARGEST * ANGLE_STEP_RAD


def frames_of(
    state: State,
    counts: Sequence[int | None],
    applied_rad: Sequence[float],
    pose: tuple[float, float, float, float] | None,
) -> list[Frame]:
    """What the board reports; ``pose`` is x, y (m), heading (rad) and speed (m/s)."""
    if max(map(abs, applied_rad)) > _WIRE_ANGLE_RAD:  # a joint without power may be anywhere
        applied_rad = [min(max(angle, -_WIRE_ANGLE_RAD), _WIRE_ANGLE_RAD) for angle in applied_rad]
    frames = sample_frames(state, counts, applied_rad)
    if pose is None:
        return frames
    x_m, y_m, heading_rad, speed_m_s = pose
    try:
        return [
            *frames,
            encode_values(PosePosition, state.sample, x_m, y_m),
            encode_values(PoseMotion, state.sample, heading_rad, speed_m_s),
        ]
    except ProtocolError:
        return frames  # it has left the range of the wire: no pose is better than a wrong one
