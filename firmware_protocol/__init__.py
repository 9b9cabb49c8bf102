"""What host and board agree on: messages, framing, set-point and sample assembly. Imports nothing of snakebot."""

from __future__ import annotations

from firmware_protocol.frame import Frame, ProtocolError

__all__ = ["Frame", "ProtocolError"]
