"""Speed and power on a small grid around one gait: how much a gait that is a little off costs (Table III's layout)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.robot import Robot
from snakebot.studies.sweep import POWER, SPEED, Conditions, compute

HALF_TURN_DEG = 180.0  # from here on a joint would go round, and phases repeat


@dataclass(frozen=True, eq=False)
class Grid:
    """Speed in m/s and power in W, shape (alphas, betas), at one omega."""

    robot: Robot
    omega_rad_s: float
    alpha_deg: Floats
    beta_deg: Floats
    speed_m_s: Floats
    power_w: Floats

    def summary(self) -> dict[str, Any]:
        """Plain values for ``--json``."""
        return {
            "robot": self.robot.name,
            "omega_rad_s": self.omega_rad_s,
            "alpha_deg": self.alpha_deg.tolist(),
            "beta_deg": self.beta_deg.tolist(),
            "speed_m_s": self.speed_m_s.tolist(),
            "power_w": self.power_w.tolist(),
        }


def near_optimum(
    robot: Robot, gait: Gait, alpha_step_deg: float, beta_step_deg: float, reach: int = 2
) -> Grid:
    """``reach`` steps either side of ``gait`` in alpha and in beta, ideal tracking.

    Raises:
        BadInputError: the robot has no body, or a step is no finite number or goes round in ``reach`` of them.
    """
    for name, step_deg in (("alpha", alpha_step_deg), ("beta", beta_step_deg)):
        if not np.isfinite(step_deg):
            raise BadInputError(f"step of {name}: {step_deg:g} deg; it must be a finite number")
        if reach * abs(step_deg) > HALF_TURN_DEG:
            raise BadInputError(
                f"step of {name}: {reach} of {step_deg:g} deg are more than half a turn; "
                f"take {HALF_TURN_DEG / reach:g} deg at most"
            )
    steps = np.arange(-reach, reach + 1)
    alphas = np.degrees(gait.alpha_rad) + alpha_step_deg * steps
    betas = np.degrees(gait.beta_rad) + beta_step_deg * steps
    alphas = alphas[alphas > 0]
    a, b = np.meshgrid(np.radians(alphas), np.radians(betas), indexing="ij")
    gaits = np.column_stack(
        [a.ravel(), b.ravel(), np.full(a.size, gait.omega_rad_s), np.full(a.size, gait.offset_rad)]
    )
    rows = compute(Conditions.of(robot), gaits)
    return Grid(
        robot,
        gait.omega_rad_s,
        alphas,
        betas,
        rows[:, SPEED].reshape(a.shape),
        rows[:, POWER].reshape(a.shape),
    )
