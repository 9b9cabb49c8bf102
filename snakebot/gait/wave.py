"""The serpentine wave: one sinusoid a joint, each a constant phase ahead of the joint before (eq. 27)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from snakebot.arrays import Floats
from snakebot.errors import BadInputError


@dataclass(frozen=True, slots=True)
class Gait:
    """phi_i(t) = offset + alpha sin(omega t + (i - 1) beta), i from 1 at the tail (eq. 27).

    With a positive beta the wave runs from the last joint to the first and drives the robot towards its last link, the
    head.

    ``offset_rad`` is not in the paper: a constant bend of all joints, which steers the robot. Nor are ``shares``: the
    amplitude of each joint, from the tail on, as a share of alpha, from 0 to 1; none: alpha everywhere. So alpha is
    the largest amplitude, and a wave that keeps limits with alpha everywhere keeps them with any shares.

    Raises:
        BadInputError: a value is not a finite number, alpha or omega is negative, or a share is not from 0 to 1.
    """

    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    offset_rad: float = 0.0
    shares: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in ("alpha_rad", "beta_rad", "omega_rad_s", "offset_rad"):
            value = getattr(self, name)
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

        for share in self.shares:
            if not 0 <= share <= 1:
                raise BadInputError(
                    f"gait: amplitudes hold {share:g}; each is a share of alpha, from 0 to 1, as in 1,0.9,0.8"
                )

    @classmethod
    def from_degrees(
        cls,
        alpha: float,
        beta: float,
        omega_rad_s: float,
        offset: float = 0.0,
        *,
        shares: tuple[float, ...] = (),
    ) -> Gait:
        """A gait as users give it: angles in degrees, frequency in rad/s."""
        return cls(math.radians(alpha), math.radians(beta), omega_rad_s, math.radians(offset), shares)

    def of_joints(self, joints: int) -> tuple[float, ...]:
        """The share of alpha of each joint.

        Raises:
            BadInputError: the gait is one of another number of joints.
        """
        if self.shares and len(self.shares) != joints:
            raise BadInputError(f"gait: {len(self.shares)} amplitudes, and the robot has {joints} joints")
        return self.shares or (1.0,) * joints

    def plain(self) -> dict[str, float | list[float]]:
        """Its numbers; shares where there are any."""
        numbers: dict[str, float | list[float]] = {
            "alpha_rad": self.alpha_rad,
            "beta_rad": self.beta_rad,
            "omega_rad_s": self.omega_rad_s,
            "offset_rad": self.offset_rad,
        }
        return {**numbers, "shares": list(self.shares)} if self.shares else numbers

    def even(self) -> Gait:
        """This gait, for what knows amplitudes that are the same in all joints.

        Raises:
            BadInputError: they are not.
        """
        if any(share != 1 for share in self.shares):
            raise BadInputError(f"a gait with amplitudes {self.shares_text}: studies take equal ones only")
        return self

    @property
    def shares_text(self) -> str:
        """As after ``--amplitudes``: ``1,0.9,0.8``; empty where all joints have alpha."""
        return ",".join(f"{share:g}" for share in self.shares)

    @property
    def shares_option(self) -> str:
        """The option of ``snakebot run`` for amplitudes that differ, a space before it; empty where they do not."""
        return f" --amplitudes {self.shares_text}" if self.shares else ""

    @property
    def period_s(self) -> float:
        """Seconds a cycle; infinite at omega = 0."""
        return 2 * math.pi / self.omega_rad_s if self.omega_rad_s > 0 else math.inf

    def angles(self, t_s: ArrayLike, joints: int) -> Floats:
        """Joint angles in rad, shape (T, joints), at the times ``t_s`` of shape (T,)."""
        t = np.atleast_1d(np.asarray(t_s, dtype=np.float64))
        phase = self.omega_rad_s * t[:, None] + self.beta_rad * np.arange(joints)
        return self.offset_rad + self.alpha_rad * np.array(self.of_joints(joints)) * np.sin(phase)

    def __str__(self) -> str:
        text = (
            f"alpha {math.degrees(self.alpha_rad):g} deg, beta {math.degrees(self.beta_rad):g} deg, "
            f"omega {self.omega_rad_s:g} rad/s"
        )
        text += f", offset {math.degrees(self.offset_rad):g} deg" if self.offset_rad else ""
        return text + (f", amplitudes {self.shares_text}" if self.shares else "")


def parse_shares(text: str) -> tuple[float, ...]:
    """``1,0.9,0.8``: a share of alpha for each joint, from the tail on.

    Raises:
        BadInputError: not numbers.
    """
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise BadInputError(
            f"--amplitudes {text!r}: a share of alpha for each joint, from the tail on, as in 1,0.9,0.8,0.9,1"
        ) from None
