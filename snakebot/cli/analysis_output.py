"""What ``analyze`` and ``compare`` have in common when they write."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from snakebot.errors import BadInputError

if TYPE_CHECKING:
    from snakebot.report import Page


def command_line() -> str:
    """The command that made a report, for its foot: a figure can then be made again."""
    from snakebot import __version__

    return f"{shlex.join(['snakebot', *sys.argv[1:]])} · snakebot {__version__}"


def write_page(page: Page, path: Path, inputs: Iterable[Path]) -> None:
    """Write a report, but never over what it was made from.

    Raises:
        BadInputError: ``path`` is one of the inputs, or cannot be written.
    """
    if path.exists() and any(given.exists() and path.samefile(given) for given in inputs):
        raise BadInputError(
            f"--report {path}: is one of the runs; give another name, for example report.html"
        )
    page.write(path)
