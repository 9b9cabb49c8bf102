"""What every link is: frames out, frames in, and an end."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
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

    Args:
        port: how the link calls itself.
        frames_per_s: how many frames of eight bytes the wire carries at most (see ``snakebot.links.capacity``);
            infinity where no wire limits them.
    """

    def __init__(self, port: str, frames_per_s: float) -> None:
        self.port = port
        self.frames_per_s = frames_per_s
        self.statistics = LinkStatistics()

    @abstractmethod
    def send(self, frames: Sequence[Frame]) -> None:
        """Hand all frames to the wire in one write."""

    @abstractmethod
    def receive(self, timeout_s: float) -> Sequence[Frame]:
        """Wait up to ``timeout_s`` for the first frame, then return all that are there, in order."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the wire. Closing twice does no harm."""

    def about(self) -> Mapping[str, object]:
        """What the log of a run over this link says of it besides its port, as JSON can carry it."""
        return {}

    def counters(self) -> Mapping[str, float]:
        """Further counts for the log, by name: those of a bus behind a board in this process."""
        return {}

    def check_rate(self, rate_hz: float) -> None:  # noqa: B027 - most have nothing behind them
        """Called before a run of so many ticks a second; what frames take of the wire is not looked at here.

        Raises:
            BadInputError: what is behind this link cannot keep that rate.
        """

    def quicken(self) -> None:  # noqa: B027 - most have nothing to gain
        """Called before a run: from now on what each tick needs is done by compiled code, where there is any."""

    def warnings(self) -> Sequence[str]:
        """What whoever is about to move the joints should read, a line each."""
        return ()

    def told(self) -> str:
        """How the link was so far, in one line; empty where the summary of a run says it all."""
        return ""

    def __enter__(self) -> Link:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
