"""What every link is: frames out, frames in, and an end."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType

from firmware_protocol.frame import Frame


@dataclass(slots=True)
class LinkStatistics:
    """Counted since the link was opened."""

    sent: int = 0  # frames
    received: int = 0  # frames
    corrupt: int = 0  # packets dropped by the link's own check
    bytes_sent: int = 0
    bytes_received: int = 0


class Link(ABC):
    """One wire to one board (or, on a bus, to whoever is there). Used from one thread.

    ``send`` and ``receive`` raise LostBoardError once the wire is gone. Nothing is re-sent.
    """

    def __init__(self, port: str) -> None:
        self.port = port
        self.frames_per_s = (
            7700.0  # what the wire carries at most: a serial line of 1 Mbaud, a bus of 1 Mbit/s
        )
        self.statistics = LinkStatistics()

    @abstractmethod
    def send(self, frames: Sequence[Frame]) -> None:
        """Hand all frames to the wire in one write."""

    @abstractmethod
    def receive(self, timeout_s: float) -> list[Frame]:
        """Wait up to ``timeout_s`` for the first frame, then return all that are there, in order."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the wire. Closing twice does no harm."""

    def __enter__(self) -> Link:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
