"""A plant for tests of the loop: joints with an exact first-order lag, no body."""

from __future__ import annotations

import math
from collections.abc import Sequence


class LagPlant:
    """phi' = (set-point - phi) / tau, set-points held; a joint without power stays where it is."""

    clock_ppm = 0.0

    def __init__(self, joints: int, time_constant_s: float, counts_per_rev: int = 8192) -> None:
        self.angle = [0.0] * joints
        self.setpoint: list[float] | None = None
        self.modes: list[tuple[str, float | None]] = [("free", None)] * joints
        self.tau = time_constant_s
        self.step = 2 * math.pi / counts_per_rev
        self.t: float | None = None

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        self.advance(t_s)
        self.setpoint = list(setpoint_rad)

    def set_joint_mode(self, joint: int, mode: str, hold_rad: float | None = None) -> None:
        self.modes[joint - 1] = (mode, hold_rad)

    def advance(self, t_s: float) -> None:
        dt = 0.0 if self.t is None else max(0.0, t_s - self.t)
        self.t = t_s
        for joint, (mode, hold) in enumerate(self.modes):
            if mode == "free":
                continue
            target = hold if hold is not None else self.setpoint[joint] if self.setpoint else None
            if target is not None:
                self.angle[joint] += (target - self.angle[joint]) * (1 - math.exp(-dt / self.tau))

    def encoder_counts(self) -> list[int]:
        return [round(angle / self.step) for angle in self.angle]

    def pose(self) -> None:
        return None
