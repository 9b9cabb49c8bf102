"""What the best gait is best at."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.optimise.outcomes import Outcomes

Aim = Literal["speed", "power-at-speed", "cost-of-transport"]
AIMS: tuple[Aim, ...] = get_args(Aim)
REACHED = 2e-3  # share of a speed by which it may be missed; chosen, near the simulation's own error


@dataclass(frozen=True)
class Goal:
    """The highest speed, the least power at a speed, or the least energy for a way.

    Raises:
        BadInputError: a speed is missing, is none, or is not asked for.
    """

    aim: Aim
    speed_m_s: float | None = None

    def __post_init__(self) -> None:
        if self.aim == "power-at-speed":
            if self.speed_m_s is None:
                raise BadInputError("--for power-at-speed: say which speed, as in --speed 0.2")
            if not (math.isfinite(self.speed_m_s) and self.speed_m_s > 0):
                raise BadInputError(f"--speed {self.speed_m_s:g}: a speed is above zero")
        elif self.speed_m_s is not None:
            raise BadInputError(f"--speed: only with --for power-at-speed, not with --for {self.aim}")

    def scores(self, outcomes: Outcomes, torque_most: float = math.inf) -> Floats:
        """(D, G), the higher the better; minus infinity where the torque or the speed does not suffice."""
        if self.aim == "speed":
            found = outcomes.speed_m_s.copy()
        elif self.aim == "cost-of-transport":
            found = -outcomes.transport()
        else:
            assert self.speed_m_s is not None
            reached = outcomes.speed_m_s >= (1 - REACHED) * self.speed_m_s
            found = np.where(reached, -outcomes.power_in_w, -np.inf)
        return np.where(outcomes.torque_use > torque_most, -np.inf, found)

    def worst(self, outcomes: Outcomes, torque_most: float = math.inf) -> Floats:
        """(G,) of the robot that a gait suits least."""
        return np.asarray(self.scores(outcomes, torque_most).min(axis=0))
