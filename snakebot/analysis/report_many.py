"""The part of a report that compares several runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from snakebot.analysis.conditions import CONDITIONS, Setup, condition, robot_text
from snakebot.analysis.run_analysis import RunAnalysis
from snakebot.analysis.tables import FaultTable, NeighbourTable, PaperTables, SpeedRow
from snakebot.in_words import shortened
from snakebot.report import Axis, Column, Curve, Line, LineChart, Page, Section, Table, XYChart
from snakebot.report.blocks import NOT_KNOWN, significant

TE_HELP = "tracking error: rms of measured less commanded angle, over the gait's amplitude"
ERROR_HELP = "measured less predicted, over predicted"
SET_POINT_RUNS = 12  # runs whose set-points are drawn over each other; chosen, more cannot be told apart


def add_overview(page: Page, runs: Sequence[RunAnalysis], tables: PaperTables) -> None:
    section = page.section("All runs")
    section.add(runs_table(runs))
    runs = [run for run in runs if not run.run.aborted]  # listed, not averaged
    if tables.speeds:
        _speeds(page.section("Speed of gaits"), tables, runs)
    for near in tables.neighbours:
        page.section(f"Gaits near an optimum, ω = {near.omega_rad_s:g} rad/s").add(neighbour_table(near))
    for faults in tables.faults:
        page.section("Joints that are free or rigid").add(fault_table(faults))
    _set_points(page, runs)


def runs_table(runs: Sequence[RunAnalysis]) -> Table:
    columns = [
        Column("run"),
        Column("α", "deg", 4, decimals=1),
        Column("β", "deg", 4, decimals=1),
        Column("ω", "rad/s", 4, decimals=2),
        *(Column(name) for name in CONDITIONS if any(condition(run, name) for run in runs)),
        Column("steady cycles"),
        Column("TE", "", 3, TE_HELP, decimals=4),
        Column("worst RMS error", "deg", 3, decimals=2),
        Column("worst lag", "ms", 3, decimals=2),
        Column("worst harmonics", "%", 3, decimals=2),
        Column("speed", "m/s", 3),
        Column("predicted", "m/s", 3, "nominal model, ideal tracking"),
        Column("error", "%", 3, ERROR_HELP, decimals=1),
        Column("lost", "%", 3, decimals=2),
        Column("late ticks"),
    ]
    if len({robot_text(run) for run in runs}) > 1:
        columns.append(Column("robot"))
    if all(run.robot.body is None for run in runs):
        columns = [c for c in columns if c.name not in ("speed", "predicted", "error")]
    rows: list[list[object]] = []
    for run in runs:
        gait = run.gait
        row: dict[str, object] = {
            "run": run.name,
            "α": math.degrees(gait.alpha_rad) if gait else None,
            "β": math.degrees(gait.beta_rad) if gait else None,
            "ω": run.omega_rad_s,
            "steady cycles": run.steady.cycles if run.steady.settled else None,
            "TE": run.te,
            "worst RMS error": math.degrees(_worst([j.tracking.rms_rad for j in run.joints])),
            "worst lag": 1e3 * _worst([j.lag_s for j in run.joints]),
            "worst harmonics": 100 * _worst([j.thd for j in run.joints]),
            "speed": run.speed_m_s,
            "predicted": run.predictions.ideal.speed_m_s if run.predictions.ideal else None,
            "error": run.speed_error_percent,
            "lost": 100 * run.link.lost,
            "late ticks": run.link.late_ticks,
            **{name: shortened(condition(run, name)) for name in CONDITIONS},
            "robot": shortened(robot_text(run)),
        }
        rows.append([row[column.name] for column in columns])
    return Table(columns, rows)


def speed_table(rows: Sequence[SpeedRow]) -> Table:
    """Speed and tracking error of each gait, and the sine replay beside it."""
    columns = [
        Column("ω", "rad/s", 4, decimals=2),
        Column("α", "deg", 4, decimals=1),
        Column("β", "deg", 4, decimals=1),
        Column("predicted speed", "m/s", 3, "nominal model, ideal tracking"),
        Column("measured speed", "m/s", 3),
        Column("error", "%", 3, ERROR_HELP, decimals=1),
        Column("TE", "", 3, TE_HELP, decimals=4),
        Column(
            "predicted from measured sines", "m/s", 3, "least-squares sines of the measured angles, replayed"
        ),
        Column("runs"),
    ]
    apart = _told_apart(rows)
    columns += [Column(name) for name in apart]
    cells: list[list[object]] = [
        [
            r.omega_rad_s,
            r.alpha_deg,
            r.beta_deg,
            r.predicted_m_s,
            r.measured_m_s,
            r.error_percent,
            r.te,
            r.sine_replay_m_s,
            r.runs,
            *(told(r.setup) for told in apart.values()),
        ]
        for r in rows
    ]
    return Table(columns, cells, "Speed of gaits", keys=3)


def _told_apart(rows: Sequence[SpeedRow]) -> dict[str, Callable[[Setup], object]]:
    """A column each for what the rows' runs do not have in common, or had beside their gait."""
    told: dict[str, Callable[[Setup], object]] = {}
    if any(r.setup.offset_deg for r in rows):
        told["offset deg"] = lambda setup: setup.offset_deg
    if any(r.setup.effects for r in rows):
        told["effect"] = lambda setup: shortened(setup.effects)
    if len({r.setup.robot for r in rows}) > 1:
        told["robot"] = lambda setup: shortened(setup.robot)
    return told


