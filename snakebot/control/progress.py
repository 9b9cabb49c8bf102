"""How a run is going: what the live panel and the summary show. Written by the loop, read by anyone."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from firmware_protocol.catalogue import Counters, Mode, Supply
from snakebot.board import PoseReading

_KEPT = 512  # round trips and tick starts that the running figures are taken over
_TOLD_FROM_S = 0.01  # all standstills of a run together


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
    def rms_rad(self) -> list[float]:
        """Rms of measured minus set-point of each joint; NaN before its first reading."""
        return [
            math.sqrt(square / count) if count else math.nan
            for square, count in zip(self._squares, self._counts, strict=True)
        ]

    @property
    def error(self) -> list[float]:
        """TE of each joint; NaN before its first reading or for a gait without amplitude."""
        if self.amplitude_rad <= 0:
            return [math.nan] * self.joints
        return [rms / self.amplitude_rad for rms in self.rms_rad]


@dataclass
class StandstillSoFar:
    """What the run's clock has left out because this process could not run; see ``snakebot.clock.StandstillClock``."""

    times: int = 0
    total_s: float = 0.0
    longest_s: float = 0.0

    def add(self, duration_s: float) -> None:
        self.times += 1
        self.total_s += duration_s
        self.longest_s = max(self.longest_s, duration_s)

    @property
    def matters(self) -> bool:
        """Whether a person wants to hear of it."""
        return self.total_s >= _TOLD_FROM_S

    def __str__(self) -> str:
        if self.times == 1:
            return f"this computer stood still once, for {self.total_s:.2f} s"
        longest = f", the longest {self.longest_s:.2f} s" if self.longest_s >= _TOLD_FROM_S else ""
        return f"this computer stood still {self.times} times, {self.total_s:.2f} s in all{longest}"


@dataclass
class SteeringSoFar:
    """How a course is held. Errors are those of the last decision; ``cross_track_m`` is positive left of the line."""

    error_rad: float = math.nan
    cross_track_m: float | None = None
    offset_rad: float = 0.0  # in force now, beside the gait's own
    decisions: int = 0
    saturated: int = 0  # decisions whose offset a limit cut short
    stale: bool = False  # no pose for too long: the offset fades
    stale_times: int = 0
    doubted: int = 0  # poses that were too far from the one before to be believed


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
    often_late: bool = False  # more than one disturbance: a warning is due
    standstill: StandstillSoFar = field(default_factory=StandstillSoFar)
    pose: PoseReading | None = None
    steering: SteeringSoFar | None = None
    bad_poses: int = 0  # lines of an outside pose source that were none
    supply: Supply | None = None
    counters: Counters | None = None
    note: str = ""
    round_trips_s: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))
    starts_s: deque[float] = field(default_factory=lambda: deque(maxlen=_KEPT))

    @property
    def late_warning(self) -> str:
        """What is to be said where ticks are often late."""
        return (
            f"ticks start up to {self.worst_lateness_s * 1e3:.1f} ms late: this computer is too slow or too busy "
            "for an even beat; lower --rate or end other programs"
        )

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
