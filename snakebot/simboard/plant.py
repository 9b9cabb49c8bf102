"""What a board needs of the joints behind it. ``snakebot.effects.Plant`` is the one that it gets."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal, Protocol, SupportsInt


class JointPlant(Protocol):
    """Servos, joints, body and encoders. Its time starts at zero with the first reset of the board."""

    @property
    def clock_ppm(self) -> float:
        """By how much its effects make the board's clock run fast, on top of the board's own drift."""
        ...

    def command(self, t_s: float, setpoint_rad: Sequence[float]) -> None:
        """A set-point for all joints leaves the board."""
        ...

    def set_joint_mode(self, joint: int, mode: Literal["active", "free"], /) -> None:
        """``active`` follows set-points from where it is, ``free`` has no power; joints count from 1."""
        ...

    def advance(self, t_s: float) -> None:
        """Let the world go on until ``t_s``."""
        ...

    def encoder_counts(self) -> Iterable[SupportsInt | None]:
        """What the encoders say now; None where one gives no reading."""
        ...

    def pose(self) -> tuple[float, float, float, float] | None:
        """Centre of mass x, y (m), mean heading (rad, unwrapped), speed (m/s); None without a body."""
        ...