def neighbour_table(table: NeighbourTable) -> Table:
    """Predicted speed, measured speed and their difference in every cell."""

    def cell(row: SpeedRow | None) -> str:
        if row is None:
            return NOT_KNOWN
        parts = [
            significant(v, 3) if math.isfinite(v) else NOT_KNOWN
            for v in (row.predicted_m_s, row.measured_m_s)
        ]
        error = f"{significant(row.error_percent, 3, 1)} %" if math.isfinite(row.error_percent) else NOT_KNOWN
        return f"{parts[0]} / {parts[1]} m/s, {error}"

    columns = [Column("α \\ β", "deg", 4, decimals=1), *(Column(f"{beta:g}°") for beta in table.betas_deg)]
    rows: list[list[object]] = [
        [alpha, *(cell(entry) for entry in line)]
        for alpha, line in zip(table.alphas_deg, table.cells, strict=True)
    ]
    caption = (
        f"Speed predicted / measured, and error, at ω = {table.omega_rad_s:g} rad/s; {table.setup.text()}"
    )
    return Table(columns, rows, caption)


def fault_table(table: FaultTable) -> Table:
    """Speed with failed joints, the healthy robot first. The power is the simulation's."""
    columns = [
        Column("failure"),
        Column("joint"),
        Column("predicted speed", "m/s", 3),
        Column("measured speed", "m/s", 3),
        Column("error", "%", 3, ERROR_HELP, decimals=1),
        Column("power in (simulation)", "W", 3),
        Column("runs"),
    ]
    rows = [
        [r.fault, r.joints, r.predicted_m_s, r.measured_m_s, r.error_percent, r.predicted_power_w, r.runs]
        for r in table.rows
    ]
    gait = f"α = {table.alpha_deg:g}°, β = {table.beta_deg:g}°, ω = {table.omega_rad_s:g} rad/s"
    return Table(columns, rows, f"Speed with joints that failed, {gait}; {table.setup.text()}", keys=2)


