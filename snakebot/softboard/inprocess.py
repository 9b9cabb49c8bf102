"""A link to a simulated board in this process. It carries the same bytes as a serial line.

On a ``VirtualClock`` a wait costs nothing: ``receive`` moves the clock to the board's next event or to the end of the
wait, so that a run takes as long as its computation and comes out the same each time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from firmware_protocol.frame import Frame
from firmware_protocol.framing import StreamDecoder, pack_all
from snakebot.clock import Clock
from snakebot.errors import LostBoardError
from snakebot.links.base import Link
from snakebot.softboard.board import SoftBoard

BoardWire = Callable[[bytes], bytes]


def _clean(data: bytes) -> bytes:
    return data


class InProcessLink(Link):
    """Both ends of a wire and the board behind it, for one thread.

    Args:
        board: what answers.
        clock: ``MonotonicClock`` for real time, ``VirtualClock`` for as fast as it computes.
        port: how the link calls itself.
        about: what the log of a run over this link says of the board.
        to_board, to_host: what the wire makes of the bytes that it carries; tests put noise here.
    """

    def __init__(
        self,
        board: SoftBoard,
        clock: Clock,
        port: str = "sim:",
        *,
        about: Mapping[str, object] | None = None,
        to_board: BoardWire = _clean,
        to_host: BoardWire = _clean,
    ) -> None:
        super().__init__(port, math.inf)
        self.board = board
        self.clock = clock
        self._about = dict(about or {})
        self._to_board = to_board
        self._to_host = to_host
        self._board_side = StreamDecoder().quicken()
        self._host_side = StreamDecoder().quicken()
        self._plugged = True

    def about(self) -> Mapping[str, object]:
        return self._about

    def unplug(self) -> None:
        """Pull the cable: every further use raises, and the board is left to its watchdog."""
        self._plugged = False

    def close(self) -> None:
        self._plugged = False

    def send(self, frames: Sequence[Frame]) -> None:
        self._check()
        data = pack_all(frames)
        self.statistics.sent += len(frames)
        self.statistics.bytes_sent += len(data)
        now_s = self.clock.now_s()
        corrupt = self._board_side.corrupt
        self.board.take(self._board_side.feed(self._to_board(data)), now_s)
        self.board.note_corrupt(self._board_side.corrupt - corrupt)

    def receive(self, timeout_s: float) -> Sequence[Frame]:
        self._check()
        now_s = self.clock.now_s()
        deadline_s = now_s + timeout_s
        while True:
            frames = self._collect(now_s)
            if frames or now_s >= deadline_s:
                return frames
            self.board.integrate(now_s)
            self.clock.sleep_until(min(self.board.next_event_s, deadline_s))
            now_s = self.clock.now_s()

    def _collect(self, now_s: float) -> Sequence[Frame]:
        said = self.board.advance(now_s)
        if not said:
            return []
        data = self._to_host(pack_all(said))
        frames = self._host_side.feed(data)
        self.statistics.received += len(frames)
        self.statistics.bytes_received += len(data)
        self.statistics.corrupt = self._host_side.corrupt
        return frames

    def _check(self) -> None:
        if not self._plugged:
            raise LostBoardError(f"{self.port}: the link to the simulated board is closed")
