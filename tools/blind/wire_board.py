"""A process of its own: a board on a real wire with the blind robot behind it.

    wire_board.py pty | wire_board.py can:udp_multicast/239.74.163.2

What the robot is like comes pickled on standard input, so that no file and no list of processes holds it. Prints the
port to use, and serves until SIGTERM or until standard input is closed.
"""

from __future__ import annotations

import pickle
import signal
import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from blind.wire_plant import BlindPlant
from snakebot.clock import MonotonicClock
from snakebot.links import Link
from snakebot.robot import load_robot
from snakebot.softboard import PtyEnd, SoftBoard, serve

ROBOT = "penn_state"  # what the lab believes it has
WATCHDOG_MS = 200  # for a computer that stands still now and then; a host sends as many copies as for 100 ms


def open_end(carrier: str) -> Link:
    if carrier == "pty":
        return PtyEnd()
    from snakebot.links.can_link import open_can
    from snakebot.links.port import CanPort, parse_port

    port = parse_port(carrier)
    assert isinstance(port, CanPort)
    return open_can(port, role="Board")


def main() -> None:
    parameters, seed = pickle.load(sys.stdin.buffer)
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())

    def stop_with_parent() -> None:
        sys.stdin.buffer.read()
        stop.set()

    threading.Thread(target=stop_with_parent, daemon=True).start()
    board = SoftBoard(load_robot(ROBOT), plant=BlindPlant(parameters, seed), watchdog_ms=WATCHDOG_MS)
    end = open_end(sys.argv[1])
    print(end.port, flush=True)
    try:
        serve(board, end, MonotonicClock(), stop)
    finally:
        end.close()


if __name__ == "__main__":
    main()
