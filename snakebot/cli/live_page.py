"""``--view``: the page of a run, or of several, for commands that move a robot."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.cli.run_options import RunOptions
    from snakebot.control import RunLoop
    from snakebot.robot import Robot
    from snakebot.view.feed import Feed


def check_view(options: RunOptions, *, several: bool = False) -> bool:
    """Whether --view is given.

    A single run in virtual time is over before a page is open. The page of ``several`` tells what has become of them,
    too, so it goes with --fast.

    Raises:
        BadInputError: it is not, but an option of the page is; or a single run with --fast.
    """
    if options.view:
        if options.fast and not several:
            raise BadInputError(
                "--view shows a run in real time: not with --fast; `snakebot view LOG` plays its log"
            )
        return True
    others = {"view_address": "--view-address", "view_port": "--view-port", "view_stop": "--view-stop"}
    for name, option in others.items():
        if getattr(options, name) not in (None, False):
            raise BadInputError(f"{option} goes with --view")
    return False


def open_view(robot: Robot, title: str, options: RunOptions, page: Feed | None) -> Feed | None:
    """Serve the page, if it is wanted, and say where. The address goes to standard error: --json stays JSON.

    A run that is one of several is shown on their ``page``.

    Raises:
        BadInputError: an option of the page without --view, or it cannot be served there.
    """
    if not check_view(options, several=page is not None) and page is None:
        return None
    from snakebot.view.feed import about_run

    about = about_run(robot, title, port=options.port)
    if page is not None:
        page.begin(about)
        return page
    return open_page(about, options)


def open_page(
    about: Mapping[str, Any],
    options: RunOptions,
    *,
    several: bool = False,
    between_runs: Callable[[str], None] = lambda what: None,
) -> Feed | None:
    """Serve a page of one run or ``several``, if it is wanted, and say where.

    Raises:
        BadInputError: an option of the page without --view, or it cannot be served there.
    """
    if not check_view(options, several=several):
        return None
    from snakebot.view import DEFAULT_PORT, LOOPBACK
    from snakebot.view.feed import Feed, ViewSettings

    settings = ViewSettings(
        address=options.view_address or LOOPBACK,
        port=DEFAULT_PORT if options.view_port is None else options.view_port,
        stop_on_close=options.view_stop,
    )
    feed = Feed(settings, about, several=several, between_runs=between_runs)
    click.echo(f"page: {feed.url}", err=True)
    return feed


@contextlib.contextmanager
def serving(feed: Feed | None, loop: RunLoop, log: Path) -> Iterator[None]:
    """Do what the page asks for while the run lasts."""
    if feed is None:
        yield
        return
    try:
        with feed.serving(loop, log):
            yield
    finally:
        if not feed.several:
            feed.close()
