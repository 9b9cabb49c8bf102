"""What ``snakebot session import`` asks on a terminal: it shows how a table begins, and asks what nothing says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from snakebot.errors import BadInputError
from snakebot.in_words import plain
from snakebot.runlog.foreign.column_names import find_columns
from snakebot.runlog.foreign.source import SourceOptions, kind_of
from snakebot.runlog.foreign.tables import TableOptions, header_of

_SHOWN = 8  # columns of a preview


def ask(sources: Sequence[Path], said: SourceOptions) -> SourceOptions:
    """What was said, and what was answered: about columns and units that nothing says."""
    kinds = [kind_of(path) for path in sources]
    table, angles = said.table, said.table.angles
    first = next((path for path, kind in zip(sources, kinds, strict=True) if kind == "table"), None)
    if first is not None:
        table = _about_columns(first, table)
    unsaid = "lerobot" in kinds or (first is not None and not _units_said(first, table))
    if angles.unit is None and unsaid:
        unit = click.prompt("Unit of the angles", type=click.Choice(["rad", "deg", "counts", "percent"]))
        angles = replace(angles, unit=unit)
    if angles.unit == "counts" and angles.counts_per_rev is None:
        counts = click.prompt("Encoder counts of a turn", type=click.IntRange(16, 1 << 20))
        angles = replace(angles, counts_per_rev=counts)
    if angles.unit == "counts" and not angles.centre:
        centre = click.prompt(
            "Counts where a joint is straight", type=float, default=(angles.counts_per_rev or 0) / 2
        )
        angles = replace(angles, centre=(centre,))
    if angles.unit == "percent" and not angles.range_deg:
        low = click.prompt("Angle at -100 percent, degrees", type=float)
        high = click.prompt("Angle at 100 percent, degrees", type=float)
        if not low < high:
            raise BadInputError("the angle at 100 percent is not above the one at -100")
        angles = replace(angles, range_deg=((low, high),))
    return replace(said, table=replace(table, angles=angles))


def _about_columns(path: Path, table: TableOptions) -> TableOptions:
    """Show how the table begins; ask which columns are commands and measurements where their names do not say."""
    names, found = header_of(path, table)
    if found is not None:
        click.echo(f"{path}: {found}")
        for row in (names, *found.rows[:3]):
            more = " ..." if len(row) > _SHOWN else ""
            click.echo("  " + "".join(f"{plain(cell)[:13]:<14}" for cell in row[:_SHOWN]) + more)
    if any(entry.strip().startswith(("cmd_", "enc_")) for entry in table.entries):
        return table
    try:
        find_columns(names, str(path))
        return table
    except BadInputError:
        click.echo("Names do not say which columns are commands and which measurements.")
    unit = click.prompt("Unit of the angles", type=click.Choice(["rad", "deg"]))
    entries = list(table.entries)
    for ours, what in (("cmd", "Commands"), ("enc", "Measured angles")):
        theirs = click.prompt(f"{what}: the column, * for the joint's number from 1, # from 0")
        joints = "*" if "*" in theirs or "#" in theirs else "1"
        entries.append(f"{ours}_{joints}_rad={theirs}:{unit}")
    if not any(entry.strip().startswith("t_s") for entry in entries) and table.rate_hz is None:
        entries.append(f"t_s={click.prompt('Time: the column, with its unit', default=names[0] + ':s')}")
    return replace(table, entries=tuple(entries))


def _units_said(path: Path, table: TableOptions) -> bool:
    if any(entry.strip().startswith(("cmd_", "enc_")) for entry in table.entries):
        return True
    names, _ = header_of(path, table)
    columns = find_columns(names, str(path))
    return all(name in columns.units for name in (*columns.command, *columns.measured))
