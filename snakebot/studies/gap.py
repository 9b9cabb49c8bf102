"""Which servo effects make the paper's robot fall short at omega = 4 and 5 (Section IX)?

What is published: up to omega = 3 the robot keeps to the simulation and its joints keep to the reference; at omega = 4
and 5 it moves at 0.24 and 0.18 m/s; the simulation fed with the sines of the measured angles gives 0.28 and 0.17 m/s.
Each effect alone, and pairs of them, are fitted to these numbers by least squares. So few numbers cannot prove a cause;
they can rule one out.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.robot import Robot
from snakebot.studies.speed import SimulatedSpeed, speed_study

# The paper's gaits: alpha falls from 70 to 40 deg as omega rises from 1 to 5, through (66, 80) at 2; beta is near 80.
ALPHA_OF_OMEGA_DEG = ((1.0, 70.0), (2.0, 66.0), (5.0, 40.0))
BETA_DEG = 80.0  # as above


@dataclass(frozen=True)
class Target:
    """One published number. ``speed_ratio`` is to ideal tracking, ``tracking_error_max`` an upper bound."""

    omega_rad_s: float
    quantity: str
    value: float
    sigma: float
    source: str


TARGETS = (
    Target(2.0, "speed_ratio", 1.0, 0.05, "Section IX: at lower speeds predictions are close"),
    Target(3.0, "speed_ratio", 1.0, 0.05, "Section IX: at lower speeds predictions are close"),
    Target(3.0, "tracking_error_max", 0.15, 0.05, "Fig. 22: at 3 rad/s the joint keeps quite well to its reference"),
    Target(4.0, "speed_m_s", 0.24, 0.02, "Section IX, measured"),
    Target(5.0, "speed_m_s", 0.18, 0.02, "Section IX, measured"),
    Target(4.0, "sine_replay_speed_m_s", 0.28, 0.02, "Section IX, sine of the measured angles"),
    Target(5.0, "sine_replay_speed_m_s", 0.17, 0.02, "Section IX, sine of the measured angles"),
)  # fmt: skip

# What is fitted, and where it is looked for; bounds are a factor of what such a servo could have.
RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "servo_lag": {"time_constant_s": (0.02, 1.0)},
    "rate_limit": {"limit_rad_s": (0.8, 4.0)},
    "torque_speed": {"no_load_rad_s": (2.0, 10.0), "stall_nm": (0.15, 5.0)},
    "torque_limit": {"limit_nm": (0.1, 1.5)},
    "deadband": {"width_deg": (1.0, 28.0)},
    "second_order": {"natural_freq_rad_s": (2.5, 30.0), "damping_ratio": (0.1, 2.0)},
}
# Where an effect does next to nothing: a pair also starts from the best of one with the other like this.
NEUTRAL: dict[str, tuple[float, ...]] = {
    "servo_lag": (0.03,),
    "rate_limit": (4.0,),
    "torque_speed": (10.0, 5.0),
    "torque_limit": (1.5,),
    "deadband": (1.0,),
    "second_order": (30.0, 0.8),
}
# Both are the servo's speed limit, or its linear response.
EXCLUSIVE = ({"rate_limit", "torque_speed"}, {"servo_lag", "second_order"})


def paper_gait(omega_rad_s: float) -> Gait:
    """The paper's optimal gait at a frequency, as far as its text gives it."""
    omega, alpha = zip(*ALPHA_OF_OMEGA_DEG, strict=True)
    return Gait(
        math.radians(float(np.interp(omega_rad_s, omega, alpha))), math.radians(BETA_DEG), omega_rad_s
    )


def candidates() -> list[tuple[str, ...]]:
    """Each effect alone, and each pair that makes sense."""
    pairs = [pair for pair in itertools.combinations(RANGES, 2) if set(pair) not in EXCLUSIVE]
    return [*((name,) for name in RANGES), *pairs]


@dataclass(frozen=True)
class GapFit:
    """The best that these effects can do. ``misfit``: sum of squared errors over sigma; about 1 a target is good."""

    effects: tuple[str, ...]  # as written after --effect
    misfit: float
    point: tuple[float, ...]  # the parameters, in the order of RANGES
    values: dict[str, float]  # what each target comes to

    @property
    def score(self) -> float:
        """Akaike's: the misfit, and 2 for each parameter that was free to lower it."""
        return self.misfit + 2 * len(self.point)

    @property
    def label(self) -> str:
        return " + ".join(text.partition(":")[0] for text in self.effects) or "nominal servo"


def measured(rows: Sequence[SimulatedSpeed], target: Target) -> float:
    """What a simulation makes of a target."""
    row = next(row for row in rows if math.isclose(row.omega_rad_s, target.omega_rad_s))
    if target.quantity == "speed_ratio":
        return row.speed_m_s / row.ideal_speed_m_s
    if target.quantity == "tracking_error_max":
        return max(row.tracking_error)
    return float(getattr(row, target.quantity))


def errors(rows: Sequence[SimulatedSpeed], targets: Sequence[Target] = TARGETS) -> Floats:
    """Deviation of each target over its sigma; an upper bound costs nothing below it."""
    found = []
    for target in targets:
        error = (measured(rows, target) - target.value) / target.sigma
        found.append(max(0.0, error) if target.quantity.endswith("_max") else error)
    return np.array(found)


