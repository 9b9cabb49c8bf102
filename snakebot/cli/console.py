"""Where tables are printed."""

from __future__ import annotations

from typing import NoReturn

from rich.console import Console


class StandardOutput(Console):
    """Rich would end the program with status 1 where the reader of its output has gone, as with ``| head``."""

    def __init__(self) -> None:
        super().__init__(highlight=False)

    def on_broken_pipe(self) -> NoReturn:
        raise BrokenPipeError
