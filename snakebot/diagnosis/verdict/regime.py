"""At which speeds, loads, reversals, times a gap is largest: for people, so that they know where to look."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.data import MIN_SAMPLES, Data
from snakebot.diagnosis.evidence.gap import GAP_RATIO
from snakebot.diagnosis.result import Regime
from snakebot.diagnosis.sizes import LITTLE

LOAD_AXES = ("load", "angle")  # said beside another axis, the first that is clear
REVERSAL = LITTLE  # share of a joint's fastest motion, below which it is turning round
MOST_ROWS = 12  # of a table: explanations, or gaits of other frequencies, that are told apart; chosen


@dataclass(frozen=True, eq=False)
class _Axis:
    name: str
    values: Floats
    edges: Floats
    labels: tuple[str, ...]


def regimes(
    data: Data,
    joints: Sequence[int],
    nominal_rad: Sequence[Floats],
    before: Sequence[Floats],
    after: Sequence[Floats],
    load_nm: Sequence[Floats] | None,
) -> tuple[Regime, ...]:
    """Rms of the gap before and after, binned along each axis, over the given joints (0-based)."""
    columns: dict[str, list[Floats]] = {
        name: [] for name in ("rate", "angle", "time", "load", "omega", "turning")
    }
    gap, rest = [], []
    for index, run in enumerate(data.runs):
        for joint in joints:
            use = run.use[:, joint]
            if use.sum() < MIN_SAMPLES:
                continue
            q = nominal_rad[index][:, joint]
            rate = np.abs(np.gradient(q, run.t_s))
            columns["rate"].append(rate[use])
            columns["angle"].append(np.degrees(np.abs(q[use])))
            columns["time"].append(run.t_s[use])
            columns["turning"].append((rate < REVERSAL * max(float(rate.max()), 1e-9))[use].astype(float))
            columns["omega"].append(np.full(int(use.sum()), run.omega_rad_s or np.nan))
            if load_nm is not None:
                columns["load"].append(np.abs(load_nm[index][use, joint]))
            gap.append(np.square(before[index][use, joint]))
            rest.append(np.square(after[index][use, joint]))
    if not gap:
        return ()
    square, left = np.concatenate(gap), np.concatenate(rest)
    out: list[Regime] = []
    for axis in _axes({name: np.concatenate(parts) for name, parts in columns.items() if parts}):
        place = np.digitize(axis.values, axis.edges)
        for number, label in enumerate(axis.labels):
            rows = place == number
            if rows.sum() >= MIN_SAMPLES:
                out.append(
                    Regime(
                        axis=axis.name,
                        bin=label,
                        rms_before_rad=float(np.sqrt(square[rows].mean())),
                        rms_after_rad=float(np.sqrt(left[rows].mean())),
                        samples=int(rows.sum()),
                    )
                )
    return tuple(out)


def _axes(columns: dict[str, Floats]) -> list[_Axis]:
    axes = []
    for name, column, unit, precision in (
        ("speed of the joint", "rate", "rad/s", 2),
        ("angle", "angle", "deg", 0),
        ("time since start", "time", "s", 1),
        ("load", "load", "N m", 2),
    ):
        values = columns.get(column)
        if values is None or np.ptp(values) <= 0:
            continue
        edges = np.unique(np.round(np.quantile(values, [1 / 3, 2 / 3]), precision))
        if edges.size < 2:
            continue
        a, b = (f"{e:.{precision}f}" for e in edges)
        axes.append(
            _Axis(name, values, edges, (f"below {a} {unit}", f"{a} to {b} {unit}", f"above {b} {unit}"))
        )
    if "turning" in columns:
        axes.append(
            _Axis(
                "phase of the motion",
                columns["turning"],
                np.array([0.5]),
                ("while moving", "at rest or turning round"),
            )
        )
    omega = columns.get("omega")
    if omega is not None:
        known = np.unique(np.round(omega[np.isfinite(omega)], 2))
        if 2 <= known.size <= MOST_ROWS:
            edges = 0.5 * (known[1:] + known[:-1])
            values = np.where(np.isfinite(omega), omega, -1e9)
            axes.append(_Axis("gait frequency", values, edges, tuple(f"omega {w:g} rad/s" for w in known)))
    return axes


def sentence(found: Sequence[Regime], *, rest: bool = False) -> str:
    """One sentence on where the gap (or, with ``rest``, what is left of it) is largest."""

    def size(r: Regime) -> float:
        return r.rms_after_rad if rest else r.rms_before_rad

    apart: dict[str, tuple[float, Regime, Regime]] = {}
    for axis in dict.fromkeys(r.axis for r in found):
        bins = [r for r in found if r.axis == axis]
        if len(bins) < 2:
            continue
        high, low = max(bins, key=size), min(bins, key=size)
        apart[axis] = (size(high) / max(size(low), 1e-12), high, low)
    what = "the rest" if rest else "the gap"
    if not apart:
        return f"{what} was not resolved by regime: too few samples"

    def told(axis: str) -> str:
        _, high, low = apart[axis]
        return (
            f"by {axis}: {np.degrees(size(high)):.2g} deg rms {high.bin}, "
            f"{np.degrees(size(low)):.2g} deg rms {low.bin}"
        )

    first = max(apart, key=lambda axis: apart[axis][0])
    ratio, high, _ = apart[first]
    if ratio < GAP_RATIO:
        return (
            f"{what} is much the same at all speeds, angles and times ({np.degrees(size(high)):.2g} deg rms)"
        )
    # where the load is not known, the angle replaces it: gravity pulls at an arm
    others = [axis for axis in LOAD_AXES if axis in apart and axis != first and apart[axis][0] >= GAP_RATIO]
    second = f"; {told(others[0])}" if others and first not in LOAD_AXES else ""
    return f"{what} is largest {told(first)}{second}"
