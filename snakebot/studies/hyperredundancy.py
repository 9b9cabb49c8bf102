"""How the robot moves with failed joints: every single, pair and triple, free and rigid (Table IV's layout)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Literal

from snakebot.gait import Gait
from snakebot.robot import Robot
from snakebot.studies.sweep import POWER, SPEED, Conditions, compute

Kind = Literal["none", "free", "rigid"]


@dataclass(frozen=True)
class FaultCase:
    """Steady speed and power with these joints (from 1) free or rigid; ratios are to the healthy robot."""

    kind: Kind
    joints: tuple[int, ...]
    speed_m_s: float
    power_w: float
    speed_ratio: float
    power_ratio: float

    @property
    def label(self) -> str:
        return "none" if self.kind == "none" else f"{self.kind} {'+'.join(map(str, self.joints))}"


def fault_cases(
    robot: Robot, gait: Gait, most: int = 3, progress: Callable[[int, int], None] | None = None
) -> list[FaultCase]:
    """The healthy robot first, then all combinations of up to ``most`` joints, free and rigid (held straight).

    Raises:
        BadInputError: the robot has no body.
    """
    joints = range(1, robot.joints + 1)
    wanted: list[tuple[Kind, tuple[int, ...]]] = [("none", ())]
    for count in range(1, min(most, robot.joints) + 1):
        for kind in ("free", "rigid"):
            wanted += [(kind, chosen) for chosen in combinations(joints, count)]
    cases: list[FaultCase] = []
    for done, (kind, chosen) in enumerate(wanted):
        if progress is not None:
            progress(done, len(wanted))
        conditions = Conditions.of(
            robot,
            free_joints=chosen if kind == "free" else (),
            rigid_joints=dict.fromkeys(chosen, 0.0) if kind == "rigid" else {},
        )
        row = compute(conditions, gait_row(gait))[0]
        speed, power = float(row[SPEED]), float(row[POWER])
        healthy = cases[0] if cases else FaultCase("none", (), speed, power, 1.0, 1.0)
        cases.append(
            FaultCase(kind, chosen, speed, power, speed / healthy.speed_m_s, power / healthy.power_w)
        )
    if progress is not None:
        progress(len(wanted), len(wanted))
    return cases


def gait_row(gait: Gait) -> Any:
    """One gait as the sweep takes it, shape (1, 4)."""
    import numpy as np

    return np.array([[gait.alpha_rad, gait.beta_rad, gait.omega_rad_s, gait.offset_rad]])
