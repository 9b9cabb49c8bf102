"""When a tick is late, what that costs, and when the host gives up.

A late host skips the ticks that it slept through and never sends them in a burst. One that stays late is no longer fit
to drive a robot: the run is to be held and ended.
"""

from __future__ import annotations

from snakebot.control.progress import Progress
from snakebot.errors import HostLateError

LATE_SHARE = 0.5  # a tick that starts later than this share of the interval is late
LATE_ROW_HOLD = 5  # late ticks in a row that bring the robot to hold


class Lateness:
    """How late the ticks of one run start, judged tick by tick.

    Attributes:
        late: whether the last tick judged was late.
    """

    def __init__(self, interval_s: float, progress: Progress) -> None:
        self.late = False
        self._interval_s = interval_s
        self._progress = progress
        self._last_s = 0.0
        self._row = 0

    def judge(self, lateness_s: float) -> None:
        """Take in by how much a tick starts after its deadline."""
        self._last_s = lateness_s
        self._progress.worst_lateness_s = max(self._progress.worst_lateness_s, lateness_s)
        self.late = lateness_s > LATE_SHARE * self._interval_s
        self._row = self._row + 1 if self.late else 0

    @property
    def hopeless(self) -> bool:
        """Whether so many ticks in a row were late that the run has to end."""
        return self._row >= LATE_ROW_HOLD

    def skip(self) -> int:
        """Ticks that the last one judged has slept through: they are not made up for."""
        behind = max(int(self._last_s / self._interval_s), 0)
        self._progress.skipped += behind
        return behind

    def error(self) -> HostLateError:
        """What to raise, once the robot is held, when it is hopeless."""
        return HostLateError(
            f"this computer could not keep the tick: {LATE_ROW_HOLD} ticks in a row came late, the last by "
            f"{self._last_s * 1e3:.1f} ms at an interval of {self._interval_s * 1e3:g} ms; the robot was held and "
            "relaxed: lower --rate or end other programs"
        )
