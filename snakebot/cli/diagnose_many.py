"""``snakebot diagnose SESSIONS... --table``: each session for itself, a row of a table each."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from snakebot.errors import EXIT_BAD_INPUT, BadInputError
from snakebot.whole_files import in_the_way

if TYPE_CHECKING:
    from snakebot.diagnosis.many import SessionAnswer
    from snakebot.runlog import Session


_FIRST_COLUMNS = ["session", "refused", "verdict"]  # of ``SessionAnswer.row``


def diagnose_to_table(
    sources: Sequence[Path],
    path: Path,
    dask: str | None,
    options: Mapping[str, Any],
    opened: Callable[[Path], Session],
) -> None:
    """Diagnose, write the table, say a line of each session; exit status 2 where one has no verdict.

    Raises:
        BadInputError: a session is given twice, or no scheduler answers.
    """
    from snakebot.cli.study_output import progress_bar
    from snakebot.cluster import Workers
    from snakebot.diagnosis.many import diagnose_many

    _check_earlier(path)
    for source in sources:
        if list(sources).count(source) > 1:
            raise BadInputError(f"{source}: given twice")
    with Workers(dask) as workers, progress_bar("sessions", False) as progress:
        sessions = {str(source): _opened(source, opened) for source in sources}
        answers = diagnose_many(sessions, options, workers, progress)
    told = [_line(answer) for answer in answers]
    if all(answer.refused for answer in answers) and path.exists():
        told.append(f"{path}: stays as it is: no session has a verdict")
    else:
        _write(path, answers)
        told.append(f"wrote {path}")
    for line in told:
        click.echo(line)
    if any(answer.refused for answer in answers):
        sys.exit(EXIT_BAD_INPUT)


def _check_earlier(path: Path) -> None:
    """
    Raises:
        BadInputError: a Parquet file is there that is no table of verdicts: a recording, perhaps.
    """
    if not path.is_file() or path.stat().st_size == 0:
        return
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        names = pq.read_schema(path).names
    except (pa.ArrowException, OSError):
        names = []
    if names[: len(_FIRST_COLUMNS)] != _FIRST_COLUMNS:
        raise in_the_way("--table", path, "table")


def _opened(source: Path, opened: Callable[[Path], Session]) -> Session | BadInputError:
    try:
        return opened(source)
    except BadInputError as error:
        return error


def _line(answer: SessionAnswer) -> str:
    row = answer.row()
    if answer.refused:
        return f"{answer.name}: no verdict: {answer.refused}"
    causes = ", ".join(
        f"{cause} ({probability:.0%})"
        for cause, probability in zip(row["causes"], row["probability"], strict=True)
    )
    return f"{answer.name}: {row['verdict'].replace('_', ' ')}{f': {causes}' if causes else ''}"


def _write(path: Path, answers: Sequence[SessionAnswer]) -> None:
    """
    Raises:
        BadInputError: the file cannot be written.
    """
    import pyarrow as pa

    from snakebot.studies.sweep import write_parquet

    texts, numbers = ("session", "refused", "verdict", "json"), ("rms_before_rad", "rms_after_rad", "closed")
    kinds = {
        **dict.fromkeys(texts, pa.string()),
        **dict.fromkeys(numbers, pa.float64()),
        "causes": pa.list_(pa.string()),
        "probability": pa.list_(pa.float64()),
    }
    rows = [answer.row() for answer in answers]
    schema = pa.schema([(name, kinds[name]) for name in rows[0]])
    write_parquet(path, pa.Table.from_pylist(rows, schema=schema))
