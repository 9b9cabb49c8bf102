"""A recorded run in the page of a live one: played in real time, faster or slower, from any moment."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from snakebot.runlog import RunLog, channels, records
from snakebot.view.messages import STATUS, ViewPacket, pack, unpack
from snakebot.view.picture import KEPT_S
from snakebot.view.server import Server

_EVENT = 2  # among the kinds of records, by their order below
_STEP_S = 0.02  # between two looks at what is due
_STOPPED = "emergency stop"  # in the words of a stop; other faults have others
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)  # of playing: seconds of the run in a second


class Recording:
    """A log as a stream of packets.

    Args:
        log: as ``read_log`` gives it; it has at least one tick.
    """

    def __init__(self, log: RunLog) -> None:
        self._log = log
        self.path = log.path
        times = (
            log.t_s,
            log.pose_t_s,
            np.array([event.t_s for event in log.events]),
            log.telemetry_t_s,
            log.link_t_s,
        )
        kinds = np.concatenate([np.full(len(part), kind) for kind, part in enumerate(times)])
        numbers = np.concatenate([np.arange(len(part)) for part in times])
        order = np.argsort(np.concatenate(times), kind="stable")
        self._kinds, self._numbers = kinds[order], numbers[order]
        self.times_s = np.concatenate(times)[order]
        # What is told after the last tick is of the run, too: that the joints were held, relaxed or stopped.
        self.start_s, self.end_s = float(log.t_s[0]), float(np.nanmax(self.times_s))
        self._modes = list(_modes(log))

    def __len__(self) -> int:
        return len(self.times_s)

    def mode(self, t_s: float) -> str:
        """The board's mode as far as the log tells: in the run ``armed``; ``silent`` where nothing tells any more."""
        if t_s >= self.end_s and self._modes[-1][1] in ("armed", "holding"):
            return "silent"  # torn off, the line lost, or another program's: what became of the joints is not known
        return next(mode for since_s, mode in reversed(self._modes) if since_s <= t_s)

    def events_before(self, index: int) -> list[ViewPacket]:
        """The events up to a place in the order of time, oldest first: what they tell of the joints still holds."""
        return [self.packet(int(place)) for place in np.flatnonzero(self._kinds[:index] == _EVENT)]

    def packet(self, index: int) -> ViewPacket:
        """The record at a place in the order of time."""
        kind, number, log = int(self._kinds[index]), int(self._numbers[index]), self._log
        start_ns = int(log.host_time_ns[0] - round(log.t_s[0] * 1e9))
        t_s = float(self.times_s[index])
        match kind:
            case 0:
                channel, data = channels.JOINTS, channels.encode_tick(self._tick(number))
            case 1:
                x, y, heading = (float(value) for value in log.pose[number])
                pose = records.PoseRecord(t_s, x, y, heading, float(log.pose_speed_m_s[number]))
                channel, data = channels.POSE, channels.encode_pose(pose, start_ns)
            case _ if kind == _EVENT:
                channel, data = channels.EVENTS, channels.encode_event(log.events[number], start_ns)
            case 3:
                values = _at(log.telemetry, number)
                channel, data = channels.TELEMETRY, channels.encode_telemetry(records.Telemetry(t_s, values))
            case _:
                counters = _at(log.link, number)
                channel, data = channels.LINK, channels.encode_link(records.LinkRecord(t_s, counters))
        return ViewPacket(channel.id, max(0, start_ns + round(t_s * 1e9)), data)

    def _tick(self, number: int) -> records.Tick:
        log = self._log
        board_us, latency = log.board_time_us[number], log.latency_s[number]
        return records.Tick(
            sequence=int(log.sequence[number]),
            t_s=float(log.t_s[number]),
            host_time_ns=int(log.host_time_ns[number]),
            setpoint_rad=log.setpoint_rad[number],
            sent_rad=log.sent_rad[number],
            applied_rad=log.applied_rad[number],
            measured_rad=log.measured_rad[number],
            board_time_us=None if math.isnan(board_us) else int(board_us),
            latency_s=None if math.isnan(latency) else float(latency),
            late=bool(log.late[number]),
        )


