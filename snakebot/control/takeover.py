"""A board at the start of a run: free of what a run before, or another host, has left."""

from __future__ import annotations

from firmware_protocol.catalogue import Mode
from snakebot.board import LATCHED, Board
from snakebot.control.journal import Journal
from snakebot.errors import BoardFaultError


def take_over(board: Board, journal: Journal, *, keep_stop: bool) -> None:
    """Bring the board to ``disarmed``. This is the one place where a stop or a fault is cleared.

    Only the one in which the board was found when it was connected: a person has started the run and could know of it.

    Raises:
        BoardFaultError: it is stopped or in a fault and that is to be kept, or newer; another host holds it.
    """
    if board.mode in LATCHED:
        assert board.mode is not None
        found = board.mode.name.lower()
        if keep_stop:
            raise BoardFaultError(f"{board.where}: the board is in mode {found} already: nothing was moved")
        if board.found_latch is None or board.latch != board.found_latch:
            raise BoardFaultError(
                f"{board.where}: the board was stopped just before the run began: nothing was moved"
            )
        journal.event("cleared", f"the board was {found}; cleared it first", "warning")
        board.clear()
    elif board.mode is not Mode.DISARMED:
        board.disarm()  # refused, where another host holds it
