"""Reads a table of numbers (CSV, CSV.gz, Parquet) strictly: what is no number is an error that says where.

Sizes are limited while reading, never after: a line, the number of cells, the bytes that a .gz unpacks to.
"""

from __future__ import annotations

import csv
import gzip
import io
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError

MAX_LINE_BYTES = 64 << 10  # of one row; chosen: 1,024 cells of 64 characters
MAX_COLUMNS = 1024  # chosen: a session of 16 joints has less than 100
MAX_CELLS = 50_000_000  # 400 MB of float64
MAX_TABLE_BYTES = 1 << 30  # decompressed text
MAX_RATIO = 400  # unpacked to stored: more is a decompression bomb, no log and no measurements; chosen
FREE_BYTES = 32 << 20  # a table may unpack to this, however small its file; beyond it:
BLOCK_CELLS = 1 << 17  # read as text at once: a cell takes 8 bytes as a number, 100 until it is one

TABLE_SUFFIXES = (".csv", ".csv.gz", ".parquet")


def stem_and_suffix(name: str) -> tuple[str, str]:
    """The name of a table in two; of anything else the name and nothing."""
    suffix = next((suffix for suffix in TABLE_SUFFIXES if name.endswith(suffix)), "")
    return name.removesuffix(suffix), suffix


@dataclass(frozen=True)
class CsvForm:
    """How a CSV is written, where it is not ours."""

    delimiter: str = ","
    decimal: str = "."
    skip_rows: int = 0  # lines before the header
    header: bool = True  # without one, columns are c1, c2, ...
    encoding: str = "utf-8"


class NumberTable(NamedTuple):
    columns: dict[str, Floats]  # numeric columns, each (N,); empty cell = nan
    texts: tuple[str, ...]  # names of columns that are not numbers, where the caller allows those
    first_row: int  # number of sample 0's row: in a CSV as an editor counts lines, in a Parquet 1


def read_table(
    path: Path, must_be_numbers: frozenset[str] | None = None, dialect: CsvForm | None = None
) -> NumberTable:
    """Read a table.

    Args:
        must_be_numbers: columns in which text is an error; in others text only drops the column. None: all.
        dialect: of a CSV, whatever its name; by default commas and points.

    Raises:
        BadInputError: one line with file, row and column.
    """
    if path.name.endswith(".parquet"):
        return _read_parquet(path, must_be_numbers)
    if dialect is None and not path.name.endswith((".csv", ".csv.gz")):
        raise BadInputError(f"{path}: not a table that is read here ({', '.join(TABLE_SUFFIXES)})")
    try:
        with path.open("rb") as raw:
            if path.name.endswith(".gz"):
                with gzip.open(raw) as unpacked:
                    lines = io.BufferedReader(unpacked)  # whose readline is not Python, a line at a time
                    return _read_csv(path, lines, must_be_numbers, dialect or CsvForm())
            return _read_csv(path, raw, must_be_numbers, dialect or CsvForm())
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise BadInputError(f"{path}: not a whole gzip file: {error}") from None
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the table: {error.strerror or error}") from None


def _lines(path: Path, file: BinaryIO | io.BufferedReader, encoding: str = "utf-8") -> Iterator[str]:
    total = 0
    row = 0
    allowed = _allowed_bytes(path)
    while line := file.readline(MAX_LINE_BYTES):
        row += 1
        total += len(line)
        if b"\r" in line[:-2] and b'"' not in line:
            raise BadInputError(f"{path}: row {row}: lines end in CR alone; save the table with LF or CRLF")
        if len(line) == MAX_LINE_BYTES and not line.endswith(b"\n"):
            raise BadInputError(f"{path}: row {row}: longer than {MAX_LINE_BYTES >> 10} KiB; not a table")
        if total > allowed:
            raise BadInputError(f"{path}: unpacks to more than {allowed >> 20} MiB; not read")
        try:
            yield line.decode("utf-8-sig" if row == 1 and encoding == "utf-8" else encoding)
        except UnicodeDecodeError:
            named = "UTF-8" if encoding == "utf-8" else encoding
            raise BadInputError(f"{path}: row {row}: not {named} text") from None


