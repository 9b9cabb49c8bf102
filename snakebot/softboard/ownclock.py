"""The board's own clock: it starts at a reset, runs a little fast or slow, and wraps at 32 bits of microseconds."""

from __future__ import annotations

_MASK = 0xFFFFFFFF  # the board's clock has 32 bits of us (PROTOCOL.md)


class OwnClock:
    """Maps the true time (the host's, in seconds) to the board's and back.

    Args:
        reset_s: true time of the reset.
        offset_us: what the clock shows at the reset.
        drift_ppm: by how much it runs fast.
    """

    def __init__(self, reset_s: float, offset_us: int, drift_ppm: float) -> None:
        self._reset_s = reset_s
        self._offset_us = offset_us
        self._rate = 1.0 + drift_ppm * 1e-6

    def since_reset_s(self, true_s: float) -> float:
        """Seconds that the board has counted since its reset."""
        return (true_s - self._reset_s) * self._rate

    def true_s(self, since_reset_s: float) -> float:
        """The true time at which the board has counted so many seconds."""
        return self._reset_s + since_reset_s / self._rate

    def shows_us(self, since_reset_s: float) -> int:
        """What the wire carries: microseconds modulo 2^32."""
        return (self._offset_us + int(since_reset_s * 1e6)) & _MASK
