"""What goes between a run and the process that serves its page: one packet a record.

A packet is the channel's number (the log's own, or ``STATUS``), the record's time and JSON: the record as it stands in
the log, so that nothing is encoded twice.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import orjson

STATUS = 0  # not in the log: what the run says of itself, and what is asked of it
_HEAD = struct.Struct("<BQ")


@dataclass(frozen=True, slots=True)
class ViewPacket:
    """One record: ``data`` is JSON."""

    channel_id: int
    log_time_ns: int
    data: bytes

    def values(self) -> dict[str, Any]:
        """The record's fields.

        Raises:
            ValueError: not a JSON object.
        """
        found = orjson.loads(self.data)
        if not isinstance(found, dict):
            raise ValueError("not a JSON object")
        return found


def pack(channel_id: int, log_time_ns: int, data: bytes | Mapping[str, Any]) -> bytes:
    """One packet."""
    text = data if isinstance(data, bytes) else orjson.dumps(dict(data))
    return _HEAD.pack(channel_id, log_time_ns) + text


def unpack(packet: bytes) -> ViewPacket:
    """
    Raises:
        ValueError: too short for a packet; an empty one means that the other end has gone.
    """
    if len(packet) < _HEAD.size:
        raise ValueError("the other end has gone" if not packet else "a torn packet")
    channel_id, log_time_ns = _HEAD.unpack_from(packet)
    return ViewPacket(channel_id, log_time_ns, packet[_HEAD.size :])
