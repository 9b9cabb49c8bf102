"""Keys of a run that moves: two that end it, and for a gait one letter up, the capital letter down."""

from __future__ import annotations

import contextlib
import math
import os
import queue
import re
import select
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.control import RunLoop
    from snakebot.gait import Gait

_ENDS = "space bar EMERGENCY STOP   q ramp down"
_CHANGES = "a/A alpha down/up   b/B beta   w/W omega   o/O offset"
_STEPS: dict[str, tuple[str, float]] = {
    "a": ("alpha_rad", math.radians(2)),
    "b": ("beta_rad", math.radians(2)),
    "w": ("omega_rad_s", 0.1),
    "o": ("offset_rad", math.radians(1)),
}
_AT_ONCE = 1024  # bytes that are read together: more than anybody types
# What arrows, function keys and the like send: the letter at its end is not a letter that was typed. No space in it.
_NAMED_KEY = re.compile(r"\x1b(?:\[[0-9;?]*[A-Za-z~]|O[A-Za-z])")


def shown(gait: Gait | None) -> str:
    """What the keys do: the emergency stop first."""
    return _ENDS if gait is None else f"{_ENDS}\n{_CHANGES}"


def press(loop: RunLoop, gait: Gait, key: str) -> Gait:
    """Change the gait by one key. Returns the one that is wanted from now on; the panel notes a change that is refused.

    It goes out from what was asked for last, by whomever: the page has sliders. Before the first tick that is ``gait``.
    """
    if key.lower() not in _STEPS:
        return gait
    asked = loop.gait if loop.progress.ticks else None
    now = gait if asked is None else asked
    name, step = _STEPS[key.lower()]
    sign = 1 if key.isupper() else -1
    try:
        wanted = replace(now, **{name: getattr(now, name) + sign * step})
        loop.change_gait(wanted)
    except BadInputError as error:
        loop.progress.note = f"not changed: {error}"
        return now
    return wanted


def end(loop: RunLoop, text: str) -> None:
    """Do what ends the motion in what was typed: the emergency stop before all else."""
    if " " in text:
        loop.request_emergency_stop()
    if "q" in text:
        loop.request_stop()


@contextlib.contextmanager
def listening(loop: RunLoop, gait: Gait | None) -> Iterator[None]:
    """Listen to the keyboard while the run lasts; nothing where standard input is no terminal.

    A change of ``gait`` is checked by a thread of its own: no end of the motion waits for it.
    """
    if not sys.stdin.isatty():
        yield
        return
    import termios
    import tty

    terminal = sys.stdin.fileno()
    before = termios.tcgetattr(terminal)
    done, wake = os.pipe()
    typed: queue.SimpleQueue[str] = queue.SimpleQueue()  # "": no more comes

    def listen() -> None:
        while True:
            ready, _, _ = select.select([terminal, done], [], [])
            if done in ready:
                return
            try:
                found = os.read(terminal, _AT_ONCE)
            except OSError:
                found = b""
            if not found:  # the terminal has gone
                return
            text = _NAMED_KEY.sub("", found.decode(errors="replace"))
            end(loop, text)
            for key in text:
                typed.put(key)

    def change() -> None:
        wanted = gait
        while (key := typed.get()) and not loop.end_asked:
            if wanted is not None:
                wanted = press(loop, wanted, key)

    threads = [
        threading.Thread(target=work, name=name, daemon=True)
        for work, name in ((listen, "keys"), (change, "changes by keys"))
    ]
    tty.setcbreak(terminal)
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        os.write(wake, b"x")
        typed.put("")
        for thread in threads:
            thread.join(timeout=1.0)
        with contextlib.suppress(termios.error):
            termios.tcsetattr(terminal, termios.TCSADRAIN, before)
        os.close(done)
        os.close(wake)
