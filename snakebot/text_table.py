"""Tables in columns of text: as wide as they need be in a file, and in blocks below each other on a narrow terminal."""

from __future__ import annotations

import shutil
import sys
from collections import Counter
from collections.abc import Sequence

from snakebot.in_words import shortened

_GAP = "  "
_NARROWEST = 60  # columns of a terminal below which nothing is broken any further; chosen


def screen_columns() -> int | None:
    """Columns of the terminal that standard output is, or COLUMNS. None where it is a file or a pipe."""
    if not sys.stdout.isatty():
        return None
    return shutil.get_terminal_size().columns


def shortened_apart(texts: Sequence[str], most: int = 44) -> list[str]:
    """Each text with its middle left out where it is longer than ``most``; those that become alike get a number."""
    short = [shortened(text, most) for text in texts]
    full = {brief: {t for t, s in zip(texts, short, strict=True) if s == brief} for brief in short}
    seen: Counter[str] = Counter()
    apart = []
    for text, brief in zip(texts, short, strict=True):
        if len(full[brief]) > 1:
            seen[brief] += 1
            mark = f" #{seen[brief]}"
            brief = shortened(text, most - len(mark)) + mark
        apart.append(brief)
    return apart


def set_in_columns(
    rows: Sequence[Sequence[str]],
    flush_right: Sequence[bool],
    heads: int = 1,
    screen: int | None = None,
    keys: int = 1,
) -> list[str]:
    """Lines of a table whose first ``heads`` rows name the columns.

    Where it is wider than ``screen``, the columns that do not fit go into further blocks below, each with the first
    ``keys`` columns again; long texts lose their middle. No column is left out, and no number is cut.
    """
    columns = [list(column) for column in zip(*rows, strict=True)]
    widths = [max(map(len, column)) for column in columns]
    if screen is None or sum(widths) + len(_GAP) * (len(widths) - 1) <= screen:
        return _block(columns, flush_right, heads)
    screen = max(screen, _NARROWEST)
    columns[0] = columns[0][:heads] + shortened_apart(columns[0][heads:], 2 * screen // 5)
    repeated = list(range(keys))
    room = screen - sum(max(map(len, columns[i])) for i in repeated) - len(_GAP) * (keys - 1)
    blocks: list[list[int]] = [[]]
    left = room
    for index in range(keys, len(columns)):
        if not flush_right[index]:
            columns[index] = [shortened(cell, max(room - len(_GAP), 12)) for cell in columns[index]]
        width = len(_GAP) + max(map(len, columns[index]))
        if width > left and blocks[-1]:
            blocks.append([])
            left = room
        blocks[-1].append(index)
        left -= width
    lines: list[str] = []
    for number, block in enumerate(blocks):
        chosen = [*repeated, *block]
        lines += [""] if number else []
        lines += _block([columns[i] for i in chosen], [flush_right[i] for i in chosen], heads)
    return lines


def _block(columns: Sequence[Sequence[str]], flush_right: Sequence[bool], heads: int) -> list[str]:
    set_columns = []
    for column, right in zip(columns, flush_right, strict=True):
        width = max(map(len, column))
        set_columns.append([cell.rjust(width) if right else cell.ljust(width) for cell in column])
    lines = [_GAP.join(row).rstrip() for row in zip(*set_columns, strict=True)]
    return [
        line for number, line in enumerate(lines) if line or number >= heads
    ]  # no units, no line of units
