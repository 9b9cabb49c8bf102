"""The motion over ground that given joint angles make: measured ones, or ideal ones."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.physics.imposed import impose, scratch
from snakebot.physics.model import STANDARD_GRAVITY_M_S2, ChainModel

MAX_STEP_S = 5e-3  # of the chain (tests/physics/test_physics_convergence.py)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A simulated motion at T times.

    Attributes:
        t_s: (T,).
        joint_angle_rad, joint_rate_rad_s: (T, joints).
        com_m, com_velocity_m_s: (T, 2), centre of mass.
        heading_rad: (T,), mean link angle.
        joint_torque_nm: (T, joints), power_in_w, power_dissipated_w: (T,); means over the time since the sample before.
    """

    t_s: Floats
    joint_angle_rad: Floats
    joint_rate_rad_s: Floats
    joint_torque_nm: Floats
    com_m: Floats
    com_velocity_m_s: Floats
    heading_rad: Floats
    power_in_w: Floats
    power_dissipated_w: Floats

    def speed_m_s(self, from_s: float = -math.inf, to_s: float = math.inf) -> float:
        """Way of the centre of mass over a span of time, over its length.

        Raises:
            BadInputError: the span holds fewer than two samples.
        """
        a, b = self._span(from_s, to_s)
        way = self.com_m[b] - self.com_m[a]
        return float(np.hypot(*way) / (self.t_s[b] - self.t_s[a]))

    def forward_speed_m_s(self, from_s: float = -math.inf, to_s: float = math.inf) -> float:
        """The same way along the mean heading over that span: negative where the robot goes backwards."""
        a, b = self._span(from_s, to_s)
        span = self.t_s[b] - self.t_s[a]
        heading = np.trapezoid(self.heading_rad[a : b + 1], self.t_s[a : b + 1]) / span
        way = self.com_m[b] - self.com_m[a]
        return float((way[0] * math.cos(heading) + way[1] * math.sin(heading)) / span)

    def _span(self, from_s: float, to_s: float) -> tuple[int, int]:
        rows = np.flatnonzero((self.t_s >= from_s) & (self.t_s <= to_s))
        if rows.size < 2:
            raise BadInputError(f"physics: no motion between {from_s} s and {to_s} s to take a speed from")
        return int(rows[0]), int(rows[-1])


def replay(
    model: ChainModel,
    t_s: npt.ArrayLike,
    joint_angle_rad: npt.ArrayLike,
    *,
    x_m: float = 0.0,
    y_m: float = 0.0,
    heading_rad: float = 0.0,
    max_step_s: float = MAX_STEP_S,
) -> Trajectory:
    """Impose joint angles over time and simulate the rest, from rest.

    Between samples the angles follow a cubic Hermite curve with the rates of central differences: smooth, without
    overshoot to speak of, and local, so that one bad sample spoils only its neighbours.

    Args:
        model: the chain.
        t_s: (T,) rising times, not necessarily uniform.
        joint_angle_rad: (T, joints), without gaps (no NaN).
        x_m, y_m, heading_rad: start of the centre of mass and mean link angle.
        max_step_s: samples that lie further apart are bridged in several steps.

    Raises:
        BadInputError: shapes that do not fit, times that do not rise, or angles that are not numbers.
    """
    t, angle, rate = _checked(model, t_s, joint_angle_rad, max_step_s)
    start = (x_m, y_m, heading_rad)
    base, torque, power = _imposed(model, t, angle, rate, start, max_step_s, forces=True)
    return Trajectory(
        t, angle, rate, torque, base[:, 0:2], base[:, 3:5], base[:, 2], power[:, 0], power[:, 1]
    )  # fmt: skip


def replayed_pose(
    model: ChainModel,
    t_s: npt.ArrayLike,
    joint_angle_rad: npt.ArrayLike,
    start: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> Floats:
    """Centre of mass and mean link angle alone, (T, 3), from such a ``start``: as ``replay`` has them, and sooner."""
    t, angle, rate = _checked(model, t_s, joint_angle_rad, MAX_STEP_S)
    base, _, _ = _imposed(model, t, angle, rate, start, MAX_STEP_S, forces=False)
    return np.ascontiguousarray(base[:, :3])


def _imposed(
    model: ChainModel,
    t: Floats,
    angle: Floats,
    rate: Floats,
    start: npt.ArrayLike,
    max_step_s: float,
    *,
    forces: bool,
) -> tuple[Floats, Floats, Floats]:
    """(T, 6) pose and its rates, (T, joints) torques and (T, 2) powers, which stay zero without ``forces``."""
    base, torque, power = np.zeros((t.size, 6)), np.zeros(angle.shape), np.zeros((t.size, 2))
    base[0, :3] = start
    slope = STANDARD_GRAVITY_M_S2 * math.sin(model.slope_rad)
    impose(
        model.packed, slope, model.eps, t, angle, rate, max_step_s, base, forces, torque, power,
        *scratch(model.links),
    )  # fmt: skip
    return base, torque, power


def _checked(
    model: ChainModel, t_s: npt.ArrayLike, joint_angle_rad: npt.ArrayLike, max_step_s: float
) -> tuple[Floats, Floats, Floats]:
    """Times, joint angles and their rates as the kernel takes them: writeable, or it would be compiled once more."""
    t = np.require(t_s, np.float64, ("C", "W"))
    angle = np.require(joint_angle_rad, np.float64, ("C", "W"))
    if t.ndim != 1 or t.size < 2 or angle.shape != (t.size, model.joints):
        raise BadInputError(
            f"physics: replay needs times (T,) and angles (T, {model.joints}), T at least 2; "
            f"found {t.shape} and {angle.shape}"
        )
    if not np.all(np.isfinite(t)) or np.any(np.diff(t) <= 0):
        raise BadInputError("physics: the times of a replay must rise")
    if not np.all(np.isfinite(angle)):
        row, joint = np.argwhere(~np.isfinite(angle))[0]
        raise BadInputError(
            f"physics: joint {joint + 1} has no angle at sample {row}; fill gaps before a replay"
        )
    if not max_step_s > 0:
        raise BadInputError(f"physics: the time step must be above zero, it is {max_step_s}")
    return t, angle, np.gradient(angle, t, axis=0, edge_order=2 if t.size > 2 else 1)
