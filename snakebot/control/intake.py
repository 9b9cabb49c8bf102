"""What comes back in a run: samples, poses, supply, counters, faults, other hosts."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.catalogue import Counters, FaultEvent, JointSupply, Supply
from snakebot.board import Board, OtherHost, PoseReading, Reading, Received
from snakebot.board.faults import fault_line
from snakebot.board.readings import telemetry_of
from snakebot.clock import Clock
from snakebot.control.inflight import InFlight
from snakebot.control.journal import Journal
from snakebot.control.pose_intake import PoseIntake
from snakebot.control.progress import Progress

# Leave the wait for frames this much before a deadline, make what is to be sent, and sleep the rest exactly.
_WAKE_EARLY_S = 0.0003
_SHORTEST_WAIT_S = 1e-6  # a wait that rounding may swallow would never end in virtual time


class Intake:
    """Takes in what one board says in a run, and puts each thing where it belongs."""

    def __init__(
        self,
        board: Board,
        clock: Clock,
        progress: Progress,
        journal: Journal,
        in_flight: InFlight,
        poses: PoseIntake,
    ) -> None:
        self._board = board
        self._clock = clock
        self._progress = progress
        self._journal = journal
        self._in_flight = in_flight
        self._poses = poses

    def until(self, deadline_s: float) -> None:
        """Take in frames until shortly before the deadline."""
        while (left := deadline_s - self._clock.now_s() - _WAKE_EARLY_S) > _SHORTEST_WAIT_S:
            self.take(self._board.poll(left))
        self.take(self._board.poll(0.0))

    def during(self, duration_s: float) -> None:
        """Take in frames for so long."""
        deadline = self._clock.now_s() + duration_s
        while (left := deadline - self._clock.now_s()) > _SHORTEST_WAIT_S:
            self.take(self._board.poll(left))

    def take(self, received: Sequence[Received]) -> None:
        """Take in what the board client hands out."""
        for item in received:
            match item:
                case Reading():
                    self._in_flight.answered(item)
                case PoseReading():
                    self._poses.from_board(item)
                case Supply():
                    self._progress.supply = item
                    self._journal.telemetry(telemetry_of(item))
                case JointSupply():
                    self._journal.telemetry(telemetry_of(item))
                case Counters():
                    self._progress.counters = item
                case FaultEvent() if item.number != self._board.found_latch:  # not one from before the run
                    told = fault_line(item.code, item.joint, item.detail)
                    self._journal.event("fault", told, "error", {"joint": item.joint, "detail": item.detail})
                case OtherHost():
                    self._journal.event(
                        "other_host", f"another host ({item.host:08x}) speaks on this line", "warning"
                    )
                case _:
                    pass
        self._journal.statistics()
