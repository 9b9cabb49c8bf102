"""What all studies' commands share: options, progress, and how a result is printed."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import click

from snakebot.cli.robot_option import robot_option
from snakebot.text_table import screen_columns, set_in_columns


def common(function: Callable[..., None]) -> Callable[..., None]:
    """Options that every study has."""
    for option in (
        click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object."),
        click.option(
            "--out",
            type=click.Path(path_type=Path, file_okay=False),
            help="Folder [results/<study>_<robot>].",
        ),
        robot_option(),
    ):
        function = option(function)
    return function


@contextlib.contextmanager
def progress_bar(title: str, as_json: bool) -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error; silent where nobody looks."""
    if as_json or not sys.stderr.isatty():
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)

        def update(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        yield update


def finish(summary: dict[str, Any], as_json: bool, show: Callable[[], None], files: list[Path]) -> None:
    """Print the summary as JSON or through ``show``, and where the files are."""
    summary = {**summary, "files": [str(path) for path in files]}
    if as_json:
        click.echo(json.dumps(summary))
        return
    show()
    for path in files:
        click.echo(str(path))


def table_text(
    title: str,
    head: Sequence[str],
    body: Sequence[Sequence[str]],
    left: Sequence[int] = (),
    screen: int | None = 0,
) -> str:
    """A table as plain text, columns aligned to the right (``left``: those to the left): readable in a file, too.

    On a terminal that is too narrow it comes in blocks; ``screen`` is its columns (0: as they are, None: never mind).
    """
    right = [column not in left for column in range(len(head))]
    lines = set_in_columns([head, *body], right, screen=screen_columns() if screen == 0 else screen)
    return "\n".join([title, *lines, ""])
