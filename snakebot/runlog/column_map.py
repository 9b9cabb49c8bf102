"""Maps the columns of anybody's table to ours: ``cmd_*_rad=goal*:deg``, ``t_s=Time:ms``, ``enc_1_rad=-pos:counts``."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.robot import Robot
from snakebot.runlog.session import is_known_column

_UNITS = {
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "rad": {"rad": 1.0, "deg": math.pi / 180, "rev": 2 * math.pi, "mrad": 1e-3},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "a": {"A": 1.0, "mA": 1e-3},
    "v": {"V": 1.0, "mV": 1e-3},
    "c": {"C": 1.0},
}
_GRAMMAR = "NAME=[-]COLUMN[:UNIT]"


@dataclass(frozen=True)
class Source:
    """Where one of our columns comes from: ``factor`` times what a column of the table is above ``zero``."""

    column: str
    factor: float
    zero: float = 0.0  # in the table's unit


def parse_map(entries: Iterable[str], robot: Robot) -> dict[str, Source]:
    """Read ``NAME=[-]COLUMN[:UNIT]``, NAME being a column of the session form.

    ``*`` in both stands for the joint's number from 1, ``#`` in COLUMN for its number from 0. Without a unit the
    numbers are taken as SI; ``counts`` are the robot's encoder counts.

    Raises:
        BadInputError: an entry that does not fit the grammar, an unknown name or unit, a name mapped twice.
    """
    mapping: dict[str, Source] = {}
    for entry in entries:
        name, equals, column = (part.strip() for part in entry.partition("="))
        if not equals or not name or not column:
            raise BadInputError(f"column map {entry!r}: write {_GRAMMAR}")
        joints = range(1, robot.joints + 1) if "*" in name else [None]
        for joint in joints:
            ours, theirs = name, column
            if joint is not None:
                ours = name.replace("*", str(joint))
                theirs = column.replace("*", str(joint)).replace("#", str(joint - 1))
            if not is_known_column(ours):
                raise BadInputError(f"column map {entry!r}: {ours} is no column of a session")
            if ours in mapping:
                raise BadInputError(f"column map {entry!r}: {ours} is mapped twice")
            mapping[ours] = _source(entry, ours, theirs, robot)
    return mapping


def _source(entry: str, ours: str, theirs: str, robot: Robot) -> Source:
    sign = 1.0
    if theirs.startswith("-"):
        sign, theirs = -1.0, theirs[1:].strip()
    column, colon, unit = theirs.rpartition(":")
    units = _units(ours, robot.rad_per_count)
    known_units = {name for table in _UNITS.values() for name in table} | {"counts"}
    if not colon or (unit not in units and unit not in known_units):
        return Source(theirs, sign)  # no unit; the colon belongs to the column's name
    if unit not in units:
        raise BadInputError(
            f"column map {entry!r}: {ours} cannot be in {unit}; known: {', '.join(sorted(units))}"
        )
    return Source(column, sign * units[unit])


def _units(ours: str, rad_per_count: float) -> dict[str, float]:
    """What one of each unit that a column of ours may be given in is worth in its own."""
    dimension = re.sub(r".*_", "", ours) if "_" in ours else ""
    counts = {"counts": rad_per_count} if dimension == "rad" else {}
    return _UNITS.get(dimension, {}) | counts


def apply_map(columns: Mapping[str, Floats], mapping: Mapping[str, Source], where: str) -> dict[str, Floats]:
    """Our columns from theirs.

    Raises:
        BadInputError: a column that the map names is not there; the line lists those that are.
    """
    mapped = {}
    for ours, source in mapping.items():
        if source.column not in columns:
            there = ", ".join(list(columns)[:20])
            column, colon, unit = source.column.rpartition(":")
            known = ", ".join(sorted(_units(ours, math.nan)))
            no_unit = f"; {unit} is no unit of it, these are: {known}" if colon and column in columns else ""
            raise BadInputError(
                f"{where}: row 1: column {source.column} is missing (for {ours}){no_unit}; found {there}"
            )
        values = columns[source.column]
        mapped[ours] = (values - source.zero if source.zero else values) * source.factor
    return mapped
