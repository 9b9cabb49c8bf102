"""Options of every command that reads a table which another program wrote: its column map, and how it is written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import click

from snakebot.cli.typed_options import Option, given
from snakebot.errors import BadInputError


@dataclass(frozen=True)
class MapOptions:
    """What the options of ``map_options`` say, as they are typed."""

    entries: tuple[str, ...]
    map_file: Path | None
    delimiter: str | None
    decimal: str | None
    skip_rows: int | None

    def all_entries(self) -> list[str]:
        """The entries of ``--map`` and ``--map-file``.

        Raises:
            BadInputError: the file cannot be read, or is no text.
        """
        entries = list(self.entries)
        if self.map_file is not None:
            try:
                lines = self.map_file.read_text(encoding="utf-8").splitlines()
            except OSError as error:
                raise BadInputError(
                    f"{self.map_file}: cannot read the column map: {error.strerror}"
                ) from None
            except UnicodeDecodeError:
                raise BadInputError(f"{self.map_file}: not a column map: no UTF-8 text") from None
            entries += [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
        return entries

    def separator(self) -> str | None:
        """The character that ``--delimiter`` says.

        Raises:
            BadInputError: no single character.
        """
        if self.delimiter is None:
            return None
        separator = {"tab": "\t", "space": " "}.get(self.delimiter, self.delimiter)
        if len(separator) != 1:
            raise BadInputError(f"--delimiter {separator!r}: give one character, or 'tab'")
        return separator


def map_options(entries: str, map_file: str, delimiter: str, decimal: str, skip_rows: str) -> Option:
    """The options of ``MapOptions``, in this order in the help of a command, which says what they are there."""
    options = (
        click.option("--map", "entries", multiple=True, help=entries),
        click.option("--map-file", type=click.Path(path_type=Path), help=map_file),
        click.option("--delimiter", help=delimiter),
        click.option("--decimal", type=click.Choice([".", ","]), help=decimal),
        click.option("--skip-rows", type=click.IntRange(min=0), help=skip_rows),
    )
    return lambda command: given(command, options)
