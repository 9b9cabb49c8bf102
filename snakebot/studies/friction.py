"""Friction coefficients from the tilted treadmill (Section VII).

The robot stands still on a moving belt that is tilted by gamma: friction holds it against gravity. With straight joints
every link rolls along itself; with the links turned alternately by +-lambda each slips sideways too. Along the belt

    F_t cos(lambda) + F_n sin(lambda) = m g sin(gamma)                                                          (32)
    F_t = ct v cos(lambda) + ct0,   F_n = cn v sin(lambda) + cn0                                          (31), (34)

so that one linear least-squares fit over all rows gives all four coefficients of a link. The paper goes in two steps
and solves (32) for F_n in (33), where it prints gamma and lambda exchanged; the right form is
F_n = (m g sin(gamma) - F_t cos(lambda)) / sin(lambda).
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from snakebot.errors import BadInputError
from snakebot.physics.model import STANDARD_GRAVITY_M_S2

COLUMNS = ("incline_deg", "belt_speed_m_s", "link_angle_deg")
NAMES = ("ct", "ct0", "cn", "cn0")
UNITS = {"ct": "N s/m", "ct0": "N", "cn": "N s/m", "cn0": "N"}
_MAX_ROWS = 100_000  # chosen: a table made by hand has less than a hundred
_WORST_CONDITION = 1e8  # of the design matrix; chosen: beyond it half of the digits are lost


@dataclass(frozen=True)
class Measurement:
    """One equilibrium: tilt of the belt, its speed, and by how much the links are turned (0: straight)."""

    incline_rad: float
    belt_speed_m_s: float
    link_angle_rad: float


@dataclass(frozen=True)
class FrictionFit:
    """Coefficients of one link with their 95 % confidence intervals. NaN: the table does not say (no turned links)."""

    link_mass_kg: float
    estimate: dict[str, float]
    ci95: dict[str, tuple[float, float]]
    residual_rms_n: float
    rows: int

    def summary(self) -> dict[str, Any]:
        """Plain values for ``--json``; what is not known is None."""

        def plain(value: float) -> float | None:
            return None if math.isnan(value) else value

        return {
            "link_mass_kg": self.link_mass_kg,
            "rows": self.rows,
            "residual_rms_n": self.residual_rms_n,
            "coefficients": {
                name: {
                    "estimate": plain(self.estimate[name]),
                    "ci95": [plain(bound) for bound in self.ci95[name]],
                    "unit": UNITS[name],
                }
                for name in NAMES
            },
        }


def read_table(path: Path) -> list[Measurement]:
    """A CSV with the columns incline_deg, belt_speed_m_s and link_angle_deg (0 for straight joints).

    Raises:
        BadInputError: the file cannot be read, or a value is missing, no number or impossible (row and column named).
    """
    try:
        rows: list[Measurement] = []
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            missing = [name for name in COLUMNS if name not in (reader.fieldnames or [])]
            if missing:
                raise BadInputError(f"{path}: column {missing[0]} is missing; it needs {', '.join(COLUMNS)}")
            for row in reader:
                if len(rows) >= _MAX_ROWS:
                    raise BadInputError(f"{path}: more than {_MAX_ROWS} rows")
                rows.append(_measurement(path, reader.line_num, row))
    except OSError as error:
        raise BadInputError(f"{path}: cannot read the table: {error.strerror or error}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise BadInputError(f"{path}: cannot read the table: {error}") from None
    return rows


def _measurement(path: Path, line: int, row: dict[str, str | None]) -> Measurement:
    values = []
    for name in COLUMNS:
        try:
            value = float(row[name] or "")
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise BadInputError(f"{path}: row {line}, {name}: {row[name]!r} is no number")
        values.append(value)
    incline, speed, angle = values
    if not 0 < incline < 90:
        raise BadInputError(f"{path}: row {line}, incline_deg: {incline:g}; it lies between 0 and 90")
    if not abs(angle) < 90:
        raise BadInputError(f"{path}: row {line}, link_angle_deg: {angle:g}; it lies between -90 and 90")
    if speed < 0:
        raise BadInputError(f"{path}: row {line}, belt_speed_m_s: {speed:g}; it is zero or more")
    return Measurement(math.radians(incline), speed, abs(math.radians(angle)))


def fit_friction(table: Sequence[Measurement], link_mass_kg: float) -> FrictionFit:
    """Least squares over all rows. Without rows of turned links only ct and ct0 are found.

    Raises:
        BadInputError: too few rows, or rows too much alike to tell the coefficients apart.
    """
    if not (math.isfinite(link_mass_kg) and link_mass_kg > 0):
        raise BadInputError(f"mass of a link {link_mass_kg}: must be a positive number of kg")
    speed = np.array([row.belt_speed_m_s for row in table])
    angle = np.array([row.link_angle_rad for row in table])
    pull = link_mass_kg * STANDARD_GRAVITY_M_S2 * np.sin([row.incline_rad for row in table])
    cos, sin = np.cos(angle), np.sin(angle)
    turned = bool((angle > 0).any())
    design = np.column_stack([speed * cos**2, cos, speed * sin**2, sin][: 4 if turned else 2])
    unknowns = design.shape[1]
    if len(table) <= unknowns:
        raise BadInputError(
            f"{len(table)} rows cannot give {unknowns} coefficients and their uncertainty: measure more inclines"
        )
    scale = np.linalg.norm(design, axis=0)
    if not (scale > 0).all() or np.linalg.cond(design / scale) > _WORST_CONDITION:
        raise BadInputError("the rows are too much alike: vary the belt's speed, at more than one link angle")
    solution, *_ = np.linalg.lstsq(design, pull, rcond=None)
    residual = pull - design @ solution
    freedom = len(table) - unknowns
    covariance = np.linalg.inv(design.T @ design) * (residual @ residual) / freedom
    from scipy.stats import t as student

    reach = student.ppf(0.975, freedom) * np.sqrt(np.diag(covariance))
    estimate = dict.fromkeys(NAMES, math.nan)
    ci95 = dict.fromkeys(NAMES, (math.nan, math.nan))
    for index, name in enumerate(NAMES[:unknowns]):
        estimate[name] = float(solution[index])
        ci95[name] = (float(solution[index] - reach[index]), float(solution[index] + reach[index]))
    rms = float(np.sqrt(np.mean(residual**2)))
    return FrictionFit(link_mass_kg, estimate, ci95, rms, len(table))


def forces(
    table: Sequence[Measurement], fit: FrictionFit
) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """(v_t, F_t) of the straight rows and (v_n, F_n) of the turned ones: the points of Figs. 12 and 14."""
    tangential, normal = [], []
    for row in table:
        pull = fit.link_mass_kg * STANDARD_GRAVITY_M_S2 * math.sin(row.incline_rad)
        cos, sin = math.cos(row.link_angle_rad), math.sin(row.link_angle_rad)
        v_t = row.belt_speed_m_s * cos
        if row.link_angle_rad == 0:
            tangential.append((v_t, pull))
        else:
            f_t = fit.estimate["ct"] * v_t + fit.estimate["ct0"]
            normal.append((row.belt_speed_m_s * sin, (pull - f_t * cos) / sin))  # (33), corrected
    return tangential, normal
