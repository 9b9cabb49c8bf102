"""How often and how long this computer stood still during a run, where the run's clock leaves that out."""

from __future__ import annotations

from dataclasses import asdict

from snakebot.clock import Clock, StandstillClock
from snakebot.control.journal import Journal
from snakebot.control.progress import Progress

_EVENT_S = 1.0  # between two events: a busy computer stands still many times a second


class Standstills:
    """Watches the clock of one run, once a tick; several standstills within one tick count as one.

    Does nothing on a clock that leaves nothing out.
    """

    def __init__(self, clock: Clock, progress: Progress, journal: Journal) -> None:
        self._clock = clock if isinstance(clock, StandstillClock) else None
        self._progress = progress
        self._journal = journal
        self._seen_s = self._told_s = 0.0
        self._event_due_s = 0.0

    def begin(self) -> None:
        """What was left out before the first tick held nothing up."""
        if self._clock is not None:
            self._seen_s = self._clock.left_out_s

    def look(self, *, last: bool = False) -> None:
        """Count what was left out since the last look, and note it as an event: once a second, and at the end."""
        if self._clock is None:
            return
        so_far = self._progress.standstill
        new_s = self._clock.left_out_s - self._seen_s
        if new_s > 0:
            self._seen_s += new_s
            so_far.add(new_s)
        untold = so_far.matters and so_far.total_s > self._told_s
        if untold and (last or self._journal.since_s >= self._event_due_s):
            self._told_s = so_far.total_s
            self._event_due_s = self._journal.since_s + _EVENT_S
            note = self._progress.note  # the panel shows standstills on a line of their own
            self._journal.event("standstill", str(so_far), "warning", asdict(so_far))
            self._progress.note = note
