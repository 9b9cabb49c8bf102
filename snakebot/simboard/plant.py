"""What a board needs of the joints behind it. ``snakebot.effects.Plant`` is the one that it gets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol


class JointPlant(Protocol):
    """Servos, joints, body and encoders, on true time (s). Starts without power: all joints free."""

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        """A set-point for all joints leaves the board."""
        ...

    def set_joint_mode(self, joint: int, mode: str, hold_rad: float | None = None) -> None:
        """``active`` follows set-points, ``free`` has no power; joints count from 0."""
        ...

    def advance(self, t_s: float) -> None:
        """Let the world go on until ``t_s``."""
        ...

    def encoder_counts(self) -> Sequence[int | None]:
        """What the encoders say now; None where one gives no reading."""
        ...

    def pose(self) -> tuple[float, float, float, float] | None:
        """Centre of mass x, y (m), mean heading (rad, unwrapped), speed (m/s); None without a body."""
        ...
