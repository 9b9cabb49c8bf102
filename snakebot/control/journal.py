"""What a run writes down: ticks, poses, steering, events, telemetry, link statistics; timed from the first tick."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Protocol

from firmware_protocol.frame import Frame
from snakebot.board import Board, PoseReading
from snakebot.clock import Clock
from snakebot.control.progress import Progress
from snakebot.errors import SnakebotError
from snakebot.runlog import records

STATISTICS_S = 1.0  # between two records of the link's counters


class Recorder(Protocol):
    """What a run is recorded with; ``snakebot.runlog.RunWriter`` is one."""

    def tick(self, tick: records.Tick) -> None: ...
    def pose(self, pose: records.PoseRecord) -> None: ...
    def event(self, event: records.Event) -> None: ...
    def link_statistics(self, statistics: records.LinkRecord) -> None: ...
    def telemetry(self, telemetry: records.Telemetry) -> None: ...
    def steering(self, steering: records.SteeringRecord) -> None: ...
    def frame(self, frame: records.RawFrame) -> None: ...


class Journal:
    """A recorder, or none, with the run's own time; whatever the recorder raises goes to the caller."""

    def __init__(self, recorder: Recorder | None, board: Board, clock: Clock, progress: Progress) -> None:
        self.origin_s = clock.now_s()  # host clock at the first tick
        self._recorder = recorder
        self._board = board
        self._clock = clock
        self._progress = progress
        self._statistics_due_s = 0.0

    def stop(self) -> None:
        """Write nothing more: the recorder has failed."""
        self._recorder = None

    @property
    def since_s(self) -> float:
        """Time since the first tick."""
        return max(0.0, self._clock.now_s() - self.origin_s)

    def tick(self, tick: records.Tick) -> None:
        if self._recorder is not None:
            self._recorder.tick(tick)

    def pose(self, pose: PoseReading) -> None:
        if self._recorder is not None:
            self._recorder.pose(
                records.PoseRecord(self.since_s, pose.x_m, pose.y_m, pose.heading_rad, pose.speed_m_s)
            )

    def steering(self, steering: records.SteeringRecord) -> None:
        if self._recorder is not None:
            self._recorder.steering(steering)

    def telemetry(self, values: Mapping[str, float]) -> None:
        if self._recorder is not None:
            self._recorder.telemetry(records.Telemetry(self.since_s, values))

    def event(
        self,
        kind: str,
        message: str,
        level: records.Level = "info",
        data: Mapping[str, object] | None = None,
    ) -> None:
        """Note an event for the log and for whoever looks. One of level error never hides what it reports."""
        self._progress.note = message
        if self._recorder is not None:
            with contextlib.suppress(SnakebotError) if level == "error" else contextlib.nullcontext():
                self._recorder.event(records.Event(self.since_s, kind, message, level, data or {}))

    def statistics(self) -> None:
        """Record the link's counters, once a second."""
        now = self._clock.now_s()
        if self._recorder is not None and now >= self._statistics_due_s:
            self._statistics_due_s = now + STATISTICS_S
            self._recorder.link_statistics(records.LinkRecord(self.since_s, self._counters()))

    def frame(self, direction: str, at_s: float, frame: Frame) -> None:
        """Record one frame of the wire; the board client calls this."""
        if self._recorder is not None:
            way = "sent" if direction == "tx" else "received"
            since_s = max(0.0, at_s - self.origin_s)
            self._recorder.frame(records.RawFrame(since_s, way, frame.id, frame.data))  # type: ignore[arg-type]

    def _counters(self) -> dict[str, float]:
        link, progress = self._board.link.statistics, self._progress
        counters: dict[str, float] = {
            "sent": link.sent,
            "received": link.received,
            "corrupt": link.corrupt,
            "bytes_sent": link.bytes_sent,
            "bytes_received": link.bytes_received,
            "unreadable": self._board.unreadable,
            "ticks": progress.ticks,
            "late": progress.late,
            "skipped": progress.skipped,
            "lost": progress.lost,
            **self._board.link.counters(),
        }
        if progress.counters is not None:
            counters["board_corrupt"] = progress.counters.corrupt
            counters["board_dropped"] = progress.counters.dropped
            counters["board_clamped"] = progress.counters.clamped
        estimate = self._board.board_clock.estimate()
        if estimate is not None:
            counters["board_offset_s"], counters["board_drift_ppm"] = estimate
        return counters
