"""Emulated servos on a pseudo-terminal: what a host opens is the USB adapter of a real bus."""

from __future__ import annotations

import termios
import threading
from collections.abc import Sequence

from firmware_protocol.frame import Frame
from snakebot.clock import Clock, sharpen_thread
from snakebot.servobus.emulated.bus import EmulatedBus
from snakebot.softboard.ends import PtyEnd

_IDLE_S = 0.005  # the longest wait for a byte; chosen
_SPEEDS = {getattr(termios, f"B{baud}", None): baud for baud in (
    9600, 19200, 38400, 57600, 115200, 500_000, 1_000_000, 2_000_000, 3_000_000, 4_000_000,
)}  # fmt: skip


class ServoBusEnd(PtyEnd):
    """A USB adapter that is not there; ``path`` is its device, ``port`` what ``--port`` takes.

    Raises:
        NoBoardError: the system has no pseudo-terminal left.
    """

    def __init__(self, bus: EmulatedBus, clock: Clock) -> None:
        super().__init__()
        self.bus = bus
        self.port = f"{bus.dialect.name}:{self.path}"
        self._clock = clock
        self._start_s = clock.now_s()

    def _unpack(self, data: bytes) -> list[Frame]:
        answer = self.bus.feed(data, self._clock.now_s() - self._start_s, self._baud())
        if answer:
            self._write(answer)
        return []

    def _pack(self, frames: Sequence[Frame]) -> bytes:
        raise AssertionError("frames do not travel on a servo bus")

    def _baud(self) -> int | None:
        """The speed that the host has set; None where it is none that has a name."""
        return _SPEEDS.get(termios.tcgetattr(self._slave)[5])

    def advance(self) -> None:
        """Let servos and snake go on until now."""
        self.bus.advance(self._clock.now_s() - self._start_s)


def serve_servos(end: ServoBusEnd, stop: threading.Event) -> None:
    """Answer until ``stop`` is set."""
    sharpen_thread()
    while not stop.is_set():
        end.receive(_IDLE_S)
        end.advance()
