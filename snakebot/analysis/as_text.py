"""Results for a terminal: the report's own tables, set in columns."""

from __future__ import annotations

import math
from collections.abc import Sequence

from snakebot.analysis.comparison import Comparison
from snakebot.analysis.report import gait_text, joint_table, link_table, prediction_table, steady_text
from snakebot.analysis.report_compare import alignment_text
from snakebot.analysis.report_compare import joint_table as comparison_table
from snakebot.analysis.report_many import fault_table, neighbour_table, runs_table, speed_table
from snakebot.analysis.run_analysis import RunAnalysis
from snakebot.analysis.tables import PaperTables
from snakebot.report import Table
from snakebot.report.blocks import significant

DETAILED = 3  # more runs than this are shown as tables only


def analysis_text(runs: Sequence[RunAnalysis], tables: PaperTables) -> str:
    parts: list[str] = []
    if len(runs) <= DETAILED:
        parts += [_run(run) for run in runs]
    if len(runs) > 1:
        parts.append(table_text(runs_table(runs)))
        parts += [table_text(t) for t in ([speed_table(tables.speeds)] if tables.speeds else [])]
        parts += [table_text(neighbour_table(t)) for t in tables.neighbours]
        parts += [table_text(fault_table(t)) for t in tables.faults]
        if len(runs) > DETAILED:
            parts += [f"warning: {run.name}: {warning}" for run in runs for warning in run.warnings]
    return "\n\n".join(parts)


def comparison_text(found: Comparison) -> str:
    parts = [
        f"{found.real.name} against {found.sim_source}",
        alignment_text(found),
        steady_text(found.real),
        table_text(comparison_table(found)),
        f"RMS difference of all joints: {significant(math.degrees(found.rms_rad), 3)} deg",
    ]
    if math.isfinite(found.speed_error_percent):
        parts.append(
            f"speed: robot {found.real.speed_m_s:.4g} m/s, simulation {found.sim.speed_m_s:.4g} m/s, "
            f"error {found.speed_error_percent:.3g} % (36)"
        )
    return "\n".join([*parts, *(f"warning: {w}" for w in (*found.warnings, *found.real.warnings))])


def table_text(table: Table) -> str:
    """A table in columns, numbers flush right, units under the names."""
    rows = [
        [column.name for column in table.columns],
        [column.unit for column in table.columns],
        *table.texts(),
    ]
    if not any(rows[1]):
        del rows[1]
    numeric = table.numeric()
    widths = [max(len(row[i]) for row in rows) for i in range(len(table.columns))]
    lines = [
        "  ".join(
            c.rjust(w) if n else c.ljust(w) for c, w, n in zip(row, widths, numeric, strict=True)
        ).rstrip()
        for row in rows
    ]
    return "\n".join([table.caption, *lines] if table.caption else lines)


def _run(run: RunAnalysis) -> str:
    parts = [
        f"{run.name}: {run.robot.name}, {gait_text(run)}",
        steady_text(run),
        table_text(joint_table(run)),
    ]
    if (predictions := prediction_table(run)) is not None:
        parts.append(table_text(predictions))
    elif math.isfinite(run.speed_m_s):
        parts.append(f"forward speed {run.speed_m_s:.4g} m/s ({run.speed_source})")
    parts.append(table_text(link_table(run)))
    return "\n".join([*parts, *(f"warning: {warning}" for warning in run.warnings)])
