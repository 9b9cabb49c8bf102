"""When a tick is late, what that costs, when a warning is due, and when the host gives up.

What protects the robot from a late host is the board's watchdog. The host counts: it skips the ticks that it slept
through and never sends them in a burst, warns once, and gives up only where the watchdog is near, time and again. It
then still holds and relaxes the robot itself; the watchdog would freeze it in mid-motion.
"""

from __future__ import annotations

from collections import deque

from firmware_protocol.catalogue import Fault
from snakebot.control.journal import Journal
from snakebot.control.progress import Progress
from snakebot.errors import HostLateError

LATE_SHARE = 0.5  # a tick that starts later than this share of the interval is late
FAR_SHARE = 0.5  # one that starts later than this share of the watchdog's time is far too late
WINDOW_S = 1.0  # within which late ticks are counted together
LATE_WARNED = 5  # late ticks within that time: the host is not just disturbed once
# Far too late ones: one is an accident, two may be one disturbance, and the next may be the watchdog's.
FAR_ENDED = 3


class Lateness:
    """How late the ticks of one run start, judged tick by tick.

    Args:
        interval_s: between ticks.
        watchdog_s: of the board: longest time without a set-point.
        progress: is kept up to date.
        journal: gets the warning.

    Attributes:
        late: whether the last tick judged was late.
    """

    def __init__(self, interval_s: float, watchdog_s: float, progress: Progress, journal: Journal) -> None:
        self.late = False
        self._interval_s = interval_s
        self._watchdog_s = watchdog_s
        self._progress = progress
        self._journal = journal
        self._last_s = 0.0
        self._far_s = 0.0  # by how much the last tick was late that was far too late
        self._late_at_s: deque[float] = deque(maxlen=LATE_WARNED)
        self._far_at_s: deque[float] = deque(maxlen=FAR_ENDED)

    def judge(self, lateness_s: float, now_s: float) -> None:
        """Take in by how much the tick of this moment starts after its deadline."""
        progress = self._progress
        self._last_s = lateness_s
        progress.worst_lateness_s = max(progress.worst_lateness_s, lateness_s)
        self.late = lateness_s > LATE_SHARE * self._interval_s
        if self.late:
            self._late_at_s.append(now_s)
            if not progress.often_late and _crowded(self._late_at_s):
                progress.often_late = True
                self._journal.event("late", progress.late_warning, "warning")
        if lateness_s > FAR_SHARE * self._watchdog_s:
            self._far_at_s.append(now_s)
            self._far_s = lateness_s

    @property
    def hopeless(self) -> bool:
        """Whether so many ticks were far too late within a short time that the run has to end."""
        return _crowded(self._far_at_s)

    def skip(self) -> int:
        """Ticks that the last one judged has slept through: they are not made up for."""
        behind = max(int(self._last_s / self._interval_s), 0)
        self._progress.skipped += behind
        return behind

    def part_in(self, fault: Fault, now_s: float) -> str:
        """What to add to the error where the board's watchdog ran out because this computer stood still; else ""."""
        held_up_s = self._since_setpoint_s(now_s) - self._interval_s
        if self._far_at_s and now_s - self._far_at_s[-1] <= WINDOW_S:  # the board's word may take some ticks
            held_up_s = max(held_up_s, self._far_s)
        if fault is not Fault.WATCHDOG or held_up_s <= FAR_SHARE * self._watchdog_s:
            return ""
        return f"; this computer stood still for {held_up_s:.2f} s"

    def spare_s(self, now_s: float) -> float:
        """For how long nothing need be sent: until half of the watchdog's time has passed since the last set-point."""
        return self._watchdog_s / 2 - self._since_setpoint_s(now_s)

    def _since_setpoint_s(self, now_s: float) -> float:
        return now_s - self._progress.starts_s[-1] if self._progress.starts_s else 0.0

    def error(self) -> HostLateError:
        """What to raise, once the robot is held, when it is hopeless."""
        return HostLateError(
            f"this computer could not keep the tick: {FAR_ENDED} ticks within {WINDOW_S:g} s came more than "
            f"{FAR_SHARE * self._watchdog_s * 1e3:g} ms late, the last by {self._last_s * 1e3:.1f} ms, and the board's "
            f"watchdog waits {self._watchdog_s * 1e3:g} ms for a set-point; the robot was held and relaxed: "
            "lower --rate or end other programs"
        )


def _crowded(times_s: deque[float]) -> bool:
    """Whether as many as are remembered lie within the window."""
    return len(times_s) == times_s.maxlen and times_s[-1] - times_s[0] <= WINDOW_S
