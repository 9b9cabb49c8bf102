"""One frame, as CAN carries it and as a serial line wraps it."""

from __future__ import annotations

from typing import NamedTuple


class Frame(NamedTuple):
    """An 11-bit identifier and 0 to 8 bytes."""

    id: int
    data: bytes

    def __str__(self) -> str:
        return f"{self.id:03X}#{self.data.hex().upper()}"


class ProtocolError(ValueError):
    """Bytes that are no frame, a frame that is no message, or values that a message cannot carry."""
