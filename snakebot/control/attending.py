"""What else is done while a run goes on: signals, pictures, pages. The run loop knows nothing of it."""

from __future__ import annotations

import contextlib
import signal
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from snakebot.control import registry
from snakebot.runlog import records

if TYPE_CHECKING:
    from snakebot.control.loop import RunLoop
    from snakebot.runlog import RunWriter

Handler = Callable[..., None]


class Attendant:
    """Attends one run. This one lets ``snakebot stop`` find and stop it; Ctrl-C raises KeyboardInterrupt as ever, and
    the joints are held and relaxed.

    Subclasses add to it, and call what they extend.

    Args:
        port: where the board is, as for ``--port``.

    Attributes:
        tap: is handed each record of the log, see ``RunWriter``.
    """

    tap: Callable[[int, int, bytes], None] | None = None

    def __init__(self, port: str) -> None:
        self.port = port

    def tell(self, line: str) -> None:
        """Something that the user should know."""
        warnings.warn(line, RuntimeWarning, stacklevel=2)

    @contextlib.contextmanager
    def until_logged(self, loop: RunLoop) -> Iterator[None]:
        """From before the board is armed until the log is whole."""
        with signals_handled({registry.STOP_SIGNAL: lambda *_: loop.request_emergency_stop()}):
            yield

    @contextlib.contextmanager
    def while_running(self, loop: RunLoop, log: RunWriter) -> Iterator[None]:
        """From before the board is armed until its joints are relaxed; ``loop`` may be asked for things."""
        if threading.current_thread() is not threading.main_thread():
            yield  # signals are not ours
            return
        with registry.registered(self.port) as known:
            if not known:
                places = " and ".join(map(str, registry.SHARED))
                message = f"`snakebot stop` cannot find this run: neither {places} can be written to; Ctrl-C stops it"
                self.tell(message)
                log.event(records.Event(0.0, "unregistered", message, "warning"))
            yield


@contextlib.contextmanager
def signals_handled(handlers: Mapping[signal.Signals, Handler]) -> Iterator[None]:
    """Handle signals for a while. Does nothing outside the main thread, which alone can have handlers."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before: dict[signal.Signals, Any] = {
        number: signal.signal(number, handler) for number, handler in handlers.items()
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
