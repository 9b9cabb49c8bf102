"""How far the paper is reproduced: everything computed that its claims 1 to 8 need."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.gait import Gait
from snakebot.robot import Robot, load_robot
from snakebot.studies.gap import paper_gait
from snakebot.studies.hyperredundancy import fault_cases
from snakebot.studies.inference import OPTIMUM, READINGS, evaluate
from snakebot.studies.optimum import cheapest
from snakebot.studies.paper_claims import POWER, SPEED, Front, PaperEvidence, Row, rows
from snakebot.studies.pareto import ALPHA_DEG, BETA_DEG, OMEGA_RAD_S, Pareto, front_of, pareto
from snakebot.studies.speed import speed_study

Step = Callable[[str], None]

# Beyond the paper's 5 rad/s, so that the optimum at 5 lies inside the sweep and not at its edge.
BEYOND_RAD_S = (6.0, 7.5, 9.0)
SPEEDS = 60  # at which the cheapest gait is sought
SERVO = "paper_servo"
READING_M, READING_KG = 0.118, 1.43  # what `infer` gives for friction without a normal Coulomb part


def grid(quick: bool) -> Floats:
    """The paper's gaits and those beyond 5 rad/s, (G, 3); ``quick``: an eighth of them, around the optima."""
    alpha, beta, omega = ALPHA_DEG, BETA_DEG, np.concatenate([OMEGA_RAD_S, BEYOND_RAD_S])
    if quick:
        alpha = alpha[(alpha >= 9) & (alpha <= 60)]
        beta, omega = beta[(beta >= 42) & (beta <= 102)], np.array([0.5, 1.0, 2.0, 3.5, 5.0, 7.5])
    a, b, w = np.meshgrid(np.radians(alpha), np.radians(beta), omega, indexing="ij")
    return np.column_stack([a.ravel(), b.ravel(), w.ravel()])


def paper_study(
    folder: Path | None = None, *, quick: bool = False, step: Step = lambda what: None
) -> tuple[list[Row], PaperEvidence]:
    """Compute the evidence and check every claim.

    Args:
        folder: the sweeps are kept here, so that an interrupted study goes on where it was.
        quick: a part of the sweep, for a look.
        step: told what is computed next.

    Raises:
        BadInputError: the folder cannot be used.
    """
    evidence = gather(folder, quick, step)
    return rows(evidence), evidence


def gather(folder: Path | None, quick: bool, step: Step) -> PaperEvidence:
    """All computations of the study."""
    penn = load_robot("penn_state")
    robots = [load_robot("saito"), load_robot("saito_wheeled"), penn, viscous(penn)]
    gaits, fronts, sweep_s = grid(quick), {}, None
    for robot in robots:
        step(f"gaits of {robot.name}")
        where = folder / robot.name if folder is not None else None
        fresh = where is None or not where.exists()
        began = time.perf_counter()
        fronts[robot.name] = front(robot, pareto(robot, where, gaits=gaits).rows)
        if robot.name == penn.name and fresh and not quick:
            sweep_s = (time.perf_counter() - began) * 9000 / len(gaits)
    optimum = Gait.from_degrees(*OPTIMUM)
    step("faults")
    faults = fault_cases(penn, optimum, most=3)
    step("servo")
    speeds = speed_study(penn, [paper_gait(omega) for omega in (2.0, 3.0, 4.0, 5.0)], [SERVO])
    step("friction model")
    half = {"half_length_m": READING_M, "link_mass_kg": READING_KG}
    reading = next(r for r in READINGS if r.name == "no_normal_coulomb")
    from snakebot.effects.spec import load_effect_set

    return PaperEvidence(
        fronts=fronts,
        joint_power_w={
            robot.name: joint_power_w(robot, Gait.from_degrees(22, 60, 5)) for robot in robots[:2]
        },
        settled=settled(penn, fronts[penn.name]),
        faults=faults,
        optimum_speed_m_s=faults[0].speed_m_s,
        optimum_power_w=faults[0].power_w,
        servo=speeds,
        servo_effects=tuple(str(spec) for spec in load_effect_set(SERVO)),
        reading=evaluate(penn, reading, half),
        sweep_s=sweep_s,
        quick=quick,
    )


def viscous(robot: Robot) -> Robot:
    """The same robot without the Coulomb part of its friction (Figs. 18 to 20)."""
    assert robot.body is not None
    friction = robot.body.friction.model_copy(update={"ct0": 0.0, "cn0": 0.0})
    body = robot.body.model_copy(update={"friction": friction})
    return robot.model_copy(update={"name": f"{robot.name}_viscous", "body": body})


def front(robot: Robot, swept: Floats) -> Front:
    """The front of the paper's own gaits, and the cheapest gaits between all that were swept."""
    own = swept[swept[:, 2] <= OMEGA_RAD_S[-1] + 1e-9]
    result = Pareto(robot, own, front_of(own[:, SPEED], own[:, POWER]))
    top = float(own[:, SPEED].max())
    speeds = np.linspace(top / SPEEDS, top, SPEEDS)
    return Front(result, tuple(cheapest(swept[:, :3], swept[:, SPEED], swept[:, POWER], speeds.tolist())))


def joint_power_w(robot: Robot, gait: Gait) -> float:
    """Mean of the sum of |u_i phi_dot_i| over the steady cycles: of servos that take no work back."""
    from snakebot.physics import ChainModel, gait_trajectory

    assert robot.body is not None
    moved = gait_trajectory(
        ChainModel.from_body(robot.body), [gait.alpha_rad, gait.beta_rad, gait.omega_rad_s]
    )
    steady = moved.t_s > 4 * gait.period_s
    return float(np.abs(moved.joint_torque_nm * moved.joint_rate_rad_s)[steady].sum(axis=1).mean())


def settled(robot: Robot, found: Front, omegas: Sequence[float] = (1.0, 2.0, 3.0, 4.0)) -> float:
    """Largest change of the speed of the cheapest gaits from cycles 5 to 8 to cycles 9 to 16, as a share."""
    from snakebot.physics import ChainModel, simulate_gaits

    assert robot.body is not None
    model = ChainModel.from_body(robot.body)
    gaits = [[*np.radians([found.at(w, "alpha_deg"), found.at(w, "beta_deg")]), w] for w in omegas]
    gaits = [gait for gait in gaits if np.isfinite(gait).all()]
    if not gaits:
        return math.nan
    early = simulate_gaits(model, gaits, cycles=8, averaged_cycles=4).speed_m_s
    late = simulate_gaits(model, gaits, cycles=16, averaged_cycles=8).speed_m_s
    return float(np.max(np.abs(late / early - 1)))


def summary(table: Sequence[Row], evidence: PaperEvidence) -> dict[str, Any]:
    """Plain values for ``--json``."""
    return {
        "claims": [asdict(row) for row in table],
        "agree": sum(row.agrees is True for row in table),
        "disagree": sum(row.agrees is False for row in table),
        "optima": {name: [asdict(o) for o in found.optima] for name, found in evidence.fronts.items()},
        "faults": [{**asdict(case), "label": case.label} for case in evidence.faults],
        "servo_effects": list(evidence.servo_effects),
        "servo": [asdict(row) for row in evidence.servo],
    }
