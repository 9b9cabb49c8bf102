"""What to tell somebody who gave a recording that is not in a form of ours: the command that brings it into one."""

from __future__ import annotations

import shlex
from itertools import islice
from pathlib import Path

_TABLES = (".csv", ".csv.gz", ".parquet", ".tsv", ".txt", ".dat")
_BAGS = (".mcap", ".db3")
_LOOKED_AT = 1000  # names of a folder
_NAMED = 3  # tables of a folder


def import_hint(path: Path) -> str:
    """To follow a message: ``; make a session of it: snakebot session import run.csv -o SESSION``, or nothing."""
    try:
        sources = _sources(path)
    except OSError:
        return ""
    if not sources:
        return ""
    named = " ".join(shlex.quote(str(source)) for source in sources[:_NAMED])
    more = " ..." if len(sources) > _NAMED else ""
    return f"; make a session of it: snakebot session import {named}{more} -o SESSION"


def _sources(path: Path) -> list[Path]:
    """What of a file or folder can be imported."""
    if not path.is_dir():
        return [path] if path.is_file() and path.name.endswith((*_TABLES, *_BAGS)) else []
    if (path / "meta" / "info.json").is_file() or (path / "metadata.yaml").is_file():
        return [path]
    within = sorted(islice(path.iterdir(), _LOOKED_AT))
    if any(inner.name.endswith(".db3") for inner in within):
        return [path]
    return [inner for inner in within if inner.name.endswith(_TABLES)]
