"""A stop that another thread asks for does not wait for the wait for frames to end."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest

from firmware_protocol.catalogue import EmergencyStop, decode
from firmware_protocol.frame import Frame
from snakebot.board import Board
from snakebot.clock import VirtualClock
from snakebot.errors import BoardFaultError
from snakebot.links import Link


class SilentLink(Link):
    """Nothing comes in; after some waiting somebody else asks for the stop."""

    def __init__(self, clock: VirtualClock, asked_at_s: float) -> None:
        super().__init__("silent:", math.inf)
        self.board: Board | None = None
        self.sent: list[tuple[float, Frame]] = []
        self._clock, self._asked_at_s = clock, asked_at_s

    def send(self, frames: Sequence[Frame]) -> None:
        self.sent += [(self._clock.now_s(), frame) for frame in frames]

    def receive(self, timeout_s: float) -> list[Frame]:
        before_s = self._clock.now_s()
        self._clock.sleep_until(before_s + timeout_s)
        if before_s <= self._asked_at_s < self._clock.now_s():
            assert self.board is not None
            self.board.request_emergency_stop()
        return []

    def close(self) -> None:
        pass


@pytest.mark.parametrize("asked_at_s", [0.001, 0.0123, 0.041])
def test_it_is_sent_within_ten_milliseconds_at_the_lowest_rate_too(asked_at_s: float) -> None:
    clock = VirtualClock()
    link = SilentLink(clock, asked_at_s)
    link.board = board = Board(link, clock)
    with pytest.raises(BoardFaultError, match="emergency stop"):
        board.poll(0.05)
        board.poll(0.0)  # asked for in the last piece: the next look is at once
    stops = [at_s for at_s, frame in link.sent if isinstance(decode(frame), EmergencyStop)]
    assert len(stops) == 3
    assert asked_at_s <= stops[0] <= asked_at_s + 0.0101


def test_a_wait_is_not_longer_than_it_was_asked_to_be() -> None:
    clock = VirtualClock()
    board = Board(SilentLink(clock, 1e9), clock)
    for timeout_s in (0.0, 0.003, 0.01, 0.0497):
        before_s = clock.now_s()
        board.poll(timeout_s)
        assert clock.now_s() - before_s == pytest.approx(timeout_s, abs=1e-9)