def _speeds(section: Section, tables: PaperTables, runs: Sequence[RunAnalysis]) -> None:
    section.add(speed_table(tables.speeds))
    ideal, replayed, harmonic = [], [], []
    for run in runs:
        p, name = (
            run.predictions,
            f"{run.name}, ω {run.omega_rad_s:.3g} rad/s" if run.omega_rad_s else run.name,
        )
        if math.isfinite(run.speed_m_s):
            if p.ideal:
                ideal.append((p.ideal.speed_m_s, run.speed_m_s, name))
            if p.sine_replay:
                replayed.append((p.sine_replay.speed_m_s, run.speed_m_s, name))
            if p.angle_replay:
                harmonic.append((p.angle_replay.speed_m_s, run.speed_m_s, name))
    curves = [
        _cloud(name, points, color)
        for name, points, color in (
            ("ideal tracking", ideal, "predicted"),
            ("measured sines replayed", replayed, "measured"),
            ("measured angles with harmonics replayed", harmonic, "applied"),
        )
        if points
    ]
    blocks: list[XYChart] = []
    if curves:
        blocks.append(
            XYChart(
                "Measured against predicted speed",
                curves,
                Axis("predicted speed", "m/s", 4),
                Axis("measured speed", "m/s", 4),
                diagonal=True,
                height=320,
            )
        )
    healthy = [run for run in runs if run.omega_rad_s and not run.faults and not run.faults.changed]
    with_te = [(run.omega_rad_s or 0.0, run.te, run.name) for run in healthy if math.isfinite(run.te)]
    if len(with_te) > 1:
        blocks.append(
            XYChart(
                "Tracking error TE (rms error over amplitude) against frequency",
                [_cloud("", with_te, "error")],
                Axis("ω", "rad/s", 3),
                Axis("tracking error TE", "", 4),
                height=320,
            )
        )
    section.add_grid(*blocks)


def _cloud(name: str, points: Sequence[tuple[float, float, str]], color: str) -> Curve:
    x, y, labels = zip(*points, strict=True)
    return Curve(name, np.array(x), np.array(y), color, mode="points", labels=labels)


def _set_points(page: Page, runs: Sequence[RunAnalysis]) -> None:
    """Two cycles of set-point and measured angle of one joint, one run a frequency, from slow to fast."""
    worst: dict[float, RunAnalysis] = {}
    for run in runs:
        if run.omega_rad_s and not run.faults and not run.faults.changed and math.isfinite(run.te):
            omega = round(run.omega_rad_s, 3)
            worst[omega] = max(worst.get(omega, run), run, key=lambda r: r.te)
    periodic = [worst[omega] for omega in sorted(worst)]
    if len(periodic) < 2:
        return
    if len(periodic) > SET_POINT_RUNS:
        periodic = [
            periodic[i] for i in np.unique(np.linspace(0, len(periodic) - 1, SET_POINT_RUNS).astype(int))
        ]
    joint = _worst_joint(periodic)
    charts = []
    for run in periodic:
        if run.run.joints < joint:
            continue
        omega = run.omega_rad_s or 1.0
        t = run.run.t_s
        end = t[np.flatnonzero(run.steady.mask(t))[-1]]
        part = (t >= end - 4 * math.pi / omega) & (t <= end)
        lines = [
            Line("set-point", np.degrees(run.run.command_rad[part, joint - 1]), "command", dash=True),
            Line("measured", np.degrees(run.run.measured_rad[part, joint - 1]), "measured"),
        ]
        charts.append(
            LineChart(
                f"{run.name}: ω = {omega:.3g} rad/s",
                t[part] - t[part][0],
                lines,
                Axis("time", "s", 3),
                Axis("angle", "deg", 2),
                height=200,
                points=400,
            )
        )
    section = page.section(
        f"Set-point and measured angle of joint {joint}",
        "The last two steady cycles, from slow to fast; of each frequency the sound run that tracks worst.",
    )
    section.add_grid(*charts)


def _worst_joint(runs: Sequence[RunAnalysis]) -> int:
    joints = max(run.run.joints for run in runs)
    errors = np.zeros(joints)
    for run in runs:
        for entry in run.joints:
            if math.isfinite(entry.tracking.te):
                errors[entry.joint - 1] += entry.tracking.te**2
    return int(np.argmax(errors)) + 1


def _worst(values: Sequence[float]) -> float:
    """The value with the largest magnitude."""
    known = [value for value in values if math.isfinite(value)]
    return max(known, key=abs) if known else math.nan