def _allowed_bytes(path: Path) -> int:
    """What a table may unpack to."""
    return min(MAX_TABLE_BYTES, FREE_BYTES + MAX_RATIO * path.stat().st_size)


def _read_csv(
    path: Path, file: BinaryIO | io.BufferedReader, must_be_numbers: frozenset[str] | None, dialect: CsvForm
) -> NumberTable:
    lines = _lines(path, file, dialect.encoding)
    if dialect.delimiter == " ":
        lines = (spaced(line) + "\n" for line in lines)
    for _ in range(dialect.skip_rows):
        next(lines, "")
    if not dialect.header:
        lines = _named(lines, dialect.delimiter)
    reader = csv.reader(lines, delimiter=dialect.delimiter, strict=True)
    try:
        header = uncommented([name.strip() for name in next(reader, [])])
        _check_header(path, header)
        strict = [must_be_numbers is None or name in must_be_numbers for name in header]
        texts = [False] * len(header)
        blocks: list[Floats] = []
        above = dialect.skip_rows - (not dialect.header)  # lines of the file before what the reader counts
        first_row = above + reader.line_num + 1
        while rows := _block(path, reader, len(header), dialect, above):
            blocks.append(_numbers(path, rows, header, strict, texts))
            if sum(map(len, blocks)) * len(header) > MAX_CELLS:
                raise BadInputError(f"{path}: more than {MAX_CELLS} cells; not read")
    except csv.Error as error:
        row = dialect.skip_rows - (not dialect.header) + reader.line_num
        raise BadInputError(f"{path}: row {row}: {error}") from None
    array = np.concatenate(blocks) if blocks else np.empty((0, len(header)))
    del blocks
    columns = {name: array[:, i].copy() for i, name in enumerate(header) if not texts[i]}
    return NumberTable(columns, tuple(name for i, name in enumerate(header) if texts[i]), first_row)


def _named(lines: Iterator[str], delimiter: str) -> Iterator[str]:
    """The lines of a table under names for its columns."""
    first = next(lines, "")
    width = len(next(csv.reader([first], delimiter=delimiter), []))
    if width:
        yield delimiter.join(f"c{i + 1}" for i in range(width)) + "\n"
        yield first
        yield from lines


def spaced(line: str) -> str:
    """A line of columns that stand apart by any number of blanks; a ``#`` before the header is none of them."""
    return " ".join(line.lstrip("#% \t").split())


def uncommented(names: list[str]) -> list[str]:
    """The names of a header that stands in a comment, as numpy writes it."""
    first = names[0].lstrip("#% \t") if names else ""
    return [first, *names[1:]] if first else names


def _other_form(width: int, cells: list[str]) -> str:
    """To follow a message about a row that does not fit its header: what the table may be."""
    if width > 1 or not any(sign in cell for cell in cells for sign in ";\t"):
        return ""
    return "; are they apart by semicolons or tabs? snakebot session import finds out"


def _check_header(path: Path, header: list[str]) -> None:
    if not any(header):
        raise BadInputError(f"{path}: row 1: the header line is missing")
    if len(header) > MAX_COLUMNS:
        raise BadInputError(f"{path}: row 1: {len(header)} columns; at most {MAX_COLUMNS} are read")
    for index, name in enumerate(header):
        if not name:
            raise BadInputError(f"{path}: row 1: column {index + 1} has no name")
        if name in header[:index]:
            raise BadInputError(f"{path}: row 1: column {name} stands twice")


_Row = tuple[int, list[str]]


def _block(path: Path, reader: Any, width: int, dialect: CsvForm, above: int) -> list[_Row]:
    """About BLOCK_CELLS cells, as rows with their row numbers; blank lines at the end of the file are no rows."""
    rows: list[_Row] = []
    for cells in reader:
        row = above + reader.line_num
        if len(cells) != width:
            if not cells and not any(any(rest) for rest in reader):
                break
            columns = f"{width} column{'s' if width != 1 else ''}"
            raise BadInputError(
                f"{path}: row {row}: {len(cells)} values for {columns}{_other_form(width, cells)}"
            )
        if dialect.decimal != ".":
            cells = [cell.replace(dialect.decimal, ".") for cell in cells]
        rows.append((row, cells))
        if len(rows) * width >= BLOCK_CELLS:
            break
    return rows


