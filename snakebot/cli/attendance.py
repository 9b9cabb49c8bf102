"""What a person at a terminal has of a run: signals, the live panel and its keys, the page."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from snakebot.cli import ctrl_c
from snakebot.cli.live_page import serving
from snakebot.control.attending import Attendant, signals_handled

if TYPE_CHECKING:
    from snakebot.cli.run_options import RunOptions
    from snakebot.control import RunLoop, RunPlan
    from snakebot.robot import Robot
    from snakebot.runlog import RunWriter
    from snakebot.view.feed import Feed

_PANEL_S = 0.15  # between two pictures of the live panel


def tell(line: str) -> None:
    """Something that the user should know."""
    with contextlib.suppress(OSError):
        click.echo(f"snakebot: warning: {line}", err=True)


@contextlib.contextmanager
def signals_ramp_down(loop: RunLoop) -> Iterator[None]:
    """Ctrl-C, SIGTERM and a closed terminal ramp down."""
    from snakebot.cli.terminal import leave_dead_terminal

    def hung_up(*_: object) -> None:
        leave_dead_terminal()
        loop.request_stop()

    handlers = {
        signal.SIGINT: lambda *_: loop.interrupt(),
        signal.SIGTERM: lambda *_: loop.request_stop(),
        signal.SIGHUP: hung_up,  # shell and terminal may both send it, the shell more than once
    }
    with signals_handled(handlers):
        if ctrl_c.pressed:  # earlier, and what it raised got lost: nothing moves yet
            raise KeyboardInterrupt
        yield


class Attended(Attendant):
    """Attends a run for the command line.

    Attributes:
        log_path: of the run's log, once it has begun.
    """

    def __init__(self, robot: Robot, plan: RunPlan, options: RunOptions, feed: Feed | None) -> None:
        super().__init__(options.port)
        self.log_path: Path | None = None
        self.tap = feed.tap if feed is not None else None
        self._robot = robot
        self._plan = plan
        self._options = options
        self._feed = feed

    def tell(self, line: str) -> None:
        tell(line)

    @contextlib.contextmanager
    def until_logged(self, loop: RunLoop) -> Iterator[None]:
        """Ctrl-C, SIGTERM and a closed terminal ramp down; the stop signal cuts the power."""
        with signals_ramp_down(loop), super().until_logged(loop):
            yield

    @contextlib.contextmanager
    def while_running(self, loop: RunLoop, log: RunWriter) -> Iterator[None]:
        self.log_path = log.path
        with super().while_running(loop, log), self._panel(loop), serving(self._feed, loop, log.path):
            yield

    @contextlib.contextmanager
    def _panel(self, loop: RunLoop) -> Iterator[None]:
        """The live panel, drawn by a thread of its own, and its keys; nothing where nobody looks."""
        options, gait = self._options, self._plan.gait
        if options.as_json or options.fast or not sys.stdout.isatty():
            yield
            return
        from rich.live import Live

        from snakebot.cli import keys
        from snakebot.cli.panel import panel
        from snakebot.cli.terminal import leave_dead_terminal

        done = threading.Event()
        before = sys.getswitchinterval()
        sys.setswitchinterval(2e-4)  # drawing takes milliseconds: the loop must get in between
        with contextlib.ExitStack() as stack:
            live = stack.enter_context(Live(auto_refresh=False, transient=True))
            stack.enter_context(keys.listening(loop, gait))
            pressed = keys.shown(gait) if sys.stdin.isatty() else ""

            # In a low terminal the panel pushes what was printed before it out of sight.
            foot = options.port if self._feed is None else f"page: {self._feed.url}   {options.port}"

            def draw() -> None:
                title = self._plan.title
                while not done.wait(_PANEL_S):
                    asked = loop.gait if loop.progress.ticks else None  # by keys, or in the page
                    if gait is not None and asked is not None:
                        title = self._plan.title if asked == gait else str(asked)
                    drawn = panel(
                        loop.progress,
                        title,
                        foot,
                        pressed,
                        self._robot.angle_limit_rad,
                        live.console.width,
                        live.console.height,
                    )
                    try:
                        live.update(drawn, refresh=True)
                    except OSError:  # the terminal has gone, and with some shells no signal tells
                        leave_dead_terminal()
                        return

            thread = threading.Thread(target=draw, name="panel", daemon=True)
            thread.start()
            try:
                yield
            finally:
                done.set()
                thread.join(timeout=2.0)
                leave_dead_terminal()  # before the last picture is taken off it
                sys.setswitchinterval(before)
