"""A simulated board on a real wire, in a process of its own."""

from __future__ import annotations

import gc
import threading

from snakebot.clock import Clock, sharpen_thread, urgent
from snakebot.errors import LostBoardError
from snakebot.links.base import Link
from snakebot.simboard.board import SimBoard

IDLE_S = 0.005  # longest wait: how far the simulated world may lag behind when a set-point asks for it
_NO_WIRE_S = 0.05  # between looks at a wire that is gone


def serve(board: SimBoard, link: Link, clock: Clock, stop: threading.Event) -> None:
    """Answer on a wire until ``stop`` is set.

    What a host waits for is sent before the world is integrated further. Hosts may come and go; a wire that fails
    (a bus that is down) is tried again, and meanwhile the board lives on: its watchdog too.
    """
    with urgent():
        _serve(board, link, clock, stop)


def _serve(board: SimBoard, link: Link, clock: Clock, stop: threading.Event) -> None:
    sharpen_thread()
    gc.collect()
    gc.freeze()  # what start-up has made is not looked through again while a host waits
    corrupt = 0
    board.advance(clock.now_s())
    while not stop.is_set():
        try:
            frames = link.receive(min(max(board.next_event_s - clock.now_s(), 0.0), IDLE_S))
        except LostBoardError:
            frames = []
            stop.wait(_NO_WIRE_S)
        now_s = clock.now_s()
        for frame in frames:
            board.receive(frame, now_s)
        board.note_corrupt(link.statistics.corrupt - corrupt)
        corrupt = link.statistics.corrupt
        said = board.advance(now_s)
        if said:
            try:
                link.send(said)
            except LostBoardError:
                stop.wait(_NO_WIRE_S)
        board.integrate(clock.now_s())
