"""Set-points on their way to a board: numbered, and made into frames before they are due."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from firmware_protocol.assembly import ANGLE_STEP_RAD, SEQUENCE_MASK, raw_angles, setpoint_frames
from firmware_protocol.frame import Frame

if TYPE_CHECKING:
    from firmware_protocol.whole_tick import SetpointWriter


class MadeSetpoint(NamedTuple):
    """One tick's set-point, ready to be sent."""

    sequence: int
    angles_rad: tuple[float, ...]  # as the wire carries them
    frames: Sequence[Frame]


class Numbering:
    """Gives set-points their numbers: one that is made and not sent leaves its number to the next."""

    def __init__(self) -> None:
        self._sent = secrets.randbelow(SEQUENCE_MASK + 1)
        self._writer: SetpointWriter | None = None

    def quicken(self, joints: int) -> None:
        """From now on the set-points of so many joints are made by compiled code."""
        from firmware_protocol.whole_tick import SetpointWriter  # brings the compiler in

        self._writer = SetpointWriter(joints)

    def make(self, angles_rad: Sequence[float], interval_s: float) -> MadeSetpoint:
        """The frames of a set-point that follows the one sent last.

        Raises:
            ProtocolError: an angle is not a number or beyond what the wire carries.
        """
        sequence = (self._sent + 1) & SEQUENCE_MASK
        if self._writer is not None:
            written = self._writer.write(sequence, angles_rad, interval_s)
            if written is not None:
                return MadeSetpoint(sequence, written[1], written[0])
        raw = raw_angles(angles_rad)
        frames = setpoint_frames(sequence, raw, interval_s)
        return MadeSetpoint(sequence, tuple([angle * ANGLE_STEP_RAD for angle in raw]), frames)

    def sent(self, made: MadeSetpoint) -> None:
        """This one is on its way."""
        self._sent = made.sequence