def _numbers(
    path: Path, rows: list[_Row], header: list[str], strict: list[bool], texts: list[bool]
) -> Floats:
    nan = float("nan")
    try:
        array = np.array([[float(cell) if cell else nan for cell in cells] for _, cells in rows])
        plain = all(cell.isascii() and "_" not in cell for _, cells in rows for cell in cells)
    except ValueError:
        plain = False
    if plain and not np.isinf(array).any():
        return array
    array = np.full((len(rows), len(header)), nan)
    for index, (row, cells) in enumerate(rows):
        for column, cell in enumerate(cells):
            value = number(cell)
            if value is not None:
                array[index, column] = value
            elif strict[column]:
                where = f"{path}: row {row}, column {header[column]}"
                raise BadInputError(f"{where}: not a number: {cell[:40]!r}")
            else:
                texts[column] = True
    return array


def number(cell: str) -> float | None:
    """A cell as a finite number, nan where it is empty or says so, None where it is neither."""
    text = cell.strip()
    if not text:
        return float("nan")
    try:
        value = float(text)
    except ValueError:
        return None
    # Python also reads 1_000 and the digits of every script: no logger writes those, a damaged file may hold them
    return None if "_" in text or not text.isascii() or np.isinf(value) else value


def _read_parquet(path: Path, must_be_numbers: frozenset[str] | None) -> NumberTable:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(
            path, thrift_string_size_limit=1 << 24, thrift_container_size_limit=1 << 20
        ) as file:
            return _parquet_columns(path, file, must_be_numbers)
    except (pa.ArrowException, ValueError) as error:
        raise BadInputError(f"{path}: not a Parquet table: {' '.join(str(error).split())[:200]}") from None
    except OSError as error:
        why = error.strerror or " ".join(str(error).split())[:200]
        raise BadInputError(f"{path}: cannot read the table: {why}") from None


def _parquet_columns(path: Path, file: Any, must_be_numbers: frozenset[str] | None) -> NumberTable:
    import pyarrow as pa

    about, schema = file.metadata, file.schema_arrow
    names = list(schema.names)
    _check_header(path, names)
    unpacked = sum(about.row_group(i).total_byte_size for i in range(about.num_row_groups))
    cells, allowed = about.num_rows * max(1, len(names)), _allowed_bytes(path)
    if cells > MAX_CELLS or 8 * cells > allowed or unpacked > allowed:
        raise BadInputError(f"{path}: {about.num_rows} rows of {len(names)} columns are too many; not read")
    texts = []
    for field in schema:
        numeric = pa.types.is_integer(field.type) or pa.types.is_floating(field.type)
        if not numeric and not pa.types.is_boolean(field.type):
            if must_be_numbers is None or field.name in must_be_numbers:
                raise BadInputError(f"{path}: column {field.name}: not numbers but {field.type}")
            texts.append(field.name)
    wanted = [name for name in names if name not in texts]
    parts: dict[str, list[Floats]] = {name: [] for name in wanted}
    seen = 0
    for batch in file.iter_batches(batch_size=65536, columns=wanted, use_threads=False):
        seen += batch.num_rows
        if seen > about.num_rows:
            raise BadInputError(f"{path}: holds more rows than it says; not read")
        for name in wanted:
            values = batch.column(name).cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
            parts[name].append(values.astype(np.float64, copy=False))
    columns = {name: np.concatenate(part) if part else np.empty(0) for name, part in parts.items()}
    for name, values in columns.items():
        infinite = np.flatnonzero(np.isinf(values))
        if infinite.size:
            raise BadInputError(f"{path}: row {infinite[0] + 1}, column {name}: not a number: infinite")
    return NumberTable(columns, tuple(texts), 1)