def _modes(log: RunLog) -> Iterator[tuple[float, str]]:
    """Since when the board was in which mode, by the events."""
    mode = "armed"  # ticks are of a board that is
    yield -math.inf, mode
    for event in log.events:
        if event.kind in ("armed", "holding", "disarmed"):
            mode = event.kind
        elif event.kind in ("fault", "error") and _STOPPED in event.message:
            mode = "stopped"
        elif event.kind == "fault":
            mode = "fault"
        elif event.kind == "error" and mode in ("armed", "holding"):
            mode = "silent"
        yield event.t_s, mode


def _at(columns: Mapping[str, Any], number: int) -> dict[str, float]:
    return {name: float(values[number]) for name, values in columns.items() if not math.isnan(values[number])}


class Player:
    """Plays a recording into a server: what a page asks of it is play, pause, seek and speed."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._now_s = recording.start_s
        self._next = 0
        self._speed = 1.0
        self._playing = True
        self._sought = True

    async def ask(self, wish: Mapping[str, Any]) -> str | None:
        """Do what a page asks for; why not, or None."""
        try:
            match wish.get("do"):
                case "play":
                    if self._now_s >= self._recording.end_s:
                        self._seek(self._recording.start_s)
                    self._playing = True
                case "pause":
                    self._playing = False
                case "seek":
                    self._seek(float(wish["t_s"]))
                case "speed":
                    self._speed = min(max(float(wish["speed"]), SPEEDS[0]), SPEEDS[-1])
                case _:
                    return "this is a recording: nothing moves"
        except (KeyError, TypeError, ValueError, OverflowError):
            return "not understood"
        return None

    def _seek(self, t_s: float) -> None:
        if math.isfinite(t_s):
            self._now_s = min(max(t_s, self._recording.start_s), self._recording.end_s)
            self._sought = True

    async def play(self, server: Server) -> None:
        """Play until cancelled."""
        loop = asyncio.get_running_loop()
        before = loop.time()
        while True:
            now = loop.time()
            passed, before = now - before, now
            recording = self._recording
            if self._sought:
                self._sought = False
                server.begin_again()
                self._next = int(np.searchsorted(recording.times_s, self._now_s - KEPT_S))
                for packet in recording.events_before(self._next):
                    server.take(packet)
            elif self._playing:
                self._now_s = min(self._now_s + passed * self._speed, recording.end_s)
                self._playing = self._now_s < recording.end_s
            while self._next < len(recording) and recording.times_s[self._next] <= self._now_s:
                server.take(recording.packet(self._next))
                self._next += 1
            server.take(unpack(pack(STATUS, 0, self._status())))
            await asyncio.sleep(_STEP_S)

    def _status(self) -> dict[str, Any]:
        return {
            "t_s": self._now_s,
            "duration_s": self._recording.end_s,
            "start_s": self._recording.start_s,
            "mode": "recording",
            "board": self._recording.mode(self._now_s),
            "log": str(self._recording.path),
            "playing": self._playing,
            "speed": self._speed,
        }


def about_recording(log: RunLog) -> dict[str, Any]:
    """What a page is told first of a recording."""
    from snakebot.view.feed import about_run

    title = str(log.gait) if log.gait is not None else str(log.metadata.get("probe") or log.name)
    about = about_run(log.robot, title, port="recording")
    return {**about, "recording": True, "ended": log.ended, "speeds": SPEEDS}


async def show(log: RunLog, address: str, port: int, token: str, told: Any) -> None:
    """Serve a recording until cancelled; ``told`` is called with the address to open.

    Raises:
        OSError: that address and port cannot be had.
    """
    player = Player(Recording(log))
    server = Server(about_recording(log), player.ask)
    async with server.listening(address, port, token) as url:
        told(url)
        await player.play(server)
