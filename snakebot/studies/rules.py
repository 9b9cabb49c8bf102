"""Which gait other readings of "optimal" would choose at one frequency: the paper does not spell its rule out.

The paper takes "the values closest to the boundary" of power over speed (29). Power may also be meant as what the
joints take without giving any back, and a front read off at one frequency as the least cost of transport there.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.robot import Robot
from snakebot.studies.optimum import SweptOptimum, cheapest
from snakebot.studies.pareto import front_of

ALPHA_DEG, BETA_DEG = np.arange(18.0, 91.0, 6.0), np.arange(36.0, 133.0, 12.0)
OMEGA_RAD_S = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0])
STEPS, CYCLES = 240, 3  # steps a cycle, and cycles of which the last is measured; chosen


@dataclass(frozen=True)
class Choice:
    """What a rule chooses at the frequency; NaN where its optimum lies at the edge of the sweep."""

    rule: str
    alpha_deg: float
    beta_deg: float
    speed_m_s: float


def choices(robot: Robot, omega_rad_s: float = 2.0) -> list[Choice]:
    """One row a rule, on a coarse sweep.

    Raises:
        BadInputError: the robot has no body.
    """
    from snakebot.physics import ChainModel, gait_trajectory

    if robot.body is None:
        raise BadInputError(f"robot {robot.name!r} has no body: it has no optimal gait")
    model = ChainModel.from_body(robot.body)
    a, b, w = np.meshgrid(np.radians(ALPHA_DEG), np.radians(BETA_DEG), OMEGA_RAD_S, indexing="ij")
    gaits = np.column_stack([a.ravel(), b.ravel(), w.ravel()])

    def one(gait: Floats) -> tuple[float, float, float]:
        moved = gait_trajectory(model, gait, cycles=CYCLES, steps_per_cycle=STEPS)
        last = slice((CYCLES - 1) * STEPS + 1, None)
        joint = moved.joint_torque_nm[last] * moved.joint_rate_rad_s[last]
        way = moved.com_m[-1] - moved.com_m[-1 - STEPS]
        speed = float(np.hypot(*way) * gait[2] / (2 * np.pi))
        return speed, float(joint.sum(axis=1).mean()), float(np.abs(joint).sum(axis=1).mean())

    with ThreadPoolExecutor() as pool:
        speed, net, taken = np.array(list(pool.map(one, gaits))).T
    at = np.flatnonzero(np.isclose(gaits[:, 2], omega_rad_s) & (speed > 0.1 * speed.max() / OMEGA_RAD_S[-1]))
    speeds = np.linspace(0.2, 3.0, 40) * float(np.median(speed[at]))

    def chosen(rule: str, row: np.intp) -> Choice:
        alpha, beta = np.degrees(gaits[row, :2])
        return Choice(rule, float(alpha), float(beta), float(speed[row]))

    def best(rule: str, cost: Floats) -> Choice:
        row = at[np.argmin(cost[at])]
        return chosen(rule, row)

    front = front_of(speed, net)
    on_front = front[np.isclose(gaits[front, 2], omega_rad_s)]
    found = [
        _at(
            omega_rad_s,
            "least power for the speed (the paper's)",
            cheapest(gaits, speed, net, speeds.tolist()),
        ),
        _at(
            omega_rad_s, "the same, power as sum |u phi_dot|", cheapest(gaits, speed, taken, speeds.tolist())
        ),
        best("least power over speed", net / speed),
        best("least power over speed squared", net / speed**2),
    ]
    if on_front.size:
        found.append(chosen("fastest of the front", on_front[np.argmax(speed[on_front])]))
    return found


def _at(omega: float, rule: str, optima: Sequence[SweptOptimum]) -> Choice:
    rows = sorted(optima, key=lambda o: o.omega_rad_s)
    omegas = [o.omega_rad_s for o in rows]
    values = [
        float(np.interp(omega, omegas, [getattr(o, name) for o in rows], left=np.nan, right=np.nan))
        if rows
        else np.nan
        for name in ("alpha_deg", "beta_deg", "speed_m_s")
    ]
    alpha, beta, speed = values
    return Choice(rule, alpha, beta, speed)
