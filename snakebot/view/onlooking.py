"""A board that another program drives, in the page of a live run: nothing goes out but an emergency stop."""

from __future__ import annotations

import asyncio
import contextlib
import math
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from firmware_protocol.catalogue import Counters, FaultEvent, JointSupply, Mode, Supply
from snakebot.board import LATCHED, PoseReading, Reading, Received
from snakebot.board.faults import fault_line
from snakebot.board.onlooker import Onlooker
from snakebot.board.readings import telemetry_of
from snakebot.board.stopping import STOPPING_S
from snakebot.errors import BoardFaultError, LostBoardError, NoBoardError
from snakebot.robot import Robot
from snakebot.runlog import channels, records
from snakebot.view.feed import about_run
from snakebot.view.messages import STATUS, ViewPacket, pack, unpack
from snakebot.view.server import Server

_LISTEN_S = 0.01  # a stop waits no longer than this for the line
_STATUS_S = 0.2  # between two lines of status; chosen
_SILENT_S = 0.5  # a board beats ten times a second
_OBEYS_S = STOPPING_S + 0.5  # for the board's word that it has stopped

Take = Callable[[ViewPacket], None]


class Watch:
    """What one board says, as the records of a log; ``take`` is called with each, in the thread that listens.

    Args:
        board: connected, and this robot's.
    """

    def __init__(self, board: Onlooker, robot: Robot, take: Take) -> None:
        self._board, self._robot, self._give = board, robot, take
        self._start_s, self._start_ns = board.clock.now_s(), time.time_ns()
        self._stop_wanted = threading.Event()
        self._stopped = threading.Event()
        self._why_not: str | None = None
        self._done = threading.Event()
        self._mode: Mode | None = None
        self._heard_s = self._start_s
        self._silent = False
        self._told_s = -math.inf

    @property
    def _t_s(self) -> float:
        return self._board.clock.now_s() - self._start_s

    # -- from other threads ------------------------------------------------------------------------------------------

    def stop(self) -> str | None:
        """Stop the board. Returns None when it says that it has stopped, else why not."""
        self._stopped.clear()
        self._stop_wanted.set()
        self._board.request_emergency_stop()  # goes out at once, whatever the listener is about
        if not self._stopped.wait(_OBEYS_S):
            return "the line does not answer: use the robot's power switch"
        return self._why_not

    def end(self) -> None:
        """Listen no more."""
        self._done.set()

    # -- the thread that listens -------------------------------------------------------------------------------------

    def listen(self) -> None:
        """Listen until ``end``.

        Raises:
            LostBoardError: the link is gone.
        """
        self._event("connected", f"looking on at {self._board.where}: nothing is sent but a STOP")
        while not self._done.is_set():
            try:
                for item in self._board.listen(_LISTEN_S):
                    self._take(item)
            except BoardFaultError as error:
                if not self._stop_wanted.is_set():  # it has rebooted, or there is a second board
                    self._event("error", str(error), "error")
                    self._meet_again()
            if self._stop_wanted.is_set():
                self._stop_wanted.clear()
                self._stop()
            self._look()

    def _meet_again(self) -> None:
        self._board = Onlooker(self._board.link, self._board.clock)
        try:
            self._board.connect()
        except (NoBoardError, BoardFaultError) as error:
            self._event("error", str(error), "error")

    def _stop(self) -> None:
        try:
            self._board.stop()
            self._why_not = None
        except BoardFaultError as error:
            self._why_not = str(error)
            self._event("error", str(error), "error")
        finally:
            self._stopped.set()

    def _look(self) -> None:
        """What no frame tells: that the mode has changed, that nothing comes any more."""
        now_s, mode = self._board.clock.now_s(), self._board.mode
        if mode is not self._mode and mode is not None:
            self._mode = mode
            words = fault_line(self._board.fault) if mode in LATCHED else f"the board is {mode.name.lower()}"
            self._event(mode.name.lower(), words, "error" if mode in LATCHED else "info")
        silent = now_s - self._heard_s > _SILENT_S
        if silent and not self._silent:
            self._event("silent", "the board says nothing any more: check cable and supply", "error")
        self._silent = silent
        if now_s - self._told_s > _STATUS_S:
            self._told_s = now_s
            status = {
                "t_s": self._t_s,
                "mode": "silent" if silent else mode.name.lower() if mode is not None else None,
                "fault": self._board.fault.name.lower(),
                "holder": f"{self._board.holder:08x}" if self._board.holder else None,
            }
            self._give(unpack(pack(STATUS, 0, status)))
            link = self._board.link.statistics
            counters = {"received": link.received, "corrupt": link.corrupt}
            self._record(channels.LINK, channels.encode_link(records.LinkRecord(self._t_s, counters)))

    def _take(self, item: Received) -> None:
        self._heard_s = self._board.clock.now_s()
        match item:
            case Reading():
                self._record(channels.JOINTS, channels.encode_tick(self._tick(item)))
            case PoseReading():
                pose = records.PoseRecord(self._t_s, item.x_m, item.y_m, item.heading_rad, item.speed_m_s)
                self._record(channels.POSE, channels.encode_pose(pose, self._start_ns))
            case Supply() | JointSupply():
                self._telemetry(telemetry_of(item))
            case FaultEvent() | Counters() | _:
                pass  # a fault is told by the mode

    def _tick(self, reading: Reading) -> records.Tick:
        wanted = self._board.setpoint_rad(reading.sequence) or [math.nan] * self._robot.joints
        return records.Tick(
            sequence=reading.sequence,
            t_s=reading.received_s - self._start_s,
            host_time_ns=time.time_ns(),
            setpoint_rad=wanted,
            sent_rad=wanted,
            applied_rad=reading.applied_rad,
            measured_rad=reading.measured_rad,
            board_time_us=reading.board_time_us,
        )

    def _telemetry(self, values: Mapping[str, float]) -> None:
        self._record(channels.TELEMETRY, channels.encode_telemetry(records.Telemetry(self._t_s, values)))

    def _event(self, kind: str, message: str, level: records.Level = "info") -> None:
        event = records.Event(self._t_s, kind, message, level)
        self._record(channels.EVENTS, channels.encode_event(event, self._start_ns))

    def _record(self, channel: channels.Channel, data: bytes) -> None:
        self._give(ViewPacket(channel.id, self._start_ns + round(self._t_s * 1e9), data))


