"""Set-points in flight: sent, and not answered yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from snakebot.board import Reading
from snakebot.clock import Clock
from snakebot.control.copies import Copies
from snakebot.control.journal import Journal
from snakebot.control.progress import Progress
from snakebot.runlog import records

_ANSWER_TICKS, _ANSWER_S = 4, 0.05  # a set-point that has no answer after both is lost


@dataclass(slots=True)
class _Waiting:
    """A set-point that has no answer yet."""

    tick: records.Tick
    wanted_rad: Sequence[float]
    sent_s: float
    age: int = 0


class InFlight:
    """The set-points of one run that wait for their answer; each goes to the journal once, answered or lost.

    Args:
        copies: is told of each that is lost.
        settle_s: tracking error so far counts from here on.
    """

    def __init__(
        self,
        interval_s: float,
        clock: Clock,
        progress: Progress,
        journal: Journal,
        copies: Copies,
        settle_s: float,
    ) -> None:
        self._interval_s = interval_s
        self._clock = clock
        self._progress = progress
        self._journal = journal
        self._settle_s = settle_s
        self._waiting: dict[int, _Waiting] = {}
        self._copies = copies

    def sent(self, tick: records.Tick, wanted_rad: Sequence[float], now_s: float) -> None:
        """A set-point has gone out; older ones that have waited too long for their answer are given up."""
        for sequence, waiting in list(self._waiting.items()):
            waiting.age += 1
            if waiting.age > max(_ANSWER_TICKS, _ANSWER_S / self._interval_s):
                self._lost(sequence)
        self._waiting[tick.sequence] = _Waiting(tick, wanted_rad, now_s)

    def answered(self, reading: Reading) -> None:
        """A sample has come in: it answers the set-point of its number, and those sent before that one are lost."""
        waiting = self._waiting.pop(reading.sequence, None)
        if waiting is None:
            return
        tick = waiting.tick
        tick.applied_rad = reading.applied_rad
        tick.measured_rad = reading.measured_rad
        tick.board_time_us = reading.board_time_us
        tick.latency_s = reading.received_s - waiting.sent_s
        progress = self._progress
        progress.setpoint_rad, progress.measured_rad = waiting.wanted_rad, reading.measured_rad
        progress.round_trips_s.append(tick.latency_s)
        if tick.t_s >= self._settle_s:
            progress.tracking.add(waiting.wanted_rad, reading.measured_rad)
        for sequence in [s for s in self._waiting if self._waiting[s].sent_s < waiting.sent_s]:
            self._lost(sequence)
        self._journal.tick(tick)

    def give_up(self) -> None:
        """Nothing more will come: all that wait are lost."""
        for sequence in list(self._waiting):
            self._lost(sequence)

    def _lost(self, sequence: int) -> None:
        waiting = self._waiting.pop(sequence)
        self._progress.lost += 1
        self._copies.lost(self._clock.now_s())
        self._journal.tick(waiting.tick)
