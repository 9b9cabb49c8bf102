"""Joints behind a simulated board that lag behind their set-points, and that hands can turn: no physics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from firmware_protocol.catalogue import Fault
from snakebot.softboard.hardware import HardwareFault, Health

_LOOK_S = 0.02  # as servos on a bus want to be looked at


class LaggingPlant:
    """First-order servos and ideal encoders, as the C core has them on the bench (port/model)."""

    clock_ppm = 0.0

    def __init__(self, joints: int, counts_per_rev: int = 8192, time_constant_s: float = 0.03) -> None:
        self._counts_per_rad = counts_per_rev / (2 * math.pi)
        self._time_constant_s = time_constant_s
        self._angle_rad = [0.0] * joints
        self._target_rad = [0.0] * joints
        self._powered = [True] * joints
        self._lost: set[int] = set()
        self._now_s = 0.0

    def turn(self, joint: int, angle_rad: float) -> None:
        """Turn a joint (from 1) by hand."""
        self._angle_rad[joint - 1] = angle_rad

    def lose(self, joint: int, lost: bool) -> None:
        """Its encoder gives no reading, or gives one again."""
        (self._lost.add if lost else self._lost.discard)(joint - 1)

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        self.advance(t_s)
        self._target_rad = list(setpoint_rad)

    def set_joint_mode(self, joint: int, mode: Literal["active", "free"], /) -> None:
        self._powered[joint - 1] = mode == "active"
        self._target_rad[joint - 1] = self._angle_rad[joint - 1]

    def advance(self, t_s: float) -> None:
        left = math.exp(-max(t_s - self._now_s, 0.0) / self._time_constant_s)
        self._now_s = max(t_s, self._now_s)
        for joint, (angle, target) in enumerate(zip(self._angle_rad, self._target_rad, strict=True)):
            if self._powered[joint]:
                self._angle_rad[joint] = target + (angle - target) * left

    def encoder_counts(self) -> list[int | None]:
        return [
            None if joint in self._lost else round(angle * self._counts_per_rad)
            for joint, angle in enumerate(self._angle_rad)
        ]

    def pose(self) -> None:
        return None


class LaggingHardware(LaggingPlant):
    """The same as servos that can fail, and measure themselves."""

    def __init__(self, joints: int) -> None:
        super().__init__(joints)
        self._joints = joints
        self._fault: HardwareFault | None = None
        self._supply: tuple[int, int, int] | None = None

    @property
    def due_s(self) -> float:
        return self._now_s + _LOOK_S

    def fault(self) -> HardwareFault | None:
        return self._fault

    def health(self) -> Health | None:
        if self._supply is None:
            return None
        millivolts, milliamperes, decidegrees = self._supply
        joints = range(1, self._joints + 1)
        return Health(
            millivolts / 1000,
            tuple(((milliamperes + joint) / 1000, (decidegrees + 2 * joint) / 10) for joint in joints),
        )

    def fail(self, code: Fault, joint: int, detail: int) -> None:
        """A fault begins, or with ``Fault.NONE`` ends."""
        self._fault = None if code is Fault.NONE else HardwareFault(code, joint, detail)

    def measure(self, supply: tuple[int, int, int] | None) -> None:
        """What is measured from now on: mV, mA and tenths of a degree, as the suite's ``Lab`` has it."""
        self._supply = supply