def fit_effects(
    robot: Robot,
    names: Sequence[str],
    samples: int = 16,
    polish: int = 40,
    starts: Sequence[Sequence[float]] = (),
) -> GapFit:
    """Least squares over the logarithms of the parameters: spread samples, then a simplex from the best.

    Args:
        starts: further points for the first look.
        samples: of the first look, for each parameter.
        polish: steps of the simplex, for each parameter.
    """
    from scipy.optimize import minimize
    from scipy.stats import qmc

    gaits = [paper_gait(omega) for omega in sorted({target.omega_rad_s for target in TARGETS})]
    slots = [(name, key, *bounds) for name in names for key, bounds in RANGES[name].items()]
    low, high = (np.log([slot[side] for slot in slots]) for side in (2, 3))

    def texts(point: Floats) -> tuple[str, ...]:
        value = dict(zip([slot[:2] for slot in slots], np.exp(np.clip(point, low, high)), strict=True))
        return tuple(
            f"{name}:" + ",".join(f"{key}={float(value[name, key]):.4g}" for key in RANGES[name])
            for name in names
        )

    def misfit(point: Floats) -> float:
        outside = float(np.sum(np.maximum(0.0, np.abs(point - np.clip(point, low, high)))))
        found = float(np.sum(errors(speed_study(robot, gaits, texts(point))) ** 2))
        return found * (1 + outside) if math.isfinite(found) else 1e6

    best = np.zeros(0)
    if slots:
        spread = qmc.Halton(len(slots), scramble=False).random(1 + samples * len(slots))[1:]
        points = [*(low + spread * (high - low)), *(np.log(start) for start in starts)]
        start = min(points, key=misfit)
        options = {"maxfev": polish * len(slots), "xatol": 0.005, "fatol": 0.01}
        best = np.asarray(minimize(misfit, start, method="Nelder-Mead", options=options).x)
    effects = texts(best)
    rows = speed_study(robot, gaits, effects)
    values = {f"{t.quantity}@{t.omega_rad_s:g}": measured(rows, t) for t in TARGETS}
    point = tuple(float(x) for x in np.exp(np.clip(best, low, high)))
    return GapFit(effects, float(np.sum(errors(rows) ** 2)), point, values)


def gap_study(
    robot: Robot,
    folder: Path | None = None,
    *,
    which: Sequence[tuple[str, ...]] | None = None,
    quick: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> list[GapFit]:
    """Fits of all candidates, the best first; the servo as it is comes in as a candidate without effects.

    Args:
        folder: fits are kept here, so that an interrupted study goes on where it was.
        quick: a coarse search, for a look.
    """
    todo = [(), *(candidates() if which is None else which)]
    effort = (8, 20) if quick else (16, 40)
    store = folder / "gap_fits.json" if folder is not None else None
    study = [robot.to_mapping(), [asdict(t) for t in TARGETS], RANGES, NEUTRAL, effort]
    mark = json.dumps(study, default=str)
    known, fits = _load(store, mark), []
    for done, names in enumerate(todo):
        if progress is not None:
            progress(done, len(todo))
        key = "+".join(names)
        if key not in known:
            known[key] = fit_effects(robot, names, *effort, starts=_starts(names, known))
            _save(store, mark, known)
        fits.append(known[key])
    if progress is not None:
        progress(len(todo), len(todo))
    return sorted(fits, key=lambda fit: fit.score)


def _starts(names: tuple[str, ...], known: dict[str, GapFit]) -> list[tuple[float, ...]]:
    """The best of each effect of a pair alone, with the other one neutral."""
    if len(names) != 2:
        return []
    first, second = names
    found = []
    if first in known:
        found.append((*known[first].point, *NEUTRAL[second]))
    if second in known:
        found.append((*NEUTRAL[first], *known[second].point))
    return found


def _load(store: Path | None, mark: str) -> dict[str, GapFit]:
    if store is None or not store.exists():
        return {}
    try:
        data = json.loads(store.read_text(encoding="utf-8"))
        if data["study"] != mark:
            return {}
        return {
            key: GapFit(tuple(fit["effects"]), fit["misfit"], tuple(fit["point"]), fit["values"])
            for key, fit in data["fits"].items()
        }
    except (OSError, ValueError, KeyError, TypeError):
        return {}  # damaged: fit again


def _save(store: Path | None, mark: str, fits: dict[str, GapFit]) -> None:
    if store is None:
        return
    part = store.with_suffix(".part")
    try:
        store.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"study": mark, "fits": {key: asdict(fit) for key, fit in fits.items()}})
        part.write_text(text, encoding="utf-8")
        part.replace(store)
    except OSError as error:
        raise BadInputError(f"{store}: cannot keep the fits: {error.strerror}") from None


def summary(robot: Robot, fits: Sequence[GapFit]) -> dict[str, Any]:
    """Plain values for ``--json``."""
    return {
        "robot": robot.name,
        "targets": [asdict(target) for target in TARGETS],
        "fits": [{**asdict(fit), "label": fit.label, "score": fit.score} for fit in fits],
    }
