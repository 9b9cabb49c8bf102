"""Half length and mass of the paper's links, which its Table I would give, from what its text does give.

Several readings of the friction model are tried, as the printed one (25) does not lead to the paper's optimal gaits.
Each is fitted by least squares to the same numbers; what is left over says which reading is likely to be behind the
paper's figures, and the spread of l over the readings says how well l is known. Only l omega sets the speeds of links
that are as light as these, so that l comes from the frequencies; the mass comes from the tilt at which the robot rolls.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.studies.optimum import SweptOptimum, cheapest, slope_through_origin

if TYPE_CHECKING:
    from snakebot.physics import ChainModel
    from snakebot.robot import Robot


# The sweep that a fit repeats: coarse, as the optimum is found between its gaits.
ALPHA_DEG = np.arange(18.0, 91.0, 6.0)
BETA_DEG = np.arange(60.0, 109.0, 8.0)
OMEGA_RAD_S = np.array([0.5, 1.0, 1.5, 2.0, 3.0, 4.5, 6.5, 9.0])
STEPS, CYCLES = 240, 4  # a step is a third of the paper study's: an error of 1 % in power
OPTIMUM = (66.0, 80.0, 2.0)  # alpha and beta in deg, omega in rad/s: the paper's optimal gait
LINE_OMEGAS = (2.0, 3.0, 4.0, 5.0)  # rad/s: points on the line of the paper's Fig. 17
TILT_DEG, TILT_STEP_DEG = 2.0, 0.2  # Section VII: where the robot starts to roll, and the step of the tilt


def line_speed(omega_rad_s: float) -> float:
    """Speed on the paper's front at a frequency: omega = 7.88 v + 0.97 (Fig. 17)."""
    return (omega_rad_s - 0.97) / 7.88


def line_alpha_deg(omega_rad_s: float) -> float:
    """Alpha on the paper's front (Fig. 16): from 70 deg at 1 rad/s through 66 deg at 2 to 40 deg at 5."""
    return float(np.interp(omega_rad_s, (1, 2, 5), (70, 66, 40)))


@dataclass(frozen=True)
class FrictionReading:
    """One way to read the friction model, with what is fitted besides l and m."""

    name: str
    what: str
    normal_coulomb: bool = True
    more: tuple[str, ...] = ()  # names of _EXTRA


