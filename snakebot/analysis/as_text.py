"""Results for a terminal: the report's own tables, set in columns."""

from __future__ import annotations

import math
from collections.abc import Sequence

from snakebot.analysis.comparison import Comparison
from snakebot.analysis.conditions import conditions_text, robot_text
from snakebot.analysis.report import gait_text, joint_table, link_table, prediction_table, steady_text
from snakebot.analysis.report_compare import alignment_text
from snakebot.analysis.report_compare import joint_table as comparison_table
from snakebot.analysis.report_many import fault_table, neighbour_table, runs_table, speed_table
from snakebot.analysis.run_analysis import RunAnalysis
from snakebot.analysis.tables import PaperTables
from snakebot.report import Table
from snakebot.report.blocks import significant
from snakebot.text_table import screen_columns, set_in_columns, shortened_apart

DETAILED = 3  # more runs than this are shown as tables only


def analysis_text(runs: Sequence[RunAnalysis], tables: PaperTables) -> str:
    parts: list[str] = []
    shown: list[Table] = []
    if len(runs) <= DETAILED:
        parts += [_run(run) for run in runs]
        shown += [joint_table(run) for run in runs]
    if len(runs) > 1:
        side_by_side = [runs_table(runs)]
        side_by_side += [speed_table(tables.speeds)] if tables.speeds else []
        side_by_side += map(neighbour_table, tables.neighbours)
        side_by_side += map(fault_table, tables.faults)
        parts += map(table_text, side_by_side)
        shown += side_by_side
        if len(runs) > DETAILED:
            parts += [f"warning: {run.name}: {warning}" for run in runs for warning in run.warnings]
    return "\n\n".join([*parts, legend(shown)])


def comparison_text(found: Comparison) -> str:
    told = conditions_text(found.real)
    parts = [
        f"{found.real.name}{f' ({told})' if told else ''} against {found.sim_source}",
        alignment_text(found),
        steady_text(found.real),
        table_text(comparison_table(found)),
        legend([comparison_table(found)]),
        f"RMS difference of all joints: {significant(math.degrees(found.rms_rad), 3)} deg",
    ]
    if math.isfinite(found.speed_error_percent):
        parts.append(
            f"speed: robot {found.real.speed_m_s:.4g} m/s, simulation {found.sim.speed_m_s:.4g} m/s, "
            f"error {found.speed_error_percent:.3g} %"
        )
    return "\n".join([*parts, *(f"warning: {w}" for w in (*found.warnings, *found.real.warnings))])


def table_text(table: Table) -> str:
    """A table in columns, numbers flush right, units under the names; in blocks where the terminal is narrow."""
    heads = [[column.name for column in table.columns]]
    if any(column.unit for column in table.columns):
        heads.append([column.unit for column in table.columns])
    body = [shortened_apart(cells) for cells in zip(*table.texts(), strict=True)]
    rows = [*heads, *map(list, zip(*body, strict=True))]
    lines = set_in_columns(rows, table.numeric(), len(heads), screen_columns(), table.keys)
    return "\n".join([table.caption, *lines] if table.caption else lines)


def legend(tables: Sequence[Table]) -> str:
    """What the columns' names stand for, each said once."""
    told = {column.name: column.help for table in tables for column in table.columns if column.help}
    return "\n".join(f"{name}: {text}" for name, text in told.items())


def _run(run: RunAnalysis) -> str:
    parts = [
        ", ".join(filter(None, (f"{run.name}: {robot_text(run)}", gait_text(run), conditions_text(run)))),
        steady_text(run),
        table_text(joint_table(run)),
    ]
    if (predictions := prediction_table(run)) is not None:
        parts.append(table_text(predictions))
    elif math.isfinite(run.speed_m_s):
        parts.append(f"forward speed {run.speed_m_s:.4g} m/s ({run.speed_source})")
    parts.append(table_text(link_table(run)))
    return "\n".join([*parts, *(f"warning: {warning}" for warning in run.warnings)])
