"""Session folders: one ``session.yaml`` and one table a run; how runs of any robot reach the diagnosis."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.nearest import misspelt, nearest, not_known
from snakebot.robot import Robot, robot_from_mapping
from snakebot.runlog.import_hint import import_hint
from snakebot.runlog.log import STEERING_COLUMNS, gait_from_mapping
from snakebot.runlog.number_table import TABLE_SUFFIXES, NumberTable, read_table
from snakebot.runlog.plausible import plausible
from snakebot.runlog.reader import LogWarning
from snakebot.runlog.run import Run, Session
from snakebot.safe_yaml import Lines, load_yaml

SESSION_FILE = "session.yaml"
MAX_RUNS = 10_000  # of one session; chosen: more is not a session but a mistake
MAX_SESSION_SAMPLES = 50_000_000  # rows times joints, over all runs

_PER_JOINT = re.compile(r"(cmd|enc|applied)_([1-9]\d{0,3})_rad|(current|temperature)_([1-9]\d{0,3})_(?:a|c)")
_POSE = ("x_m", "y_m", "heading_rad")
_SUPPLY = ("supply_v", "supply_a", "supply_temperature_c")
_SINGLE = frozenset(
    {"t_s", *_POSE, *_SUPPLY, *STEERING_COLUMNS, "sequence", "board_time_us", "latency_s", "late"}
)
RUN_KEYS = ("file", "gait", "forward_speed_m_s", "repeat_of", "hold_out", "metadata")
_TOP_KEYS = ("robot", "runs")


class _Noticed(NamedTuple):
    columns: set[str]
    keys: set[str]


def read_session(path: str | os.PathLike[str]) -> Session:
    """Read a session folder (or the ``session.yaml`` in it).

    What is unknown (columns, keys of a run) is kept, in ``Run.extra`` and ``Run.metadata``, and told by one
    ``LogWarning``.

    Raises:
        BadInputError: one line that names file, row and column (or key) and what is wrong.
    """
    folder = Path(path)
    if folder.name == SESSION_FILE:
        folder = folder.parent
    if not folder.is_dir():
        what = "not a session folder" if folder.exists() else "no such session folder"
        raise BadInputError(f"{folder}: {what}{import_hint(folder)}")
    where = folder / SESSION_FILE
    data, lines = _load(where)
    found = misspelt(data, _TOP_KEYS, [key for key in _TOP_KEYS if key not in data])
    if found is not None:
        raise BadInputError(f"{where}: {lines.of(found[0])}{not_known(found[0], _TOP_KEYS, 'a session')}")
    robot = robot_from_mapping(data.get("robot"), f"{where}: robot", lines.under("robot"))
    entries = data.get("runs")
    if not isinstance(entries, list) or not entries:
        raise BadInputError(f"{where}: runs: needs a list with at least one run")
    if len(entries) > MAX_RUNS:
        raise BadInputError(f"{where}: runs: {len(entries)} runs; at most {MAX_RUNS} are read")
    noticed = _Noticed(set(), set())
    runs: list[Run] = []
    samples = 0
    for index, entry in enumerate(entries):
        run = _read_run(
            folder, f"{where}: runs[{index + 1}]", entry, robot, noticed, lines.under("runs", index)
        )
        samples += run.command_rad.size
        if samples > MAX_SESSION_SAMPLES:
            raise BadInputError(f"{where}: more than {MAX_SESSION_SAMPLES} samples in all; not read")
        runs.append(run)
    _check_names(str(where), folder, runs)
    notes = _notes(where, noticed, data)
    for note in notes:
        warnings.warn(note, LogWarning, stacklevel=2)
    return Session(robot=robot, runs=tuple(runs), path=folder, warnings=tuple(notes))


def _load(where: Path) -> tuple[Mapping[str, Any], Lines]:
    try:
        if where.stat().st_size > 4 << 20:
            raise BadInputError(f"{where}: larger than 4 MiB; not read")
        text = where.read_bytes()
    except OSError as error:
        hint = import_hint(where.parent) if isinstance(error, FileNotFoundError) else ""
        raise BadInputError(f"{where}: cannot read the session: {error.strerror}{hint}") from None
    data = load_yaml(text, str(where))
    if not isinstance(data, Mapping):
        raise BadInputError(f"{where}: a session is a mapping with the keys robot and runs")
    return data, Lines(text)


def _read_run(folder: Path, where: str, entry: Any, robot: Robot, noticed: _Noticed, lines: Lines) -> Run:
    if not isinstance(entry, Mapping):
        raise BadInputError(f"{where}: a run is a mapping with the key file")
    found = misspelt(entry, RUN_KEYS, () if "file" in entry else ("file",))
    if found is not None:
        raise BadInputError(f"{where}: {lines.of(found[0])}{not_known(found[0], RUN_KEYS, 'a run')}")
    file = _inside(folder, where, entry.get("file"))
    speed = entry.get("forward_speed_m_s")
    if speed is not None and (
        isinstance(speed, bool) or not isinstance(speed, (int, float)) or not np.isfinite(speed)
    ):
        raise BadInputError(f"{where}: forward_speed_m_s: not a finite number (found {speed!r})")
    hold_out = entry.get("hold_out", False)
    if not isinstance(hold_out, bool):
        raise BadInputError(f"{where}: hold_out: neither true nor false (found {hold_out!r})")
    repeat_of = entry.get("repeat_of")
    if repeat_of is not None and not isinstance(repeat_of, str):
        raise BadInputError(f"{where}: repeat_of: not the file of a run (found {repeat_of!r})")
    metadata = entry.get("metadata", {})
    if not isinstance(metadata, Mapping):
        raise BadInputError(f"{where}: metadata: not a mapping of names to values")
    unknown = {str(key) for key in entry if key not in RUN_KEYS}
    noticed.keys.update(unknown)
    return run_from_table(
        file,
        read_table(file, KnownColumns()),
        robot.joints,
        noticed.columns,
        name=str(entry["file"]),
        gait=gait_from_mapping(entry.get("gait"), where, lines.under("gait")),
        forward_speed_m_s=None if speed is None else float(speed),
        repeat_of=repeat_of,
        hold_out=hold_out,
        metadata={**metadata, **{key: entry[key] for key in entry if str(key) in unknown}},
    )


class KnownColumns(frozenset[str]):
    """All columns that the form of a session knows: those must hold numbers."""

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and is_known_column(name)


def is_known_column(name: str) -> bool:
    """Whether the form of a session knows a column of this name."""
    return name in _SINGLE or _PER_JOINT.fullmatch(name) is not None


def _inside(folder: Path, where: str, name: Any) -> Path:
    """The run's file, which may not be outside the session's folder, not even through a link."""
    if not isinstance(name, str) or not name:
        raise BadInputError(f"{where}: file: needs the name of a table in this folder")
    if "\0" in name or not name.endswith(TABLE_SUFFIXES):
        raise BadInputError(f"{where}: file: {name!r}: not one of {', '.join(TABLE_SUFFIXES)}")
    path = folder / name
    if Path(name).is_absolute() or not path.resolve().is_relative_to(folder.resolve()):
        raise BadInputError(f"{where}: file: {name!r}: leaves the session's folder; not read")
    if not os.path.isfile(path):  # Path.is_file() raises for a name that no file can have
        raise BadInputError(f"{path}: no such file, but {where} names it")
    return path


def run_from_table(path: Path, table: NumberTable, joints: int, unknown: set[str], **about: Any) -> Run:
    """Make a run of a table's columns; names of unknown columns are added to ``unknown``.

    Raises:
        BadInputError: a required column is missing, the joint count differs, time does not rise, numbers that no
            robot reaches.
    """
    columns = table.columns
    for name in ("t_s", *(f"{kind}_{j}_rad" for kind in ("cmd", "enc") for j in range(1, joints + 1))):
        if name not in columns:
            raise BadInputError(f"{path}: row 1: column {name} is missing (the robot has {joints} joints)")
    for name in columns:
        match = _PER_JOINT.fullmatch(name)
        if match and int(match[2] or match[4]) > joints:
            raise BadInputError(f"{path}: row 1: column {name}: the robot has {joints} joints")
    t_s = columns["t_s"]
    check_time(path, table.first_row, t_s)

    def stack(kind: str) -> Floats:
        return np.stack([columns[f"{kind}_{j}_rad"] for j in range(1, joints + 1)], axis=1)

    applied = [name for name in columns if name.startswith("applied_") and is_known_column(name)]
    if applied and len(applied) != joints:
        raise BadInputError(
            f"{path}: row 1: {len(applied)} of {joints} columns applied_i_rad; give all or none"
        )
    pose = [name for name in _POSE if name in columns]
    if pose and pose[:2] != ["x_m", "y_m"]:
        raise BadInputError(f"{path}: row 1: a pose needs x_m and y_m; found only {', '.join(pose)}")
    unknown_heading = np.full(t_s.size, np.nan)  # x and y alone: path and speed count, heading does not
    used = {
        "t_s",
        *_POSE,
        *(f"{kind}_{j}_rad" for kind in ("cmd", "enc", "applied") for j in range(1, joints + 1)),
    }
    extra = {name: values for name, values in columns.items() if name not in used}
    unknown.update(name for name in (*extra, *table.texts) if not is_known_column(name))
    run = Run(
        t_s=t_s,
        command_rad=stack("cmd"),
        measured_rad=stack("enc"),
        applied_rad=stack("applied") if applied else None,
        pose=np.stack([columns.get(name, unknown_heading) for name in _POSE], axis=1) if pose else None,
        extra=extra,
        **about,
    )
    return plausible(run, str(path))


def check_time(path: Path, first_row: int, t_s: Floats) -> None:
    """Raise the BadInputError of a time that is empty or does not rise."""
    if not t_s.size:
        raise BadInputError(f"{path}: no samples under the header")
    empty = np.flatnonzero(np.isnan(t_s))
    if empty.size:
        raise BadInputError(f"{path}: row {first_row + empty[0]}, column t_s: empty")
    back = np.flatnonzero(np.diff(t_s) <= 0)
    if back.size:
        at = int(back[0])
        where = f"{path}: row {first_row + at + 1}, column t_s"
        raise BadInputError(f"{where}: time does not rise: {t_s[at + 1]:.9g} after {t_s[at]:.9g}")


def _check_names(where: str, folder: Path, runs: list[Run]) -> None:
    """A file that stands twice, by another name or through a link, would pass for a repeat without any noise."""
    files: dict[Path, str] = {}
    for run in runs:
        file = (folder / run.name).resolve()
        if file in files:
            first = files[file]
            twice = (
                f"{run.name} stands twice" if run.name == first else f"{first} and {run.name} are one file"
            )
            raise BadInputError(f"{where}: runs: {twice}")
        files[file] = run.name
    names = set(files.values())
    for run in runs:
        if run.repeat_of is not None and (run.repeat_of not in names or run.repeat_of == run.name):
            raise BadInputError(
                f"{where}: runs: {run.name}: repeat_of {run.repeat_of!r} is no other run here"
            )


def _notes(where: Path, noticed: _Noticed, data: Mapping[str, Any]) -> list[str]:
    notes = []
    if noticed.columns:
        notes.append(f"{where}: unknown columns kept, not used: {_list(dict.fromkeys(noticed.columns, ()))}")
    keys: dict[str, tuple[str, ...]] = dict.fromkeys(noticed.keys, RUN_KEYS)
    keys |= {str(key): _TOP_KEYS for key in data if key not in _TOP_KEYS}
    if keys:
        notes.append(f"{where}: unknown keys kept, not used: {_list(keys)}")
    return notes


def _list(names: Mapping[str, Iterable[str]]) -> str:
    """The first of some names, each with the one that is like it among those it could have been."""
    ordered = sorted(names)
    shown = []
    for name in ordered[:8]:
        near = nearest(name, names[name])
        shown.append(name if near is None else f"{name} (did you mean {near}?)")
    return ", ".join(shown) + (f" and {len(ordered) - 8} more" if len(ordered) > 8 else "")
