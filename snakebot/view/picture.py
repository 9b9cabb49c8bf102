"""What a page shows, kept up to date from the run's records: the last 30 s, and the state of everything now."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from snakebot.runlog import channels
from snakebot.view.messages import STATUS, ViewPacket

KEPT_S = 30.0  # that a page shows when it comes; chosen
ROW_S = 0.02  # rows of the strip charts are at least this far apart: 50 a second is more than a screen shows
EVENTS_KEPT = 100  # chosen: what fits on a page
ERROR_OVER_S = 10.0  # the running rms of the tracking error is taken over this time
_TRIPS_KEPT = 500  # round trips of which the page tells the percentiles; chosen: 5 s at 100 Hz
# Of angles in degrees: 0.001 is a tenth of what an encoder of 8192 counts resolves ten times over.
_DIGITS = 3

Row = list[Any]  # t_s, set-points, executed, measured: degrees a joint, None where there is none


@dataclass(slots=True)
class Seen:
    """What one page has got so far; a new page has got nothing.

    Attributes:
        row: number of the first row that it has not got.
        event: the same of events.
        looks: how often the picture had begun again by then.
        story: how often the story had changed by then.
    """

    row: int = 0
    event: int = 0
    looks: int = 0
    story: int = 0


class Picture:
    """The state of one run, and the story of the runs that it belongs to.

    Attributes:
        rows: the last ``KEPT_S`` seconds, oldest first.
        first: number of the oldest row; they are counted from the server's start.
        events: the last ones, oldest first; ``events_seen`` counts all.
        story: of an undertaking of several runs: which there were, and what they have shown so far.
    """

    def __init__(self, joints: int) -> None:
        self.story: dict[str, Any] = {}
        self.story_changes = 0
        self.looks = 0  # how often it has begun again
        self.first = 0
        self.events_seen = 0
        self._forget(joints)

    def _forget(self, joints: int) -> None:
        self.joints = joints
        self.rows: deque[Row] = deque()
        self.events: deque[dict[str, Any]] = deque(maxlen=EVENTS_KEPT)
        self.pose: list[float | None] | None = None
        self.link: dict[str, Any] = {}
        self.telemetry: dict[str, Any] = {}
        self.status: dict[str, Any] = {}
        self.joint_modes = ["active"] * joints
        self._trips_s: deque[float] = deque(maxlen=_TRIPS_KEPT)
        self._ticks_s: deque[float] = deque(maxlen=_TRIPS_KEPT)
        self._squares: list[deque[tuple[float, float]]] = [deque() for _ in range(joints)]
        self._sums = [0.0] * joints

    def begin_again(self, joints: int | None = None) -> None:
        """Forget what has been, but go on counting: another run, or another moment of a recording."""
        self.first = self.next
        self.looks += 1
        self._forget(self.joints if joints is None else joints)

    @property
    def next(self) -> int:
        """The number that the next row will have."""
        return self.first + len(self.rows)

    def take(self, packet: ViewPacket) -> None:
        """Take in one record.

        Raises:
            ValueError: it is not JSON.
        """
        values = packet.values()
        if packet.channel_id == channels.JOINTS.id:
            self._tick(values)
        elif packet.channel_id == channels.POSE.id:
            position = values["pose"]["position"]
            self.pose = [position["x"], position["y"], values["heading_rad"], values["speed_m_s"]]
        elif packet.channel_id == channels.EVENTS.id:
            self._event(values)
        elif packet.channel_id == channels.LINK.id:
            self.link = values["counters"]
        elif packet.channel_id == channels.TELEMETRY.id:
            self.telemetry |= {name: value for name, value in values.items() if name != "t_s"}
        elif packet.channel_id == STATUS:
            if "story" in values:
                self.story |= values.pop("story")
                self.story_changes += 1
            self.status |= values

    def _tick(self, tick: Mapping[str, Any]) -> None:
        t_s = float(tick["t_s"])
        self._ticks_s.append(t_s)
        if tick["latency_s"] is not None:
            self._trips_s.append(tick["latency_s"])
        self._add_errors(t_s, tick["setpoint_rad"], tick["measured_rad"])
        if self.rows and 0 <= t_s - self.rows[-1][0] < ROW_S:
            return
        self.rows.append(
            [
                round(t_s, 4),
                self._degrees(tick["setpoint_rad"]),
                self._degrees(tick["applied_rad"]),
                self._degrees(tick["measured_rad"]),
            ]
        )
        while self.rows[-1][0] - self.rows[0][0] > KEPT_S:
            self.rows.popleft()
            self.first += 1

    def _degrees(self, angles_rad: Sequence[float | None] | None) -> list[float | None]:
        if angles_rad is None:
            return [None] * self.joints
        return [None if angle is None else round(math.degrees(angle), _DIGITS) for angle in angles_rad]

    def _add_errors(
        self, t_s: float, wanted: Sequence[float | None], measured: Sequence[float | None] | None
    ) -> None:
        if measured is None:
            return
        for joint, (a, b) in enumerate(zip(wanted, measured, strict=False)):
            if a is None or b is None:
                continue
            window = self._squares[joint]
            square = math.degrees(a - b) ** 2
            window.append((t_s, square))
            self._sums[joint] += square
            while window[0][0] < t_s - ERROR_OVER_S:
                self._sums[joint] -= window.popleft()[1]

    def _event(self, event: Mapping[str, Any]) -> None:
        kept = {name: event[name] for name in ("t_s", "level", "kind", "message")}
        self.events.append(kept)
        self.events_seen += 1
        data = event.get("data") or {}
        if event["kind"] == "joint_mode":
            for joint in data.get("joints", ()):
                if isinstance(joint, int) and 1 <= joint <= self.joints:
                    self.joint_modes[joint - 1] = str(data.get("mode"))

    def rms_deg(self) -> list[float | None]:
        """Rms of measured minus set-point over the last seconds, degrees, one a joint; None before the first."""
        return [
            round(math.sqrt(max(total, 0.0) / len(window)), _DIGITS) if window else None
            for total, window in zip(self._sums, self._squares, strict=True)
        ]

    def loop(self) -> dict[str, float | None]:
        """Ticks a second and the median round trip in ms, over the last ticks; None before there are any."""
        rate = trip = None
        if len(self._ticks_s) > 1 and (span := self._ticks_s[-1] - self._ticks_s[0]) > 0:
            rate = round((len(self._ticks_s) - 1) / span, 2)
        if self._trips_s:
            ordered = sorted(self._trips_s)
            trip = round(ordered[len(ordered) // 2] * 1e3, 3)
        return {"rate_hz": rate, "round_trip_ms": trip}

    def frame(self, seen: Seen, most_rows: int) -> dict[str, Any]:
        """What is new for one page, and the state of everything; ``seen`` is brought up to date.

        Args:
            most_rows: rows are thinned where it has missed more.
        """
        fresh = min(self.next - seen.row, len(self.rows))
        rows = [self.rows[index] for index in range(len(self.rows) - fresh, len(self.rows))] if fresh else []
        step = max(1, math.ceil(len(rows) / most_rows))
        missed = min(self.events_seen - seen.event, len(self.events))
        frame = {
            "type": "frame",
            "fresh": seen.looks != self.looks,
            "rows": rows[::-1][::step][::-1],
            "pose": self.pose,
            "rms_deg": self.rms_deg(),
            "joint_modes": self.joint_modes,
            "status": self.status,
            "loop": self.loop(),
            "link": self.link,
            "telemetry": self.telemetry,
            "events": list(self.events)[-missed:] if missed > 0 else [],
        }
        if seen.story != self.story_changes:
            frame["story"] = self.story
        seen.row, seen.event = self.next, self.events_seen
        seen.looks, seen.story = self.looks, self.story_changes
        return frame