async def look_on(
    board: Onlooker, robot: Robot, address: str, port: int, token: str, told: Callable[[str], None]
) -> None:
    """Serve the page of a board that others drive, until cancelled.

    Raises:
        OSError: that address and port cannot be had.
        LostBoardError: the link is gone.
    """
    loop = asyncio.get_running_loop()
    about = {
        **about_run(robot, f"looking on at {board.where}", port=board.link.port),
        "onlooker": True,
    }

    async def ask(wish: Mapping[str, Any]) -> str | None:
        if wish.get("do") == "stop":
            return await loop.run_in_executor(None, watch.stop)
        return "this page looks on: only the program that drives the robot can do that"

    server = Server(about, ask)
    watch = Watch(board, robot, lambda packet: _thread_safe(loop, server, packet))
    async with server.listening(address, port, token) as url:
        told(url)
        listening = loop.run_in_executor(None, watch.listen)
        try:
            await asyncio.shield(listening)
        except LostBoardError as error:
            server.take(unpack(pack(STATUS, 0, {"ended": True, "how": str(error)})))
            await server.end()
            raise
        finally:
            watch.end()


def _thread_safe(loop: asyncio.AbstractEventLoop, server: Server, packet: ViewPacket) -> None:
    with contextlib.suppress(RuntimeError):  # the page is closed already
        loop.call_soon_threadsafe(server.take, packet)
