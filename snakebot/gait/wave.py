"""The serpentine wave: one sinusoid a joint, each a constant phase ahead of the joint before (eq. 27)."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from snakebot.errors import BadInputError


@dataclass(frozen=True, slots=True)
class Gait:
    """phi_i(t) = offset + alpha sin(omega t + (i - 1) beta), i from 1 at the head (eq. 27).

    ``offset_rad`` is not in the paper: a constant bend of all joints, which steers the robot.

    Raises:
        BadInputError: a value is not a finite number, or alpha or omega is negative.
    """

    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    offset_rad: float = 0.0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not math.isfinite(value):
                raise BadInputError(f"gait: {name} is {value}; it must be a finite number")
        if self.alpha_rad < 0:
            raise BadInputError(
                f"gait: alpha is {math.degrees(self.alpha_rad):g} deg; an amplitude is zero or more"
            )
        if self.omega_rad_s < 0:
            raise BadInputError(
                f"gait: omega is {self.omega_rad_s:g} rad/s; it is zero or more (beta's sign sets the direction)"
            )

    @classmethod
    def from_degrees(cls, alpha: float, beta: float, omega_rad_s: float, offset: float = 0.0) -> Gait:
        """A gait as users give it: angles in degrees, frequency in rad/s."""
        return cls(math.radians(alpha), math.radians(beta), omega_rad_s, math.radians(offset))

    @property
    def period_s(self) -> float:
        """Seconds a cycle; infinite at omega = 0."""
        return 2 * math.pi / self.omega_rad_s if self.omega_rad_s > 0 else math.inf

    def angles(self, t_s: ArrayLike, joints: int) -> NDArray[np.float64]:
        """Joint angles in rad, shape (T, joints), at the times ``t_s`` of shape (T,)."""
        t = np.atleast_1d(np.asarray(t_s, dtype=np.float64))
        phase = self.omega_rad_s * t[:, None] + self.beta_rad * np.arange(joints)
        return self.offset_rad + self.alpha_rad * np.sin(phase)

    def __str__(self) -> str:
        text = (
            f"alpha {math.degrees(self.alpha_rad):g} deg, beta {math.degrees(self.beta_rad):g} deg, "
            f"omega {self.omega_rad_s:g} rad/s"
        )
        return text + (f", offset {math.degrees(self.offset_rad):g} deg" if self.offset_rad else "")
