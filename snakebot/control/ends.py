"""How a run ends: relaxed after its last set-point, or given up after an error, as safe as the link still allows."""

from __future__ import annotations

import contextlib

from firmware_protocol.catalogue import Mode, StopReason
from snakebot.board import Board
from snakebot.control.inflight import InFlight
from snakebot.control.intake import Intake
from snakebot.control.journal import Journal
from snakebot.control.progress import Progress
from snakebot.errors import SnakebotError

HOLD_BEFORE_RELAX_S = 0.2  # chosen: the joints stand still when the torque goes off


class Ends:
    """The ends of one run."""

    def __init__(
        self, board: Board, intake: Intake, in_flight: InFlight, journal: Journal, progress: Progress
    ) -> None:
        self._board = board
        self._intake = intake
        self._in_flight = in_flight
        self._journal = journal
        self._progress = progress

    def relax(self) -> None:
        """Hold for a moment, then take the power away.

        Raises:
            BoardFaultError, LostBoardError: the board refuses, or is gone.
        """
        self._board.hold()
        self._journal.event("holding", "joints held")
        self._intake.during(HOLD_BEFORE_RELAX_S)
        self._board.disarm()
        self._intake.take(self._board.heard())
        self._journal.event("disarmed", "joints relaxed")
        self._progress.mode = Mode.DISARMED

    def failed(self, error: BaseException, *, lost: bool = False) -> None:
        """Keep what the line carried before an error, in the log and with the error, then give up."""
        frames = self._board.recent_traffic()
        if isinstance(error, SnakebotError):
            error.traffic = tuple(frames)
        if frames:
            told = f"the last {len(frames)} frames on the wire: `snakebot log info --json` shows them"
            with contextlib.suppress(SnakebotError):
                self._journal.event("traffic", told, data={"frames": frames})
        self._journal.event("error", str(error) or type(error).__name__, "error")
        self.give_up(lost=lost)

    def give_up(self, *, lost: bool = False) -> None:
        """Hold and relax if the link still lives. One that is dead may still carry the emergency stop.

        What has stopped is left as it is: nothing here clears a stop or a fault, and another host's run is let be.
        """
        board = self._board
        with contextlib.suppress(SnakebotError, OSError):
            self._intake.take(board.heard())
            self._in_flight.give_up()
        with contextlib.suppress(SnakebotError, OSError):
            if board.claimed and not lost:
                if board.mode is Mode.ARMED:
                    board.hold()
                board.disarm()
        with contextlib.suppress(SnakebotError, OSError):
            self._intake.take(board.heard())
            if board.claimed:
                board.emergency_stop(StopReason.EXCEPTION)
