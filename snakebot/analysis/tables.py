"""Several runs compared, in the layout of the paper's Tables II, III and IV.

Only the layout is the paper's: every cell is measured or simulated here, and one that is neither stays empty.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.analysis.conditions import USUAL, Setup, setup_of
from snakebot.analysis.run_analysis import RunAnalysis
from snakebot.analysis.speed import speed_error_percent


@dataclass(frozen=True)
class SpeedRow:
    """A row of Table II: one gait. Repeats of a gait are averaged, ``runs`` of them."""

    alpha_deg: float
    beta_deg: float
    omega_rad_s: float
    predicted_m_s: float
    measured_m_s: float
    error_percent: float  # (36)
    te: float  # (37)
    sine_replay_m_s: float
    runs: int
    setup: Setup = USUAL


@dataclass(frozen=True)
class NeighbourTable:
    """Table III: gaits around an optimum at one ``omega_rad_s``; ``cells[i][j]`` is at ``alphas_deg[i]``,
    ``betas_deg[j]``, and ``None`` where nothing was run."""

    omega_rad_s: float
    alphas_deg: tuple[float, ...]
    betas_deg: tuple[float, ...]
    cells: tuple[tuple[SpeedRow | None, ...], ...]
    setup: Setup = USUAL


@dataclass(frozen=True)
class FaultRow:
    """A row of Table IV: one kind of failure. The power is the simulation's, as in the paper."""

    fault: str
    joints: str
    predicted_m_s: float
    measured_m_s: float
    error_percent: float
    predicted_power_w: float
    runs: int


@dataclass(frozen=True)
class FaultTable:
    """Table IV: failures at one gait, the healthy robot first."""

    alpha_deg: float
    beta_deg: float
    omega_rad_s: float
    rows: tuple[FaultRow, ...]
    setup: Setup = USUAL


@dataclass(frozen=True)
class PaperTables:
    speeds: tuple[SpeedRow, ...]
    neighbours: tuple[NeighbourTable, ...]
    faults: tuple[FaultTable, ...]


def paper_tables(runs: Sequence[RunAnalysis]) -> PaperTables:
    """Sort the runs that have a gait into the three tables. Runs without one, with faults that came or went in
    mid-run, or that did not finish, are in none. Robots, effects and bends stand apart: nothing is averaged over them.
    """
    apart: dict[Setup, list[RunAnalysis]] = defaultdict(list)
    for run in runs:
        if not (run.gait is None or run.robot.body is None or run.faults.changed or run.run.aborted):
            apart[setup_of(run)].append(run)
    found = [_tables(setup, apart[setup]) for setup in sorted(apart)]
    speeds = [row for tables in found for row in tables.speeds]
    return PaperTables(
        speeds=tuple(sorted(speeds, key=lambda r: (r.omega_rad_s, r.alpha_deg, r.beta_deg, r.setup))),
        neighbours=tuple(table for tables in found for table in tables.neighbours),
        faults=tuple(table for tables in found for table in tables.faults),
    )


def _tables(setup: Setup, runs: Sequence[RunAnalysis]) -> PaperTables:
    healthy: dict[tuple[float, float, float], list[RunAnalysis]] = defaultdict(list)
    broken: dict[tuple[float, float, float], dict[tuple[str, str], list[RunAnalysis]]] = defaultdict(dict)
    for run in runs:
        key = _gait_key(run)
        if run.faults:
            broken[key].setdefault((run.faults.kind, run.faults.described), []).append(run)
        else:
            healthy[key].append(run)
    speeds = {key: _speed_row(key, group, setup) for key, group in healthy.items()}
    return PaperTables(
        speeds=tuple(speeds.values()),
        neighbours=tuple(_neighbours(speeds, setup)),
        faults=tuple(_faults(key, broken[key], healthy.get(key, []), setup) for key in sorted(broken)),
    )


def _gait_key(run: RunAnalysis) -> tuple[float, float, float]:
    gait = run.gait
    assert gait is not None
    alpha, beta = (round(math.degrees(angle), 3) for angle in (gait.alpha_rad, gait.beta_rad))
    return alpha, beta, round(gait.omega_rad_s, 4)


def _mean(values: Sequence[float]) -> float:
    known = [value for value in values if math.isfinite(value)]
    return float(np.mean(known)) if known else math.nan


def _speeds(group: Sequence[RunAnalysis]) -> tuple[float, float]:
    predicted = _mean([r.predictions.ideal.speed_m_s for r in group if r.predictions.ideal])
    return predicted, _mean([r.speed_m_s for r in group])


def _speed_row(key: tuple[float, float, float], group: Sequence[RunAnalysis], setup: Setup) -> SpeedRow:
    predicted, measured = _speeds(group)
    return SpeedRow(
        *key,
        predicted_m_s=predicted,
        measured_m_s=measured,
        error_percent=speed_error_percent(measured, predicted),
        te=_mean([r.te for r in group]),
        sine_replay_m_s=_mean(
            [r.predictions.sine_replay.speed_m_s for r in group if r.predictions.sine_replay]
        ),
        runs=len(group),
        setup=setup,
    )


def _neighbours(speeds: dict[tuple[float, float, float], SpeedRow], setup: Setup) -> list[NeighbourTable]:
    """One table for each omega at which both alpha and beta were varied."""
    tables = []
    for omega in sorted({key[2] for key in speeds}):
        here = {key: row for key, row in speeds.items() if key[2] == omega}
        alphas = tuple(sorted({key[0] for key in here}))
        betas = tuple(sorted({key[1] for key in here}))
        if len(alphas) > 1 and len(betas) > 1:
            cells = tuple(tuple(here.get((a, b, omega)) for b in betas) for a in alphas)
            tables.append(NeighbourTable(omega, alphas, betas, cells, setup))
    return tables


def _faults(
    key: tuple[float, float, float],
    groups: dict[tuple[str, str], list[RunAnalysis]],
    healthy: list[RunAnalysis],
    setup: Setup,
) -> FaultTable:
    rows = []
    if healthy:
        rows.append(_fault_row("none", "", healthy))
    rows += [
        _fault_row(kind, joints, groups[kind, joints]) for kind, joints in sorted(groups, key=_fault_order)
    ]
    return FaultTable(*key, rows=tuple(rows), setup=setup)


def _fault_order(name: tuple[str, str]) -> tuple[str, int, str]:
    kind, joints = name
    return kind, joints.count("+"), joints


def _fault_row(kind: str, joints: str, group: list[RunAnalysis]) -> FaultRow:
    predicted, measured = _speeds(group)
    return FaultRow(
        fault=kind,
        joints=joints,
        predicted_m_s=predicted,
        measured_m_s=measured,
        error_percent=speed_error_percent(measured, predicted),
        predicted_power_w=_mean([r.predictions.ideal.power_in_w for r in group if r.predictions.ideal]),
        runs=len(group),
    )
