"""Which rates a run can have: those that the loop keeps, and that feed the board's watchdog."""

from __future__ import annotations

from snakebot.board import Board
from snakebot.errors import BadInputError, BoardFaultError

# The least feeds the watchdog that PROTOCOL.md asks of a board, 100 ms, even where each second tick gets lost.
MIN_RATE_HZ, MAX_RATE_HZ = 20.0, 1000.0
_TICKS_IN_WATCHDOG = 2  # a set-point may be lost without the watchdog taking over


def check_rate(rate_hz: float) -> None:
    """Raises: BadInputError: the loop, or the watchdog of any board, cannot keep this rate."""
    if not MIN_RATE_HZ <= rate_hz <= MAX_RATE_HZ:
        raise BadInputError(f"--rate {rate_hz:g}: give {MIN_RATE_HZ:g} to {MAX_RATE_HZ:g} Hz")


def watchdog_s(board: Board, rate_hz: float) -> float:
    """How long the watchdog of this connected board waits for a set-point.

    Raises:
        BadInputError: too short for this rate.
        BoardFaultError: too short for any.
    """
    assert board.info is not None
    waits_s = board.info.watchdog_ms * 1e-3
    if waits_s * MAX_RATE_HZ < _TICKS_IN_WATCHDOG:
        raise BoardFaultError(
            f"{board.where}: the board reports a watchdog of {board.info.watchdog_ms} ms, which no rate can feed: "
            "update its firmware"
        )
    if waits_s * rate_hz < _TICKS_IN_WATCHDOG * (1 - 1e-9):
        raise BadInputError(
            f"--rate {rate_hz:g}: the board's watchdog waits only {board.info.watchdog_ms} ms for a set-point: "
            f"give {_TICKS_IN_WATCHDOG / waits_s:.4g} Hz or more"
        )
    return waits_s
