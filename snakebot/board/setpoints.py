"""Set-points on their way to a board: numbered, and made into frames before they are due."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from typing import NamedTuple

from firmware_protocol.assembly import ANGLE_STEP_RAD, SEQUENCE_MASK, raw_angles, setpoint_frames
from firmware_protocol.frame import Frame


class MadeSetpoint(NamedTuple):
    """One tick's set-point, ready to be sent."""

    sequence: int
    angles_rad: tuple[float, ...]  # as the wire carries them
    frames: list[Frame]


class Numbering:
    """Gives set-points their numbers: one that is made and not sent leaves its number to the next."""

    def __init__(self) -> None:
        self._sent = secrets.randbelow(SEQUENCE_MASK + 1)

    def make(self, angles_rad: Sequence[float], interval_s: float) -> MadeSetpoint:
        """The frames of a set-point that follows the one sent last.

        Raises:
            ProtocolError: an angle is not a number or beyond what the wire carries.
        """
        sequence, raw = (self._sent + 1) & SEQUENCE_MASK, raw_angles(angles_rad)
        frames = setpoint_frames(sequence, raw, interval_s)
        return MadeSetpoint(sequence, tuple([angle * ANGLE_STEP_RAD for angle in raw]), frames)

    def sent(self, made: MadeSetpoint) -> None:
        """This one is on its way."""
        self._sent = made.sequence
