"""How far a diagnosis is, how long it still takes, and what is known of the answer so far."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

import click

LEAST_S, LEAST_SHARE = 3.0, 0.03  # before a time left is told; chosen
GRAIN_S = 5.0  # of the time left; chosen
SO_FAR = "so far: "  # what a progress text begins with that tells of the answer


class Pace:
    """The share that is done never falls, and the time left is by the pace of the later half of the time so far."""

    def __init__(self, clock: Callable[[], float] = monotonic) -> None:
        self._clock, self._start = clock, clock()
        self._history = [(0.0, 0.0)]
        self.share, self.text, self.so_far = 0.0, "", ""

    def tell(self, text: str, share: float) -> None:
        from snakebot.diagnosis.show.named import plain

        self.share = max(self.share, min(share, 1.0))
        self._history.append((self._clock() - self._start, self.share))
        if text.startswith(SO_FAR):
            self.so_far = plain(text.removeprefix(SO_FAR))
        elif text:
            self.text = plain(text)

    def left_s(self) -> float | None:
        """None while nothing can be said."""
        now = self._clock() - self._start
        if now < LEAST_S or not LEAST_SHARE <= self.share < 1:
            return None
        then, done = next(entry for entry in reversed(self._history) if entry[0] <= now / 2)
        pace = max((self.share - done) / max(now - then, 1e-9), 0.25 * self.share / now)
        return (1 - self.share) / pace

    @property
    def left_text(self) -> str:
        left = self.left_s()
        if left is None:
            return ""
        if left >= 90:
            return f"about {left / 60:.0f} min left"
        return f"about {max(GRAIN_S, GRAIN_S * round(left / GRAIN_S)):.0f} s left"

    @property
    def last_words(self) -> str:
        """What is known when somebody has had enough of waiting."""
        known = f"; so far: {self.so_far}, not yet weighed against others" if self.so_far else ""
        return f"stopped at {100 * self.share:.0f} %{known}"


@contextlib.contextmanager
def shown(quiet: bool) -> Iterator[Callable[[str, float], None]]:
    """A bar with what is being tried and the time left, on a terminal; Ctrl-C says what is known, everywhere."""
    pace = Pace()
    try:
        if quiet or not sys.stderr.isatty():
            yield pace.tell
        else:
            with _bar(pace) as tell:
                yield tell
    except KeyboardInterrupt:
        click.echo(f"snakebot: {pace.last_words}", err=True)
        raise


@contextlib.contextmanager
def _bar(pace: Pace) -> Iterator[Callable[[str, float], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns: tuple[Any, ...] = (
        SpinnerColumn(),
        BarColumn(bar_width=24),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
        TextColumn("{task.description}"),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0, left="")

        def tell(text: str, share: float) -> None:
            pace.tell(text, share)
            told = f"{pace.text} ({pace.so_far} so far)" if pace.so_far else pace.text
            bar.update(task, completed=pace.share, description=told, left=pace.left_text)

        yield tell
