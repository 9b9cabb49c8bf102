"""A table of another program as a run: its form, columns and units found out, or as somebody says."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.robot import Robot
from snakebot.runlog.column_map import Source, apply_map, parse_map
from snakebot.runlog.foreign.angles import AngleForm
from snakebot.runlog.foreign.column_names import Columns, find_columns, find_pose
from snakebot.runlog.foreign.csv_form import FoundForm, find_form
from snakebot.runlog.merging import EPOCH_S
from snakebot.runlog.number_table import NumberTable, read_table
from snakebot.runlog.run import Run
from snakebot.runlog.session import is_known_column, run_from_table

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
# A unit of time is taken from the usual step: no robot is recorded slower than at 2 Hz or faster than at 2 kHz.
_STEP_UNITS = ((0.5, "s"), (500.0, "ms"), (5e5, "us"), (np.inf, "ns"))


@dataclass(frozen=True)
class TableOptions:
    """What is said of a table; what is None is found out."""

    entries: Sequence[str] = ()  # of the column map
    delimiter: str | None = None
    decimal: str | None = None
    skip_rows: int | None = None
    time_unit: str | None = None
    rate_hz: float | None = None  # where there is no column of time
    angles: AngleForm = field(default_factory=AngleForm)


@dataclass(frozen=True)
class TableRun:
    """A run, and how the table was understood, in one line."""

    run: Run
    told: str


def joints_of(path: Path, options: TableOptions) -> int:
    """Number of joints that a table has, by the map or by the names of its columns.

    Raises:
        BadInputError: the names do not say.
    """
    names, _ = header_of(path, options)
    if not _maps_angles(options.entries):
        return len(find_columns(names, f"{path}: row 1").joints)
    count = 0
    for entry in options.entries:
        ours, _, theirs = (part.strip() for part in entry.partition("="))
        numbered = re.fullmatch(r"(?:cmd|enc)_(\*|[1-9]\d{0,2})_rad", ours)
        if numbered and numbered[1] != "*":
            count = max(count, int(numbered[1]))
        elif numbered:
            count = max(count, _starred(theirs, names))
    if not count:
        raise BadInputError(
            f"{path}: row 1: the map names no column that is there; found {', '.join(names[:20])}"
        )
    return count


def header_of(path: Path, options: TableOptions) -> tuple[tuple[str, ...], FoundForm | None]:
    """Names of the columns, and the form of a CSV."""
    if path.name.endswith(".parquet"):
        return tuple(read_table(path, frozenset()).columns), None
    found = find_form(path, options.delimiter, options.decimal, options.skip_rows)
    return found.header, found


def read_table_run(path: Path, robot: Robot, options: TableOptions) -> TableRun:
    """The run in a table.

    Raises:
        BadInputError: one line with file, row and column, or the option that is wanted.
    """
    names, found = header_of(path, options)
    mapping = dict(parse_map(options.entries, robot))
    given = _maps_angles(options.entries)
    where = f"{path}: row 1"
    columns = None if given else find_columns(names, where)
    told = [] if found is None else [str(found)]
    if columns is None:
        stated = any(entry.rstrip().endswith(":rad") for entry in options.entries)
        _place(mapping, robot, replace(options.angles, unit=None) if stated else options.angles)
    else:
        mapping |= _angles(columns, options.angles, robot, where)
        told.append(f"commands {_list(columns.command)}; measured {_list(columns.measured)}")
    if "t_s" not in mapping and options.rate_hz is None:
        time = columns.time if columns is not None else _time_column(names)
        if time is None:
            raise BadInputError(
                f"{where}: no column of time; name it with --map t_s=COLUMN:UNIT, or say --rate HZ; "
                f"found {', '.join(names[:20])}"
            )
        unit = options.time_unit or (columns.units.get(time) if columns is not None else None)
        mapping["t_s"] = Source(time, TIME_UNITS[unit] if unit else np.nan)
    for name in names:
        if is_known_column(name) and name not in mapping and not re.match("t_s|cmd_|enc_|applied_", name):
            mapping[name] = Source(name, 1.0)
    told += _pose(mapping, names)
    wanted = frozenset(source.column for source in mapping.values())
    table = read_table(path, wanted, found.form if found is not None else None)
    mapping, time_told = _time_unit(mapping, table)
    told += time_told
    ours = apply_map(table.columns, mapping, str(path))
    if options.rate_hz is not None and "t_s" not in ours:
        rows = len(next(iter(ours.values())))
        ours = {"t_s": np.arange(rows) / options.rate_hz, **ours}
        told.append(f"time from the row's number, {options.rate_hz:g} Hz")
    about: dict[str, object] = {"imported_from": path.name}
    t_s = ours["t_s"]
    if t_s.size and t_s[0] > EPOCH_S:
        about["started_unix_s"] = float(t_s[0])
        ours["t_s"] = t_s - t_s[0]
    run = run_from_table(
        path, NumberTable(ours, (), table.first_row), robot.joints, set(), name=_stem(path), metadata=about
    )
    return TableRun(run, "; ".join(told))


def _angles(columns: Columns, form: AngleForm, robot: Robot, where: str) -> dict[str, Source]:
    """Our columns of angles from those that were found by name."""
    if len(columns.joints) != robot.joints:
        raise BadInputError(
            f"{where}: the names tell of {len(columns.joints)} joints, the robot has {robot.joints}; say which "
            "columns they are with --map"
        )
    found = {}
    for kind, names in (("cmd", columns.command), ("enc", columns.measured)):
        for joint, name in enumerate(names):
            unit = form.unit or columns.units.get(name)
            if unit is None:
                raise BadInputError(
                    f"{where}: column {name}: its name does not say the unit of its angles; give --units rad, deg, "
                    "counts or percent"
                )
            factor, zero = form.line(robot.joints, unit)
            found[f"{kind}_{joint + 1}_rad"] = Source(name, float(factor[joint]), float(zero[joint]))
    return found


def _pose(mapping: dict[str, Source], names: Sequence[str]) -> list[str]:
    """Puts a pose that the names tell of into the map; what is told of it."""
    if any(ours in mapping for ours in ("x_m", "y_m", "heading_rad")):
        return []
    found, unclear = find_pose(names)
    for ours, (name, factor) in found.items():
        mapping[ours] = Source(name, factor)
    told = [f"pose {', '.join(name for name, _ in found.values())}"] if found else []
    if unclear:
        guess = {"x": "x_m=%s:m", "y": "y_m=%s:m"}
        maps = [guess.get(name.strip().lower(), "heading_rad=%s:deg") % name.strip() for name in unclear]
        told.append(
            f"{', '.join(unclear)} not used, their unit is not said: for a pose add "
            + " ".join(f"--map {entry}" for entry in maps)
        )
    return told


def _place(mapping: dict[str, Source], robot: Robot, form: AngleForm) -> None:
    """Centre and direction of the joints that a map names; its unit stands there, or is that of --units."""
    for ours, source in mapping.items():
        joint = re.fullmatch(r"(?:cmd|enc|applied)_(\d+)_rad", ours)
        if joint is None or int(joint[1]) > robot.joints:
            continue
        at = int(joint[1]) - 1
        stated = abs(source.factor) != 1.0 or form.unit is None
        factor, zero = replace(form, unit="rad" if stated else form.unit).line(robot.joints)
        mapping[ours] = replace(source, factor=source.factor * float(factor[at]), zero=float(zero[at]))


def _maps_angles(entries: Sequence[str]) -> bool:
    return any(re.match(r"\s*(cmd|enc)_", entry) for entry in entries)


def _starred(theirs: str, names: Sequence[str]) -> int:
    """How many joints from 1 (``*``), or from 0 (``#``), have a column of this form."""
    pattern = theirs.removeprefix("-").strip()
    for form in (pattern, pattern.rpartition(":")[0]):
        count = 0
        if not form or not ("*" in form or "#" in form):
            continue
        while form.replace("*", str(count + 1)).replace("#", str(count)) in names:
            count += 1
        if count:
            return count
    return 0


def _time_column(names: Sequence[str]) -> str | None:
    plain = ("t_s", "t", "time", "time_s", "timestamp", "zeit")
    return next((name for name in names if name.lower() in plain), None)


def _time_unit(mapping: Mapping[str, Source], table: NumberTable) -> tuple[dict[str, Source], list[str]]:
    """The map with a unit of time where none was said: by the usual step between two rows."""
    source = mapping.get("t_s")
    if source is None or np.isfinite(source.factor) or source.column not in table.columns:
        told = [] if source is None else [f"time {source.column}"]
        return dict(mapping), told
    steps = _rising(np.diff(table.columns[source.column]))
    step = float(np.median(steps)) if steps.size else 0.0
    unit = next(unit for below, unit in _STEP_UNITS if step < below)
    made = {**mapping, "t_s": Source(source.column, TIME_UNITS[unit])}
    return made, [f"time {source.column}, taken as {unit} for its steps of {step:g}"]


def _rising(steps: Floats) -> Floats:
    return np.asarray(steps[steps > 0])


def _list(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) < 4 else f"{names[0]}, {names[1]}, ... {names[-1]}"


def _stem(path: Path) -> str:
    return re.sub(r"\.(csv|csv\.gz|parquet|txt|tsv|dat)$", "", path.name)
