"""The motion over ground that given joint angles make: measured ones, or ideal ones."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.physics import rosenbrock
from snakebot.physics.compiled import jit
from snakebot.physics.kernel import PRESCRIBED
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
    t = np.ascontiguousarray(t_s, dtype=np.float64)
    angle = np.ascontiguousarray(joint_angle_rad, dtype=np.float64)
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
    rate = np.gradient(angle, t, axis=0, edge_order=2 if t.size > 2 else 1)
    size, k = angle.shape
    torque = np.zeros((size, k))
    base = np.zeros((size, 6))
    base[0, :3] = (x_m, y_m, heading_rad)
    power = np.zeros((size, 2))
    _replay(
        model.packed, STANDARD_GRAVITY_M_S2 * math.sin(model.slope_rad), model.eps, t, angle, rate, max_step_s, base,
        torque, power,
    )  # fmt: skip
    return Trajectory(
        t, angle, rate, torque, base[:, 0:2], base[:, 3:5], base[:, 2], power[:, 0], power[:, 1]
    )  # fmt: skip


@jit
def _hermite(u: float, h: float, a: Any, b: Any, da: Any, db: Any, phi: Any, dphi: Any, acc: Any) -> None:
    for j in range(a.size):
        step = b[j] - a[j]
        c2 = 3 * step - h * (2 * da[j] + db[j])
        c3 = -2 * step + h * (da[j] + db[j])
        phi[j] = a[j] + u * (h * da[j] + u * (c2 + u * c3))
        dphi[j] = (h * da[j] + u * (2 * c2 + 3 * u * c3)) / h
        acc[j] = (2 * c2 + 6 * u * c3) / (h * h)


@jit
def _replay(
    links: Any, slope: float, eps: float, t: Any, angle: Any, rate: Any, max_step: float, base: Any, torque: Any,
    power: Any,
) -> None:  # fmt: skip
    n = links.shape[1]
    work, stage = rosenbrock.workspace(n)
    kind = np.full(n - 1, PRESCRIBED)
    state = base[0].copy()
    phi, dphi, acc = np.zeros(n - 1), np.zeros(n - 1), np.zeros(n - 1)
    phi_end, dphi_end, acc_end = np.zeros(n - 1), np.zeros(n - 1), np.zeros(n - 1)
    nothing, mean_torque, part_power = np.zeros(n - 1), np.zeros(n - 1), np.zeros(2)
    for i in range(1, t.size):
        span = t[i] - t[i - 1]
        parts = math.ceil(span / max_step * (1 - 1e-9))
        _hermite(0.0, span, angle[i - 1], angle[i], rate[i - 1], rate[i], phi, dphi, acc)
        for part in range(parts):
            u = (part + 1) / parts
            _hermite(u, span, angle[i - 1], angle[i], rate[i - 1], rate[i], phi_end, dphi_end, acc_end)
            rosenbrock.step(
                links, slope, eps, span / parts, kind, state, phi, dphi, acc, phi_end, dphi_end, acc_end, nothing,
                nothing, nothing, work, stage, mean_torque, part_power,
            )  # fmt: skip
            acc[:] = acc_end
            power[i] += part_power / parts
            torque[i] += mean_torque / parts
        base[i] = state
    power[0] = power[1]
    torque[0] = torque[1]
