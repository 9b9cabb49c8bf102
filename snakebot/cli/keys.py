"""Keys that change the gait while the robot runs: one letter up, the capital letter down."""

from __future__ import annotations

import contextlib
import math
import os
import select
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.control import RunLoop
    from snakebot.gait import Gait

BLEND_S = 1.0  # a step of the gait is spread over this time
HELP = "keys: a/A alpha -/+   b/B beta   w/W omega   o/O offset   q stop   space emergency stop"
_STEPS: dict[str, tuple[str, float]] = {
    "a": ("alpha_rad", math.radians(2)),
    "b": ("beta_rad", math.radians(2)),
    "w": ("omega_rad_s", 0.1),
    "o": ("offset_rad", math.radians(1)),
}


def press(loop: RunLoop, gait: Gait, key: str) -> Gait:
    """What one key does. Returns the gait that is wanted from now on; the panel notes a change that is refused."""
    if key == "q":
        loop.request_stop()
    elif key == " ":
        loop.request_emergency_stop()
    elif key.lower() in _STEPS:
        name, step = _STEPS[key.lower()]
        sign = 1 if key.isupper() else -1
        try:
            wanted = replace(gait, **{name: getattr(gait, name) + sign * step})
            loop.change_gait(wanted, BLEND_S)
        except BadInputError as error:
            loop.progress.note = f"not changed: {error}"
            return gait
        return wanted
    return gait


@contextlib.contextmanager
def listening(loop: RunLoop, gait: Gait, shown: Callable[[Gait], None]) -> Iterator[None]:
    """Listen to the keyboard while the run lasts; nothing where standard input is no terminal.

    ``shown`` is told the gait after each key.
    """
    if not sys.stdin.isatty():
        yield
        return
    import termios
    import tty

    terminal = sys.stdin.fileno()
    before = termios.tcgetattr(terminal)
    done, wake = os.pipe()

    def listen() -> None:
        wanted = gait
        while True:
            ready, _, _ = select.select([terminal, done], [], [])
            if done in ready:
                return
            wanted = press(loop, wanted, os.read(terminal, 1).decode(errors="replace"))
            shown(wanted)

    thread = threading.Thread(target=listen, name="keys", daemon=True)
    tty.setcbreak(terminal)
    thread.start()
    try:
        yield
    finally:
        os.write(wake, b"x")
        thread.join(timeout=1.0)
        termios.tcsetattr(terminal, termios.TCSADRAIN, before)
        os.close(done)
        os.close(wake)
