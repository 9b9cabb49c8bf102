"""What ``analyze`` and ``compare`` have in common when they write."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from snakebot.report import Page


def command_line() -> str:
    """The command that made a report, for its foot: a figure can then be made again."""
    from snakebot import __version__

    return f"{shlex.join(['snakebot', *sys.argv[1:]])} · snakebot {__version__}"


def write_page(page: Page, path: Path) -> None:
    """Write a report, but over nothing else than an earlier one.

    Raises:
        BadInputError: ``path`` is another file, or cannot be written.
    """
    from snakebot.whole_files import check_output

    check_output("--report", path, "report")
    page.write(path)
