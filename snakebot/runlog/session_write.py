"""Writes session folders."""

from __future__ import annotations

import contextlib
import csv
import gzip
import io
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from snakebot.arrays import AnyArray
from snakebot.errors import BadInputError, cannot_write
from snakebot.robot import Robot
from snakebot.runlog.log import gait_to_mapping
from snakebot.runlog.number_table import TABLE_SUFFIXES
from snakebot.runlog.run import Run
from snakebot.runlog.session import RUN_KEYS, SESSION_FILE
from snakebot.safe_yaml import dump_yaml
from snakebot.whole_files import creating

TableFormat = Literal["csv", "csv.gz", "parquet"]


def write_session(
    path: str | os.PathLike[str], robot: Robot, runs: Iterable[Run], table_format: TableFormat = "csv"
) -> Path:
    """Write runs as a session folder; ``session.yaml`` comes last, so a folder that has one is whole.

    What else a run's metadata holds (as far as it is plain data) goes under the run's key ``metadata``.

    Raises:
        BadInputError: the folder holds something already, a run has other joints than the robot, or two runs
            have one name.
    """
    folder = Path(path)
    runs = tuple(runs)
    if not runs:
        raise BadInputError(f"{folder}: a session needs at least one run")
    files: dict[str, str] = {}
    taken: set[str] = set()
    for run in runs:
        if run.name in files:
            raise BadInputError(f"{folder}: two runs have the name {run.name}")
        stem, marks = _stem(run.name), ("", *(f"-{number}" for number in range(2, len(runs) + 1)))
        files[run.name] = next(
            name for mark in marks if (name := f"{stem}{mark}.{table_format}") not in taken
        )
        taken.add(files[run.name])
    for run in runs:
        if run.joints != robot.joints:
            raise BadInputError(f"{folder}: run {run.name} has {run.joints} joints, the robot {robot.joints}")
    new, ours = not folder.exists(), False
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise BadInputError(f"{folder}: is not empty; a session is never written over another")
        ours = True
        for run in runs:
            write_table(folder / files[run.name], run_columns(run))
        text = dump_yaml({"robot": robot.to_mapping(), "runs": [_entry(run, files) for run in runs]})
        with creating(folder / SESSION_FILE) as whole:
            whole.write_text(text, encoding="utf-8")
    except OSError as error:
        if ours:
            _take_away(folder, files.values(), new)
        raise cannot_write(f"{folder}: cannot write the session", error) from None
    return folder


def _take_away(folder: Path, names: Iterable[str], whole: bool) -> None:
    """What there is of a session that could not be written."""
    with contextlib.suppress(OSError):
        for name in names:
            (folder / name).unlink(missing_ok=True)
        if whole:
            folder.rmdir()


def run_columns(run: Run) -> dict[str, AnyArray]:
    """The columns of a run as the form of a session names them."""
    columns: dict[str, AnyArray] = {"t_s": run.t_s}
    for kind, array in (("cmd", run.command_rad), ("enc", run.measured_rad), ("applied", run.applied_rad)):
        if array is not None:
            columns.update({f"{kind}_{joint + 1}_rad": array[:, joint] for joint in range(run.joints)})
    if run.pose is not None:
        columns.update({name: run.pose[:, i] for i, name in enumerate(("x_m", "y_m", "heading_rad"))})
    return {**columns, **run.extra}


def write_table(path: Path, columns: Mapping[str, AnyArray]) -> None:
    """Write columns as CSV, CSV.gz or Parquet, by the file's name; nan becomes an empty cell in a CSV.

    Numbers keep all their digits: what is read back is equal to the last bit.

    Raises:
        BadInputError: the name says no known form.
        OSError: it exists already, were it only a link, or cannot be written.
    """
    if not path.name.endswith(TABLE_SUFFIXES):
        raise BadInputError(f"{path}: not a table that is written here ({', '.join(TABLE_SUFFIXES)})")
    with creating(path) as whole:
        if path.name.endswith(".parquet"):
            import pyarrow as pa
            import pyarrow.parquet as pq

            pq.write_table(pa.table({name: np.asarray(values) for name, values in columns.items()}), whole)
        elif path.name.endswith(".csv.gz"):
            with (
                whole.open("wb") as raw,
                gzip.GzipFile(fileobj=raw, mode="wb", filename="", mtime=0) as packed,
            ):
                packed.write(_csv(columns))
        else:
            whole.write_bytes(_csv(columns))


def _csv(columns: Mapping[str, AnyArray]) -> bytes:
    texts = []
    for values in columns.values():
        if values.dtype.kind == "f":
            texts.append(["" if value != value else repr(value) for value in values.tolist()])
        elif values.dtype.kind == "b":
            texts.append([str(int(value)) for value in values.tolist()])
        else:
            texts.append([str(value) for value in values.tolist()])
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(columns)  # a log may name a reading as it likes
    out.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))
    return out.getvalue().encode()


def _stem(name: str) -> str:
    for suffix in TABLE_SUFFIXES:
        name = name.removesuffix(suffix)
    return re.sub(r"[^A-Za-z0-9_.+-]+", "_", name).strip(".") or "run"


def _entry(run: Run, files: Mapping[str, str]) -> dict[str, Any]:
    entry: dict[str, Any] = {"file": files[run.name]}
    if run.gait is not None:
        entry["gait"] = gait_to_mapping(run.gait)
    if run.forward_speed_m_s is not None:
        entry["forward_speed_m_s"] = float(run.forward_speed_m_s)
    if run.repeat_of is not None:
        entry["repeat_of"] = files.get(run.repeat_of, run.repeat_of)
    if run.hold_out:
        entry["hold_out"] = True
    rest = {str(k): v for k, v in run.metadata.items() if k not in RUN_KEYS and _is_plain(v)}
    return {**entry, "metadata": rest} if rest else entry


def _is_plain(value: object) -> bool:
    if isinstance(value, (list, tuple)):
        return all(_is_plain(item) for item in value)
    if isinstance(value, Mapping):
        return all(isinstance(key, str) and _is_plain(item) for key, item in value.items())
    return value is None or isinstance(value, (bool, int, float, str))
