"""How a run is going: what the live panel and the summary show. Written by the loop, read by anyone."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from firmware_protocol.catalogue import Counters, Mode, Supply
from snakebot.board import Pose

_KEPT = 512  # round trips and tick starts that the running figures are taken over


@dataclass
class TrackingSoFar:
    """Running tracking error (37) of each joint: rms of measured minus set-point, over the gait's amplitude."""

    joints: int
    amplitude_rad: float
    _squares: list[float] = field(init=False)
    _counts: list[int] = field(init=False)

    def __post_init__(self) -> None:
        self._squares = [0.0] * self.joints
        self._counts = [0] * self.joints

    def add(self, setpoint_rad: Sequence[float], measured_rad: Sequence[float]) -> None:
        for joint, (wanted, measured) in enumerate(zip(setpoint_rad, measured_rad, strict=True)):
            if not math.isnan(measured):
                self._squares[joint] += (measured - wanted) ** 2
                self._counts[joint] += 1

    @property
    def error(self) -> list[float]:
        """TE of each joint; NaN before its first reading or for a gait without amplitude."""
        if self.amplitude_rad <= 0:
            return [math.nan] * self.joints
        return [
            math.sqrt(square / count) / self.amplitude_rad if count else math.nan
            for square, count in zip(self._squares, self._counts, strict=True)
        ]


@dataclass
class Progress:
    """A snapshot that is kept up to date. Angles in rad, times in s since the motion's start."""

    duration_s: float
    tracking: TrackingSoFar
    t_s: float = 0.0
    mode: Mode | None = None
    setpoint_rad: Sequence[float] = ()
    measured_rad: Sequence[float] = ()
    ticks: int = 0
    late: int = 0
    skipped: int = 0
    lost: int = 0  # set-points without an answer
    clamped: int = 0  # joint set-points that the host's own limits changed
    worst_lateness_s: float = 0.0
    pose: Pose | None = None
    supply: Supply | None = None
    counters: Counters | None = None
    note: str = ""
    round_trips_s: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))
    starts_s: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))

    @property
    def rate_hz(self) -> float:
        """Rate of the loop over the last ticks; NaN before the second."""
        if len(self.starts_s) < 2:
            return math.nan
        span = self.starts_s[-1] - self.starts_s[0]
        return (len(self.starts_s) - 1) / span if span > 0 else math.nan

    @property
    def round_trip_s(self) -> float:
        """Median of the last round trips; NaN before the first."""
        trips = sorted(self.round_trips_s)
        return trips[len(trips) // 2] if trips else math.nan
