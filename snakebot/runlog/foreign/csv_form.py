"""Finds out how a CSV is written: its delimiter, its decimal sign, where its header is."""

from __future__ import annotations

import csv
import gzip
import zlib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from snakebot.errors import BadInputError
from snakebot.runlog.number_table import CsvForm, number, spaced, uncommented

SAMPLE_BYTES = 64 << 10  # of the file's beginning; chosen: hundreds of rows
SAMPLE_ROWS = 200  # by which its form is found out, behind the rows to skip; chosen
_DELIMITERS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "spaces"}
_ENCODINGS = ("utf-8", "cp1252")  # what a spreadsheet in the west writes where it does not write UTF-8


@dataclass(frozen=True)
class FoundForm:
    """A form, and the first rows as it reads them."""

    form: CsvForm
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __str__(self) -> str:
        between = _DELIMITERS.get(self.form.delimiter, repr(self.form.delimiter))
        decimal = "comma" if self.form.decimal == "," else "point"
        told = [f"{between} between columns", f"decimal {decimal}"]
        if self.form.skip_rows:
            told.append(f"header in row {self.form.skip_rows + 1}")
        if not self.form.header:
            told.append("no header: columns are c1, c2, ...")
        if self.form.encoding != "utf-8":
            told.append(self.form.encoding)
        return ", ".join(told)


def find_form(
    path: Path, delimiter: str | None = None, decimal: str | None = None, skip_rows: int | None = None
) -> FoundForm:
    """The form of a CSV, from its beginning; what is given is not looked for.

    Raises:
        BadInputError: one line; the file cannot be read, or no form makes a table of numbers of it.
    """
    text, encoding = _beginning(path)
    lines = text.splitlines()
    best: tuple[tuple[float, ...], FoundForm] | None = None
    for sign in (delimiter,) if delimiter else _DELIMITERS:
        for point in (decimal,) if decimal else (".", ","):
            if sign == point:
                continue
            found = _try(lines, sign, point, skip_rows, encoding)
            if found is not None and (best is None or found[0] > best[0]):
                best = found
    if best is None:
        raise BadInputError(
            f"{path}: row 1: found no table of numbers in it; name the delimiter with --delimiter"
        )
    return best[1]


def _beginning(path: Path) -> tuple[str, str]:
    """The first whole lines, and how they are encoded."""
    try:
        with path.open("rb") as raw:
            if path.name.endswith(".gz"):
                with gzip.open(raw) as unpacked:
                    data = unpacked.read(SAMPLE_BYTES)
            else:
                data = raw.read(SAMPLE_BYTES)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise BadInputError(f"{path}: not a whole gzip file: {error}") from None
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the table: {error.strerror or error}") from None
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise BadInputError(f"{path}: UTF-16 text; save the table as UTF-8")
    if len(data) == SAMPLE_BYTES and b"\n" in data:
        data = data[: data.rindex(b"\n") + 1]
    for encoding in _ENCODINGS:
        try:
            return data.decode("utf-8-sig" if encoding == "utf-8" else encoding), encoding
        except UnicodeDecodeError:
            continue
    raise BadInputError(f"{path}: row 1: not text")


def _try(
    lines: list[str], delimiter: str, decimal: str, skip_rows: int | None, encoding: str
) -> tuple[tuple[float, ...], FoundForm] | None:
    """How well a form fits, and what it reads; None where it makes no table."""
    rows = [_cells(line, delimiter) for line in lines[: SAMPLE_ROWS + (skip_rows or 0)]]
    numeric = [_numeric_share(row, decimal) for row in rows]
    like = [
        i for i, share in enumerate(numeric) if i >= (skip_rows or 0) and share >= 0.5 and len(rows[i]) > 1
    ]
    if not like:
        return None
    width = Counter(len(rows[i]) for i in like).most_common(1)[0][0]
    first = next(i for i in like if len(rows[i]) == width)
    body = [row for row in rows[first:] if len(row) == width]
    above = first - 1
    if skip_rows is not None:
        above = skip_rows if first > skip_rows else -1
    header_at = above if above >= 0 and _is_header(rows[above], width, decimal) else None
    if header_at is None and skip_rows is None and above >= 0 and any(rows[above]):
        return None  # something stands above the numbers, and this form makes no names of it
    names = rows[header_at] if header_at is not None else [f"c{i + 1}" for i in range(width)]
    form = CsvForm(
        delimiter, decimal, (first if header_at is None else header_at), header_at is not None, encoding
    )
    share = sum(_numeric_share(row, decimal) for row in body) / len(body)
    whole = len(body) / max(1, sum(1 for row in rows[first:] if row))
    fit = (round(whole * share, 2), float(header_at is not None), float(width), float(decimal == "."))
    return fit, FoundForm(form, tuple(uncommented(list(names))), tuple(tuple(row) for row in body[:5]))


def _cells(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return spaced(line).split(" ") if line.strip() else []
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, strict=True), [])]
    except csv.Error:
        return []


def _is_header(row: list[str], width: int, decimal: str) -> bool:
    names = [name for name in row if name]
    return len(row) == width == len(names) and _numeric_share(row, decimal) < 0.5


def _numeric_share(row: list[str], decimal: str) -> float:
    """Share of the cells that are numbers, those that are empty left out of the count."""
    filled = [cell for cell in row if cell]
    if not filled:
        return 0.0
    texts = [cell.replace(decimal, ".") if decimal != "." else cell for cell in filled]
    good = sum(
        1
        for cell, text in zip(filled, texts, strict=True)
        if number(text) is not None and not (decimal != "." and "." in cell)
    )
    return good / len(filled)