_EXTRA = {"sign_width_m_s": 0.05, "ct0_factor": 1.5}  # where a fit starts
READINGS = (
    FrictionReading("printed", "friction as the paper prints it, a sharp sign"),
    FrictionReading("soft_sign", "as printed, the sign smoothed over a speed that is fitted", more=("sign_width_m_s",)),
    FrictionReading("no_normal_coulomb", "Coulomb friction along the links only", normal_coulomb=False),
    FrictionReading(
        "more_rolling_coulomb",
        "Coulomb friction along the links only, times a factor that is fitted",
        normal_coulomb=False,
        more=("ct0_factor",),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Fact:
    """One number of the paper. ``bound``: ours may be more (+1) or less (-1); 0: it is a value."""

    name: str
    paper: float
    sigma: float
    bound: int = 0

    def error(self, ours: float) -> float:
        """Deviation over sigma; nothing on the right side of a bound."""
        if not math.isfinite(ours):
            return 10.0
        error = (ours - self.paper) / self.sigma
        return error if self.bound == 0 else (min(0.0, error) if self.bound > 0 else max(0.0, error))


def facts() -> list[Fact]:
    """What the text gives, with how well the figures can be read."""
    listed = [Fact("v(66, 80, 2), m/s", line_speed(2.0), 0.01)]
    for omega in LINE_OMEGAS:
        listed += [
            Fact(f"omega at {line_speed(omega):.3f} m/s, rad/s", omega, 0.05 * omega),
            Fact(f"alpha at {line_speed(omega):.3f} m/s, deg", line_alpha_deg(omega), 5.0),
            Fact(f"beta at {line_speed(omega):.3f} m/s, deg", 80.0, 5.0),
        ]
    listed += [
        Fact("viscous: omega / v, rad/m", 9.30, 0.3),
        Fact("viscous: alpha, deg", 30.0, 5.0),
        Fact("viscous: beta, deg", 80.0, 5.0),
    ]
    listed += [Fact(f"rigid {label}: speed ratio", 1.0, 0.03, +1) for label in ("1", "5", "1+2", "4+5")]
    listed += [Fact(f"free {joint}: speed ratio", 1.0, 0.03, -1) for joint in range(1, 6)]
    listed.append(Fact("tilt that rolls, deg", TILT_DEG, TILT_STEP_DEG / 2))
    return listed


@dataclass(frozen=True)
class Inference:
    """Best fit of one reading.

    Attributes:
        estimate, ci95: of half_length_m, link_mass_kg and the reading's own; the interval is scaled by the misfit.
        ours: what each fact comes to.
        chi2: sum of squared errors over sigma.
    """

    reading: FrictionReading
    estimate: dict[str, float]
    ci95: dict[str, tuple[float, float]]
    ours: dict[str, float]
    chi2: float
    freedom: int


def parameters(reading: FrictionReading) -> tuple[str, ...]:
    """Names of what is fitted."""
    return ("half_length_m", "link_mass_kg", *reading.more)


def evaluate(robot: Robot, reading: FrictionReading, values: Mapping[str, float]) -> dict[str, float]:
    """What a reading makes of each fact.

    Raises:
        BadInputError: the robot has no body.
    """
    from snakebot.physics import simulate_gaits
    from snakebot.physics.model import STANDARD_GRAVITY_M_S2

    model, viscous = _models(robot, reading, values)
    eps = values.get("sign_width_m_s")
    a, b, w = np.meshgrid(np.radians(ALPHA_DEG), np.radians(BETA_DEG), OMEGA_RAD_S, indexing="ij")
    grid = np.column_stack([a.ravel(), b.ravel(), w.ravel()])
    front = simulate_gaits(model, grid, steps_per_cycle=STEPS, eps_m_s=eps, cycles=CYCLES, averaged_cycles=2)
    smooth = simulate_gaits(viscous, grid, steps_per_cycle=STEPS // 2, cycles=CYCLES, averaged_cycles=2)
    gait = [[*np.radians(OPTIMUM[:2]), OPTIMUM[2]]]

    def speed(free: tuple[int, ...] = (), rigid: tuple[int, ...] = ()) -> float:
        found = simulate_gaits(model, gait, eps_m_s=eps, free_joints=free, rigid_joints=rigid)
        return float(found.speed_m_s[0])

    healthy = speed()
    found = {"v(66, 80, 2), m/s": healthy}
    for omega in LINE_OMEGAS:
        v = line_speed(omega)
        at = cheapest(front.gaits, front.speed_m_s, front.power_in_w, [v])
        for name, unit in (("omega", "rad/s"), ("alpha", "deg"), ("beta", "deg")):
            key = f"{name}_{unit.replace('/', '_')}"
            found[f"{name} at {v:.3f} m/s, {unit}"] = getattr(at[0], key) if at else math.nan
    lines = cheapest(smooth.gaits, smooth.speed_m_s, smooth.power_in_w, (0.1, 0.2, 0.3))
    found["viscous: omega / v, rad/m"] = slope_through_origin(lines) if lines else math.nan
    found["viscous: alpha, deg"] = _mean(lines, "alpha_deg")
    found["viscous: beta, deg"] = _mean(lines, "beta_deg")
    for label, joints in (("1", (1,)), ("5", (5,)), ("1+2", (1, 2)), ("4+5", (4, 5))):
        found[f"rigid {label}: speed ratio"] = speed(rigid=joints) / healthy
    for joint in range(1, 6):
        found[f"free {joint}: speed ratio"] = speed(free=(joint,)) / healthy
    # Whatever the simulation takes for the sliding parts, 0.49 N is what was measured (31).
    share = _friction(robot, "ct0") / (values["link_mass_kg"] * STANDARD_GRAVITY_M_S2)
    found["tilt that rolls, deg"] = math.degrees(math.asin(min(1.0, share)))
    return found


def infer(
    robot: Robot,
    readings: Sequence[FrictionReading] = READINGS,
    progress: Callable[[int, int], None] | None = None,
) -> list[Inference]:
    """Fits of all readings, the best first."""
    results = []
    for done, reading in enumerate(readings):
        if progress is not None:
            progress(done, len(readings))
        results.append(fit_reading(robot, reading))
    if progress is not None:
        progress(len(readings), len(readings))
    return sorted(results, key=lambda result: result.chi2)


def fit_reading(robot: Robot, reading: FrictionReading) -> Inference:
    """Least squares over the logarithms of the parameters (Gauss-Newton with a step that fits the sweep's grain)."""
    from scipy.optimize import least_squares

    names, listed = parameters(reading), facts()
    start = {"half_length_m": 0.1, "link_mass_kg": 1.4, **_EXTRA}
    known: dict[tuple[float, ...], dict[str, float]] = {}

    def ours(point: Floats) -> dict[str, float]:
        key = tuple(np.round(point, 6))
        if key not in known:
            values = dict(zip(names, np.exp(point), strict=True))
            known[key] = evaluate(robot, reading, {k: float(x) for k, x in values.items()})
        return known[key]

    def errors(point: Floats) -> Floats:
        found = ours(point)
        return np.array([fact.error(found[fact.name]) for fact in listed])

    x0 = np.log([start[name] for name in names])
    fit = least_squares(
        errors,
        x0,
        bounds=(x0 - 2.0, x0 + 2.0),
        diff_step=0.02,
        x_scale=0.1,
        xtol=2e-3,
        ftol=1e-3,
        max_nfev=12,
    )
    chi2, freedom = float(2 * fit.cost), len(listed) - len(names)
    spread = np.linalg.pinv(fit.jac.T @ fit.jac) * max(1.0, chi2 / freedom)
    reach = 1.96 * np.sqrt(np.diag(spread))
    best = [math.exp(x) for x in fit.x]
    return Inference(
        reading,
        dict(zip(names, best, strict=True)),
        {
            n: (x * math.exp(-r), x * math.exp(min(r, 20.0)))
            for n, x, r in zip(names, best, reach, strict=True)
        },
        ours(fit.x),
        chi2,
        freedom,
    )


def _models(
    robot: Robot, reading: FrictionReading, values: Mapping[str, float]
) -> tuple[ChainModel, ChainModel]:
    """The chain with this reading's friction, and the same without its Coulomb part."""
    from snakebot.physics import ChainModel

    if robot.body is None:
        raise BadInputError(f"robot {robot.name!r} has no body: there is nothing to infer")
    friction = robot.body.friction
    factor = values.get("ct0_factor", 1.0)
    read = friction.model_copy(
        update={
            "ct0": _friction(robot, "ct0") * factor,
            "cn0": friction.cn0 if reading.normal_coulomb else 0.0,
        }
    )
    sizes = {"half_length_m": values["half_length_m"], "link_mass_kg": values["link_mass_kg"]}
    body = robot.body.model_copy(update={**sizes, "friction": read})
    plain = friction.model_copy(update={"ct0": 0.0, "cn0": 0.0})
    smooth = robot.body.model_copy(update={**sizes, "friction": plain})
    return ChainModel.from_body(body), ChainModel.from_body(smooth)


def _friction(robot: Robot, name: str) -> float:
    assert robot.body is not None
    return float(np.mean(getattr(robot.body.friction, name)))


def _mean(optima: Sequence[SweptOptimum], name: str) -> float:
    return float(np.mean([getattr(o, name) for o in optima])) if optima else math.nan


def summary(robot: Robot, results: Sequence[Inference]) -> dict[str, Any]:
    """Plain values for ``--json``; what is not known is None."""
    listed = facts()
    return {
        "robot": robot.name,
        "readings": [
            {
                "name": result.reading.name,
                "what": result.reading.what,
                "estimate": result.estimate,
                "ci95": {name: list(bounds) for name, bounds in result.ci95.items()},
                "chi2": result.chi2,
                "freedom": result.freedom,
                "facts": [
                    {**asdict(f), "ours": x if math.isfinite(x := result.ours[f.name]) else None}
                    for f in listed
                ],
            }
            for result in results
        ],
    }
