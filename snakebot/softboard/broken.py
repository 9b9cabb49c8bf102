"""Joints that break by themselves, on a time table: behind the board's back, unlike a joint mode that a host sets."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, SupportsInt


@dataclass(frozen=True, slots=True)
class Breakage:
    """From ``at_s`` on (since the board started) these joints (from 1) are free, rigid, or repaired (active).

    A rigid joint is stuck at ``angle_rad``, or where it is when that is None.
    """

    at_s: float
    joints: tuple[int, ...]
    mode: Literal["active", "free", "rigid"]
    angle_rad: float | None = None


class BreakingPlant:
    """``snakebot.effects.Plant`` with joints that break. The board neither knows nor can change it.

    Args:
        plant: what has the joints; it understands the mode ``rigid`` too.
        breakages: in any order.
    """

    def __init__(self, plant: Any, breakages: Sequence[Breakage]) -> None:
        self._plant = plant
        self._coming = sorted(breakages, key=lambda breakage: breakage.at_s)
        self._broken: set[int] = set()
        self._wanted: dict[int, Literal["active", "free"]] = {}

    @property
    def clock_ppm(self) -> float:
        return float(self._plant.clock_ppm)

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        self._plant.command(t_s, setpoint_rad)

    def set_joint_mode(self, joint: int, mode: Literal["active", "free"], /) -> None:
        self._wanted[joint] = mode
        if joint not in self._broken:
            self._plant.set_joint_mode(joint, mode)

    def advance(self, t_s: float) -> None:
        while self._coming and self._coming[0].at_s <= t_s:
            breakage = self._coming.pop(0)
            self._plant.advance(breakage.at_s)
            for joint in breakage.joints:
                self._break(joint, breakage)
        self._plant.advance(t_s)

    def _break(self, joint: int, breakage: Breakage) -> None:
        if breakage.mode == "active":
            self._broken.discard(joint)
            self._plant.set_joint_mode(joint, self._wanted.get(joint, "free"))
        else:
            self._broken.add(joint)
            self._plant.set_joint_mode(joint, breakage.mode, breakage.angle_rad)

    def encoder_counts(self) -> Iterable[SupportsInt | None]:
        counts: Iterable[SupportsInt | None] = self._plant.encoder_counts()
        return counts

    def pose(self) -> tuple[float, float, float, float] | None:
        pose: tuple[float, float, float, float] | None = self._plant.pose()
        return pose
