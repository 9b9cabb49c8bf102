"""A simulated board on a real wire, in a process of its own."""

from __future__ import annotations

import threading

from snakebot.clock import Clock, sharpen_thread, urgent
from snakebot.errors import LostBoardError
from snakebot.heap import settled_heap
from snakebot.links.base import Link
from snakebot.softboard.board import SoftBoard
from snakebot.softboard.rehearsal import Rehearsal

IDLE_S = 0.005  # longest wait: how far the simulated world may lag behind when a set-point asks for it
# Before a set-point is due the world is brought up to date: little is left to do when it comes.
AHEAD_S = 0.0005
# After an answer the wire has the processor: the kernel's own threads carry a pseudo-terminal's bytes, and they come
# after an urgent one.
QUIET_S = 0.0003
_NO_WIRE_S = 0.05  # between looks at a wire that is gone


def serve(board: SoftBoard, link: Link, clock: Clock, stop: threading.Event) -> None:
    """Answer on a wire until ``stop`` is set.

    What a host waits for is sent before the world is integrated further; that is done when the wire is quiet. Hosts
    may come and go; a wire that fails (a bus that is down) is tried again, and meanwhile the board lives on: its
    watchdog too.
    """
    with urgent(), settled_heap():
        _serve(board, link, clock, stop)


def _serve(board: SoftBoard, link: Link, clock: Clock, stop: threading.Event) -> None:
    sharpen_thread()
    corrupt = 0
    board.advance(clock.now_s())
    answered = False
    rehearsal = Rehearsal(board.robot, simulated=board.simulated)
    while not stop.is_set():
        try:
            frames = link.receive(QUIET_S if answered else _wait_s(board, clock.now_s()))
        except LostBoardError:
            frames = []
            stop.wait(_NO_WIRE_S)
        now_s = clock.now_s()
        board.take(frames, now_s)
        board.note_corrupt(link.statistics.corrupt - corrupt)
        corrupt = link.statistics.corrupt
        said = board.advance(now_s)
        if said:
            try:
                link.send(said)
            except LostBoardError:
                stop.wait(_NO_WIRE_S)
        answered = bool(said)
        if not (said or frames):
            board.integrate(now_s)
            if 0.0 < board.next_setpoint_s - now_s <= AHEAD_S:
                rehearsal.once()


def _wait_s(board: SoftBoard, now_s: float) -> float:
    """How long the board may wait for a word, s."""
    ahead_s = board.next_setpoint_s - AHEAD_S - now_s
    wait_s = min(board.next_event_s - now_s, IDLE_S)
    return max(min(wait_s, ahead_s) if ahead_s > 0 else wait_s, 0.0)
