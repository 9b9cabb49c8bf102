"""A board that is served ends, however many signals tell it to."""

from __future__ import annotations

import subprocess
import sys

# The main thread is in the event most of the time, as where no wire is connected; signals come as fast as they can.
STORM = """
import os, signal, threading
from snakebot.cli.board_sim import until_told

stop = until_told()

def storm():
    for _ in range(3000):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGTERM)

sender = threading.Thread(target=storm)
sender.start()
while sender.is_alive():
    stop.wait(1e-6)
    stop.is_set()
assert stop.wait(5)
"""


def test_a_storm_of_signals_ends_a_board_and_does_not_hang_it() -> None:
    subprocess.run([sys.executable, "-c", STORM], check=True, timeout=60)
