"""Whether a choice pays on the robot: the gait chosen with the calibration and the one chosen without it, by turns.

Nothing here moves a robot: whoever calls ``prove`` says how a gait is run, and may ask a person first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from snakebot.optimise.goal import Goal
from snakebot.optimise.promise import OptimiseOptions, Promise, promises

if TYPE_CHECKING:
    from snakebot.gait import Gait
    from snakebot.robot import Robot

REPEATS = 3  # runs of each of the two gaits; chosen
# Neighbours of a gait that it is compared with: factor on alpha, rad added to beta, factor on omega; chosen.
STEPS = ((0.85, 0.0, 1.0), (1.15, 0.0, 1.0), (1.0, -0.2, 1.0), (1.0, 0.2, 1.0), (1.0, 0.0, 0.85))
SAME = 0.02  # two choices that differ by less in alpha, beta (rad) and omega are one; chosen


@dataclass(frozen=True)
class Measured:
    """A gait that was run: what was promised of it, and what came out, a value a run."""

    promise: Promise
    speed_m_s: tuple[float, ...]
    power_w: tuple[float, ...]

    def interval(self, name: str) -> tuple[float, float] | None:
        """95 % of the mean of ``speed_m_s`` or ``power_w``, by Student's t; None for fewer than two runs."""
        values = np.array(getattr(self, name))
        if len(values) < 2:
            return None
        half = _t(len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values))
        return float(values.mean() - half), float(values.mean() + half)


@dataclass(frozen=True)
class Proof:
    """What came of it.

    Attributes:
        gain: of the calibrated choice over the nominal one as a share, the more the better; None where one was not run
            or both are one gait.
        gain_ci95: by Welch's t; None for fewer than two runs of either.
        held: of the gaits run with an interval promised, how many kept it, and how many there were.
    """

    nominal: Measured | None
    calibrated: Measured | None
    neighbours: tuple[Measured, ...]
    gain: float | None
    gain_ci95: tuple[float, float] | None
    held: tuple[int, int]

    @property
    def verdict(self) -> str:
        """``paid``, ``did not pay``, ``cannot be told`` or ``same choice``."""
        if self.gain is None:
            return "same choice" if self.calibrated is not None and self.nominal is None else "cannot be told"
        if self.gain_ci95 is None or self.gain_ci95[0] <= 0 <= self.gain_ci95[1]:
            return "cannot be told"
        return "paid" if self.gain > 0 else "did not pay"

    def summary(self) -> dict[str, Any]:
        """Plain values for ``--json``."""
        return {"verdict": self.verdict, **asdict(self)}


def prove(
    goal: Goal,
    nominal: Promise,
    calibrated: Promise,
    around: Sequence[Promise],
    run: Callable[[Gait, str], tuple[float, float] | None],
    repeats: int = REPEATS,
) -> Proof:
    """Run both choices by turns, so that what drifts meets both; then each neighbour once.

    Args:
        run: runs a gait; its speed in m/s and power in W, or None where it is not wanted, which ends it.
    """
    same = _same(nominal, calibrated)
    turns = [calibrated] * repeats if same else [nominal, calibrated] * repeats
    made: dict[int, list[tuple[float, float]]] = {}
    for number, promise in enumerate([*turns, *around], 1):
        found = run(promise.gait, f"{promise.what}, run {number} of {len(turns) + len(around)}")
        if found is None:
            break
        made.setdefault(id(promise), []).append(found)

    def measured(promise: Promise) -> Measured | None:
        rows = made.get(id(promise))
        return None if rows is None else Measured(promise, *(tuple(row) for row in zip(*rows, strict=True)))

    first, second = None if same else measured(nominal), measured(calibrated)
    others = tuple(m for m in map(measured, around) if m is not None)
    gain, span = _gain(goal, first, second)
    promised = [m for m in (first, second, *others) if m is not None and m.promise.speed_ci95 is not None]
    held = sum(_held(m) for m in promised)
    return Proof(first, second, others, gain, span, (held, len(promised)))


def neighbours(robot: Robot, found: Promise, options: OptimiseOptions) -> list[Promise]:
    """Gaits a little off the choice, with what is promised of them."""
    space = options.space(robot)
    centre = found.row
    off = np.array([[centre[0] * a, centre[1] + b, centre[2] * w, *centre[3:]] for a, b, w in STEPS])
    kept = np.unique(space.nearest(off).round(6), axis=0)
    kept = kept[np.abs(kept - centre).max(axis=1) > SAME]
    return promises(robot, [(f"neighbour {n}", gait) for n, gait in enumerate(kept, 1)], options)


def _same(a: Promise, b: Promise) -> bool:
    one, other = a.gait, b.gait
    return (
        abs(one.alpha_rad / other.alpha_rad - 1) < SAME
        and abs(one.beta_rad - other.beta_rad) < SAME
        and abs(one.omega_rad_s / other.omega_rad_s - 1) < SAME
        and _same_shares(one.shares, other.shares)
    )


def _same_shares(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    joints = max(len(one), len(other))
    pairs = zip(one or (1.0,) * joints, other or (1.0,) * joints, strict=True)
    return all(abs(a - b) < SAME for a, b in pairs)


def _held(measured: Measured) -> bool:
    ends = measured.promise.speed_ci95
    assert ends is not None
    return ends[0] <= float(np.mean(measured.speed_m_s)) <= ends[1]


def _gain(
    goal: Goal, nominal: Measured | None, calibrated: Measured | None
) -> tuple[float | None, tuple[float, float] | None]:
    """Share by which the calibrated choice is better: in speed, or else in power, or in power over speed."""
    if nominal is None or calibrated is None:
        return None, None
    a, b = (_values(goal, m) for m in (nominal, calibrated))
    scale = float(np.mean(a))
    sign = 1.0 if goal.aim == "speed" else -1.0
    gain = sign * (float(np.mean(b)) - scale) / scale
    if min(len(a), len(b)) < 2:
        return gain, None
    errors = np.array([v.var(ddof=1) / len(v) for v in (a, b)])
    if errors.sum() == 0:
        return gain, (gain, gain)
    freedom = errors.sum() ** 2 / (errors**2 / np.array([len(a) - 1, len(b) - 1])).sum()
    half = _t(freedom) * math.sqrt(errors.sum()) / scale
    return gain, (gain - half, gain + half)


def _values(goal: Goal, measured: Measured) -> np.ndarray[Any, np.dtype[np.float64]]:
    speed, power = np.array(measured.speed_m_s), np.array(measured.power_w)
    if goal.aim == "speed":
        return speed
    return power if goal.aim == "power-at-speed" else power / speed


def _t(freedom: float) -> float:
    from scipy.stats import t

    return float(t.ppf(0.975, freedom))
