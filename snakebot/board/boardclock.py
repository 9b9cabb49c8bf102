"""The board's clock seen from the host: unwrapped, and its offset and drift estimated from round trips."""

from __future__ import annotations

from collections import deque

_WRAP = 1 << 32  # us: a board's clock is a 32-bit counter (PROTOCOL.md)
_WINDOW = 64  # round trips that are remembered
_TRUSTED = 8  # shortest round trips that are used: the others waited somewhere on one leg


class BoardClock:
    """Unwraps 32-bit microseconds and maps board time to host time.

    A round trip that was sent at t0 and answered at t1 says that the board's stamp belongs to (t0 + t1) / 2, give or
    take half the round trip; the shortest round trips say it best.
    """

    def __init__(self) -> None:
        self._last_us: int | None = None
        self._trips: deque[tuple[float, float, int]] = deque(
            maxlen=_WINDOW
        )  # round trip s, host mid s, board us

    def unwrap(self, board_time_us: int) -> int:
        """Microseconds that go on rising over a wrap. Steps of less than 35 minutes either way are understood."""
        if self._last_us is None:
            self._last_us = board_time_us
            return board_time_us
        step = (board_time_us - self._last_us + _WRAP // 2) % _WRAP - _WRAP // 2
        unwrapped = self._last_us + step
        self._last_us = max(self._last_us, unwrapped)
        return unwrapped

    def round_trip(self, sent_s: float, answered_s: float, board_us: int) -> None:
        """Add one round trip; ``board_us`` is unwrapped."""
        self._trips.append((answered_s - sent_s, (sent_s + answered_s) / 2, board_us))

    def _trusted(self) -> list[tuple[float, float, int]]:
        """The shortest round trips; where they crowd together, the shortest of each part of the window instead."""
        best = sorted(self._trips)[:_TRUSTED]
        trips = list(self._trips)
        crowded = max(mid for _, mid, _ in best) - min(mid for _, mid, _ in best) < 1.0
        if not crowded or trips[-1][1] - trips[0][1] < 1.0:
            return best
        part = -(-len(trips) // _TRUSTED)
        return [min(trips[start : start + part]) for start in range(0, len(trips), part)]

    def estimate(self) -> tuple[float, float] | None:
        """(offset in s of board time zero on the host's clock, drift of the board's clock in ppm), or None.

        The drift is known only when the trusted round trips span at least a second; before that it is zero.
        """
        if not self._trips:
            return None
        best = self._trusted()
        host = [mid for _, mid, _ in best]
        board = [us * 1e-6 for *_, us in best]
        mean_host, mean_board = sum(host) / len(host), sum(board) / len(board)
        span = max(board) - min(board)
        rate = 1.0
        if span >= 1.0:
            spread = sum((b - mean_board) ** 2 for b in board)
            rate = sum((b - mean_board) * (h - mean_host) for b, h in zip(board, host, strict=True)) / spread
        return mean_host - rate * mean_board, (1.0 / rate - 1.0) * 1e6
