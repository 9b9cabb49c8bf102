"""Where the program begins. Ctrl-C is one line and status 130 from here on, whatever is just being imported or ended.

Python's own way is a traceback: while the command line is not yet there to catch KeyboardInterrupt, where a library
makes an ImportError of it, where it comes up in a finaliser that cannot raise, and while the interpreter ends. Or a
crash: numba, asked for stored machine code, would have lost it, and called what is not there.

Only the program itself imports this: its handler is there as soon as it is imported. It imports nothing before that
takes time.
"""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

from snakebot.cli import ctrl_c

EXIT_INTERRUPTED = 130  # as in snakebot.errors, which is imported later
_AGAIN_S = 0.01  # a finaliser has ended by then, most imports, and machine code is loaded; chosen

_at_work = False  # there may be something to end properly: KeyboardInterrupt unwinds to it


def _on_interrupt(_: int, frame: FrameType | None) -> None:
    ctrl_c.pressed = True
    if not _at_work:
        _leave("snakebot: aborted\n")
    if _indivisible(frame):
        _again()
        return
    raise KeyboardInterrupt


# Where KeyboardInterrupt does harm: modules in mid-import (compiled ones print an error of their own), and machine code
# that is being loaded. LLVM asks for it through a callback, which cannot raise, and has no code without an answer; of
# what a function needs when it first begins, numba does not look whether it came.
_INDIVISIBLE = (
    "<frozen importlib._bootstrap>",
    "llvmlite/binding/executionengine.py",
    "numba/core/caching.py",
    "numba/core/serialize.py",
)


def _indivisible(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.endswith(_INDIVISIBLE):
            return True
        frame = frame.f_back
    return False


def _again() -> None:
    """Let Ctrl-C come once more, in a moment. A thread would have to be started, and that wait can be interrupted."""
    signal.signal(signal.SIGALRM, _on_interrupt)
    signal.setitimer(signal.ITIMER_REAL, _AGAIN_S)


def _leave(last_words: str) -> None:
    try:
        os.write(2, last_words.encode())
    finally:
        os._exit(EXIT_INTERRUPTED)


if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else our parent has it ignored
    signal.signal(signal.SIGINT, _on_interrupt)


def main() -> None:
    """The program ``snakebot``."""
    global _at_work
    sys.unraisablehook = _on_unraisable
    from snakebot.cli.main import main as command_line

    try:
        try:
            _at_work = True
            command_line()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # the work is done, and its status stands
    except KeyboardInterrupt:  # while the command line was about to end
        _leave("")
    except SystemExit as ended:
        if (
            ended.code == EXIT_INTERRUPTED
        ):  # Python may have seen the KeyboardInterrupt go by, and end by signal
            try:
                sys.stdout.flush()
            finally:
                _leave("")
        raise


def _on_unraisable(unraisable: sys.UnraisableHookArgs) -> None:
    """Ctrl-C in a finaliser: Python would print it and go on; it comes again in a moment, where it can be raised."""
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
        return
    _again()
