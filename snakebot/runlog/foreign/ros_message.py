"""What a bag holds, however it is stored: topics, and messages in CDR."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

MAX_BAG_MESSAGE_BYTES = 1 << 20  # chosen: a joint state has some hundred


@dataclass(frozen=True)
class Topic:
    name: str
    kind: str  # package/msg/Type
    definition: str | None  # as ros2msg; None where the bag does not hold it
    encoding: str = "cdr"


class BagMessage(NamedTuple):
    topic: str
    time_ns: int
    data: bytes
