"""Look at a board that another host drives: ask who it is, then only listen. And stop it, as anyone may."""

from __future__ import annotations

from firmware_protocol.assembly import SetpointAssembler
from firmware_protocol.catalogue import Latch, Mode, Setpoint, StopReason, frame_id
from firmware_protocol.frame import Frame
from snakebot.board.client import Board
from snakebot.board.readings import Received
from snakebot.board.stopping import STOPPING_S
from snakebot.clock import Clock
from snakebot.errors import BoardFaultError
from snakebot.links.base import Link

_AGAIN_S = 0.05  # between two tries; chosen, seldom enough for any line
_KEPT = 64  # set-points that are remembered until the board answers them; more than any line holds


class Onlooker(Board):
    """A host that sends nothing after ``connect``: no heartbeat, no ping, no request.

    The host that drives does not notice it. Its set-points are heard where a line carries them to all: on a CAN bus,
    and on the TCP port of a board in software.
    """

    def __init__(self, link: Link, clock: Clock) -> None:
        super().__init__(link, clock)
        self._setpoint_ids = {frame_id(Setpoint), frame_id(Latch)}
        self._parts: SetpointAssembler | None = None  # how many joints there are is known after ``connect``
        self._wanted: dict[int, tuple[float, ...]] = {}

    def setpoint_rad(self, sequence: int) -> tuple[float, ...] | None:
        """What the driving host asked for with this number; None: it was not heard here."""
        return self._wanted.get(sequence)

    def _take_frame(self, frame: Frame, now: float) -> Received | None:
        if frame.id not in self._setpoint_ids:
            return super()._take_frame(frame, now)
        if self.info is not None:
            self._parts = self._parts or SetpointAssembler(self.info.joints)
            complete = self._parts.take(frame)
            if complete is not None:
                latch, angles_rad = complete
                self._wanted[latch.sequence] = angles_rad
                if len(self._wanted) > _KEPT:
                    del self._wanted[next(iter(self._wanted))]
        return None

    def listen(self, timeout_s: float) -> list[Received]:
        """What has come in, after at most ``timeout_s``.

        Raises:
            LostBoardError: the link is gone.
            BoardFaultError: the board has rebooted, or a second one speaks on this line.
        """
        self._read(timeout_s)
        return self.heard()

    def stop(self, reason: StopReason = StopReason.USER) -> None:
        """Send the emergency stop, and again until the board says that it has stopped.

        What is heard meanwhile is handed out by the next ``listen``.

        Raises:
            BoardFaultError: it does not say so within ``STOPPING_S``.
            LostBoardError: the link is gone.
        """
        self._stop_wanted = None  # this is it
        deadline_s = self.clock.now_s() + STOPPING_S
        while (now_s := self.clock.now_s()) < deadline_s:
            self.emergency_stop(reason)
            self.mode = None  # what it says counts, not what it was told
            until_s = now_s + _AGAIN_S
            while (left_s := until_s - self.clock.now_s()) > 0:
                self._read(left_s)
                if self.mode is Mode.STOPPED:
                    return
        raise BoardFaultError(
            f"{self.where}: the board has not obeyed the emergency stop within {STOPPING_S:g} s: cut its supply"
        )
