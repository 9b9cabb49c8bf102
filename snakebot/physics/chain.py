"""One robot in real time: a chain that is stepped with whatever its joints do next."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from snakebot.arrays import Floats, Ints
from snakebot.errors import BadInputError
from snakebot.physics import kernel, rosenbrock
from snakebot.physics.compiled import in_place
from snakebot.physics.kernel import FREE, PRESCRIBED, TORQUE
from snakebot.physics.model import STANDARD_GRAVITY_M_S2, ChainModel

if TYPE_CHECKING:
    from collections.abc import Sequence


__all__ = ["FREE", "PRESCRIBED", "TORQUE", "Chain", "Drive"]


@dataclass
class Drive:
    """What the joints do during one step. Arrays of shape (joints,), to be written in place step by step.

    Attributes:
        kind: PRESCRIBED (angle is imposed, the torque follows), TORQUE (torque is imposed) or FREE (swings).
        angle_rad, rate_rad_s: of PRESCRIBED joints at the *end* of the step. The acceleration over the step is
            the change of rate over its length, so that no momentum is made up where a rate jumps.
        torque_nm: on TORQUE joints, constant over the step.
    """

    kind: Ints
    angle_rad: Floats
    rate_rad_s: Floats
    torque_nm: Floats

    @classmethod
    def at_rest(cls, joints: int, angle_rad: Sequence[float] | Floats | float = 0.0) -> Drive:
        """All joints held at an angle."""
        angle = np.broadcast_to(np.asarray(angle_rad, dtype=np.float64), (joints,)).copy()
        return cls(
            np.full(joints, PRESCRIBED, dtype=np.int64),
            angle,
            np.zeros(joints),
            np.zeros(joints),
        )


class Chain:
    """Online stepper of one chain; starts straight, at rest, at the origin.

    After each ``step`` (and ``reset``) the attributes hold the new state; they are the chain's own arrays, to be
    read and copied, not written.

    Attributes:
        t_s: time since the last reset.
        joint_angle_rad, joint_rate_rad_s: (joints,).
        joint_torque_nm: (joints,), mean over the last step.
        com_m, com_velocity_m_s: (2,), centre of mass.
        heading_rad, heading_rate_rad_s: mean link angle.
        power_in_w: sum of torque times joint rate, mean over the last step.
        power_dissipated_w: taken by the ground, at the start of the last step.
    """

    def __init__(self, model: ChainModel, dt_s: float) -> None:
        """
        Raises:
            BadInputError: the step is not above zero.
        """
        if not (math.isfinite(dt_s) and dt_s > 0):
            raise BadInputError(f"physics: the time step must be above zero, it is {dt_s} s")
        self.model = model
        self.dt_s = dt_s
        k = model.joints
        self._slope = STANDARD_GRAVITY_M_S2 * math.sin(model.slope_rad)
        self._base = np.zeros(6)
        self._work, self._stage = rosenbrock.workspace(model.links)
        self._power = np.zeros(2)
        self.joint_angle_rad = np.zeros(k)
        self.joint_rate_rad_s = np.zeros(k)
        self.joint_torque_nm = np.zeros(k)
        self.com_m = self._base[0:2]
        self.com_velocity_m_s = self._base[3:5]
        self.t_s = 0.0

    def reset(
        self,
        joint_angle_rad: Sequence[float] | Floats | float = 0.0,
        x_m: float = 0.0,
        y_m: float = 0.0,
        heading_rad: float = 0.0,
    ) -> None:
        """Put the chain down at rest: centre of mass at (x_m, y_m), mean link angle ``heading_rad``.

        Raises:
            BadInputError: the number of angles is not the number of joints.
        """
        angle = np.asarray(joint_angle_rad, dtype=np.float64)
        if angle.shape not in ((), (self.model.joints,)):
            raise BadInputError(f"physics: {angle.shape} angles for {self.model.joints} joints")
        self.joint_angle_rad[:] = angle
        self.joint_rate_rad_s[:] = 0.0
        self.joint_torque_nm[:] = 0.0
        self._base[:] = (x_m, y_m, heading_rad, 0.0, 0.0, 0.0)
        self._power[:] = 0.0
        self.t_s = 0.0

    def step(self, drive: Drive) -> None:
        """Move on by ``dt_s``."""
        _online_step(
            self.model.packed, self._slope, self.model.eps, self.dt_s, drive.kind, self._base,
            self.joint_angle_rad, self.joint_rate_rad_s, drive.angle_rad, drive.rate_rad_s, drive.torque_nm,
            self._work, self._stage, self.joint_torque_nm, self._power,
        )  # fmt: skip
        self.t_s += self.dt_s

    @property
    def heading_rad(self) -> float:
        return float(self._base[2])

    @property
    def heading_rate_rad_s(self) -> float:
        return float(self._base[5])

    @property
    def power_in_w(self) -> float:
        return float(self._power[0])

    @property
    def power_dissipated_w(self) -> float:
        return float(self._power[1])

    def link_positions_m(self) -> Floats:
        """Centres of the links, (links, 2)."""
        return self._link_rows(kernel.X, kernel.Y) + self.com_m

    def link_velocities_m_s(self) -> Floats:
        """Velocities of the links' centres, (links, 2)."""
        return self._link_rows(kernel.VX, kernel.VY)

    def energy_j(self) -> float:
        """Kinetic energy and, on a slope, the potential energy of the centre of mass."""
        velocity, rate = self.link_velocities_m_s(), self._work[kernel.OMEGA]
        m, J = self.model.mass, self.model.inertia
        kinetic = 0.5 * np.sum(m * np.sum(velocity**2, axis=1)) + 0.5 * np.sum(J * rate**2)
        return float(kinetic + np.sum(m) * self._slope * self.com_m[0])

    def _link_rows(self, first: int, second: int) -> Floats:
        no_acceleration = np.zeros(self.model.joints)
        kernel.kinematics(
            self.model.packed,
            self._base,
            self.joint_angle_rad,
            self.joint_rate_rad_s,
            no_acceleration,
            self._work,
        )
        return np.stack((self._work[first], self._work[second]), axis=1)


@in_place
def _online_step(
    links: Any, slope: float, eps: float, h: float, kind: Any, base: Any, phi: Any, dphi: Any, phi_end: Any,
    dphi_end: Any, torque_in: Any, work: Any, stage: Any, torque_out: Any, power: Any,
) -> None:  # fmt: skip
    n = links.shape[1]
    acc, torque, nothing = stage[7], stage[8], stage[9]
    for j in range(n - 1):
        acc[j] = (dphi_end[j] - dphi[j]) / h if kind[j] == PRESCRIBED else 0.0
        torque[j] = torque_in[j] if kind[j] == TORQUE else 0.0
    rosenbrock.step(
        links, slope, eps, h, kind, base, phi, dphi, acc, phi_end, dphi_end, acc, torque, nothing, nothing, work, stage,
        torque_out, power,
    )  # fmt: skip
