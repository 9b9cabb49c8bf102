"""The Pareto front of serpentine gaits: as fast as can be for the power, over a grid of alpha, beta and omega.

Sections V, VI and VIII of the paper; Figs. 5-7 (distributed contact), 8-10 (wheels), 15-17 (measured friction) and
18-20 (the same without its Coulomb part).
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Floats, Ints
from snakebot.errors import BadInputError
from snakebot.robot import Robot
from snakebot.studies import sweep as sweeps
from snakebot.studies.sweep import POWER, SPEED, Conditions, SweepCallback

# The paper's grid (Section V): 9000 gaits.
ALPHA_DEG = np.arange(3.0, 90.1, 3.0)
BETA_DEG = np.arange(6.0, 180.1, 6.0)
OMEGA_RAD_S = np.arange(0.5, 5.01, 0.5)


def paper_grid() -> Floats:
    """All gaits of the paper's grid, shape (9000, 3): alpha and beta in rad, omega in rad/s."""
    alpha, beta, omega = np.meshgrid(np.radians(ALPHA_DEG), np.radians(BETA_DEG), OMEGA_RAD_S, indexing="ij")
    return np.column_stack([alpha.ravel(), beta.ravel(), omega.ravel()])


def front_of(speed: npt.ArrayLike, power: npt.ArrayLike) -> Ints:
    """Indices of the gaits that no other one beats in both speed and power, from slow to fast.

    Gaits that do not move forward, or whose figures are not numbers, are on no front.
    """
    v, p = np.asarray(speed, dtype=float), np.asarray(power, dtype=float)
    usable = np.flatnonzero(np.isfinite(v) & np.isfinite(p) & (v > 0))
    order = usable[np.lexsort((p[usable], -v[usable]))]  # fastest first, cheapest first among equals
    cheapest = np.minimum.accumulate(np.concatenate([[np.inf], p[order][:-1]]))
    return order[p[order] < cheapest][::-1]


@dataclass(frozen=True, eq=False)
class Pareto:
    """Result of a sweep: rows of ``COLUMNS``, and the indices of those on the front."""

    robot: Robot
    rows: Floats
    front: Ints

    def optimum(self, omega_rad_s: float) -> dict[str, float] | None:
        """The front's fastest gait at one frequency; None where the front has no gait of that frequency."""
        at = self.front[np.isclose(self.rows[self.front, 2], omega_rad_s)]
        if not at.size:
            return None
        return _named(self.rows[at[np.argmax(self.rows[at, SPEED])]])

    @property
    def optima(self) -> list[dict[str, float]]:
        """The optimum at each frequency that the front reaches."""
        omegas = np.unique(self.rows[self.front, 2])
        return [found for omega in omegas if (found := self.optimum(float(omega))) is not None]

    def omega_over_speed(self) -> tuple[float, float]:
        """Least-squares line omega = slope v + intercept through the optima (Figs. 7, 10, 17, 20): rad/m, rad/s."""
        optima = self.optima
        if len(optima) < 2:
            return float("nan"), float("nan")
        slope, intercept = np.polyfit(
            [row["speed_m_s"] for row in optima], [row["omega_rad_s"] for row in optima], 1
        )
        return float(slope), float(intercept)

    def summary(self) -> dict[str, Any]:
        """Plain values for ``--json``."""
        slope, intercept = self.omega_over_speed()
        return {
            "robot": self.robot.name,
            "gaits": len(self.rows),
            "front": len(self.front),
            "top_speed_m_s": float(self.rows[self.front, SPEED].max()) if self.front.size else None,
            "power_at_top_speed_w": float(self.rows[self.front[-1], POWER]) if self.front.size else None,
            "omega_over_speed": {"slope_rad_m": slope, "intercept_rad_s": intercept},
            "optima": self.optima,
        }


def _named(row: Floats) -> dict[str, float]:
    return {
        "alpha_deg": float(np.degrees(row[0])),
        "beta_deg": float(np.degrees(row[1])),
        "omega_rad_s": float(row[2]),
        "speed_m_s": float(row[SPEED]),
        "power_in_w": float(row[POWER]),
    }


def pareto(
    robot: Robot,
    folder: str | os.PathLike[str] | None = None,
    *,
    gaits: npt.ArrayLike | None = None,
    refinements: int = 0,
    progress: SweepCallback | None = None,
    dask: str | None = None,
) -> Pareto:
    """Sweep the grid (the paper's without ``gaits``) and find its front.

    Args:
        folder: results and chunks are kept here; an interrupted sweep goes on where it was.
        refinements: rounds of adding gaits halfway between each gait of the front and its neighbours.

    Raises:
        BadInputError: the robot has no body, or the folder holds another sweep.
    """
    if robot.body is None:
        raise BadInputError(f"robot {robot.name!r} has no body: a bench of servos does not move over ground")
    conditions = Conditions.of(robot)
    table = np.asarray(paper_grid() if gaits is None else gaits, dtype=float)[:, :3]
    base = Path(folder) if folder is not None else None
    rows = sweeps.sweep(conditions, table, base, progress=progress, dask=dask)
    spacing = np.array([_spacing(table[:, axis]) for axis in range(3)])
    for level in range(1, refinements + 1):
        spacing = spacing / 2
        added = _neighbours(rows, front_of(rows[:, SPEED], rows[:, POWER]), spacing)
        if not len(added):
            break
        where = base / f"refined_{level}" if base is not None else None
        rows = np.concatenate([rows, sweeps.sweep(conditions, added, where, progress=progress, dask=dask)])
    result = Pareto(robot, rows, front_of(rows[:, SPEED], rows[:, POWER]))
    if base is not None:
        on_front = np.zeros(len(rows), dtype=bool)
        on_front[result.front] = True
        sweeps.write_parquet(base / "pareto.parquet", sweeps.to_table(rows, on_front=on_front.tolist()))
    return result


def _spacing(values: Floats) -> float:
    distinct = np.unique(np.round(values, 12))
    return float(np.diff(distinct).min()) if len(distinct) > 1 else 0.0


def _neighbours(rows: Floats, front: Ints, spacing: Floats) -> Floats:
    """Gaits one spacing away from the front's in alpha, beta or both, that have not been computed."""
    steps = np.array([(a, b, 0) for a in (-1, 0, 1) for b in (-1, 0, 1) if a or b], dtype=float)
    candidates = (rows[front, None, :3] + steps * spacing).reshape(-1, 3)
    inside = (candidates[:, 0] > 0) & (candidates[:, 0] <= np.pi / 2) & (candidates[:, 1] > 0)
    known = {tuple(row) for row in np.round(rows[:, :3], 9)}
    fresh = {row for row in map(tuple, np.round(candidates[inside], 9)) if row not in known}
    return np.array(sorted(fresh)).reshape(-1, 3)
