"""What the dynamics know of a robot: one number a link, SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.errors import BadInputError
from snakebot.robot import MAX_LINKS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from snakebot.robot import Body


STANDARD_GRAVITY_M_S2 = 9.80665  # the standard value (CGPM 1901)
DEFAULT_EPS_M_S = 1e-3  # speed below which dry friction is smoothed; chosen, a hundredth of a slow gait's
MIN_LINKS = 2  # one joint


@dataclass(frozen=True, eq=False)
class ChainModel:
    """A planar chain of n rigid links on friction ground; every array is float64 of shape (n,).

    Attributes:
        mass: mass of each link, kg.
        half_length: half of each link's length, m: l of the paper.
        inertia: moment of inertia about the link's centre, kg m^2.
        ct, cn: viscous coefficients along and across the link, N s/m (22).
        ct0, cn0: Coulomb friction along and across the link, N (25).
        contact: 1 where the link lies on the ground and is braked in rotation (11)-(12), 0 where it has wheels (21).
        slope_rad: the ground rises along +x by this angle.
        eps: speed over which the regularised sign, tanh(v / eps), of the Coulomb term turns, m/s.
    """

    mass: Floats
    half_length: Floats
    inertia: Floats
    ct: Floats
    cn: Floats
    ct0: Floats
    cn0: Floats
    contact: Floats
    slope_rad: float = 0.0
    eps: float = DEFAULT_EPS_M_S
    packed: Floats = field(init=False, repr=False)  # (rows, n) as the compiled kernels read it

    def __post_init__(self) -> None:
        n = np.size(self.mass)
        if not MIN_LINKS <= n <= MAX_LINKS:
            raise BadInputError(f"physics: a chain has {MIN_LINKS} to {MAX_LINKS} links, this one has {n}")
        for name in ("mass", "half_length", "inertia", "ct", "cn", "ct0", "cn0", "contact"):
            given = np.asarray(getattr(self, name), dtype=np.float64)
            if given.ndim > 1 or given.size not in (1, n):
                raise BadInputError(f"physics: {name} has shape {given.shape} for {n} links")
            value = np.ascontiguousarray(np.broadcast_to(given, (n,))).copy()
            positive = name in ("mass", "half_length", "inertia")
            if not np.all(np.isfinite(value)) or np.any(value < 0) or (positive and np.any(value == 0)):
                raise BadInputError(
                    f"physics: {name} must be {'above zero' if positive else 'zero or more'}: {value}"
                )
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if not (math.isfinite(self.eps) and self.eps > 0):
            raise BadInputError(f"physics: eps must be above zero, it is {self.eps}")
        if not math.isfinite(self.slope_rad):
            raise BadInputError(f"physics: slope_rad must be a finite number, it is {self.slope_rad}")
        packed = np.stack(
            [
                self.mass,
                self.half_length,
                self.inertia,
                self.ct,
                self.cn,
                self.ct0,
                self.cn0,
                self.rotational_drag,
            ]
        )
        packed.setflags(write=False)
        object.__setattr__(self, "packed", packed)

    @classmethod
    def from_body(
        cls,
        body: Body,
        added_mass_kg: float | Sequence[float] | Floats | None = None,
        extra_drag_n: float | Sequence[float] | Floats | None = None,
        *,
        eps: float = DEFAULT_EPS_M_S,
    ) -> ChainModel:
        """The model of a robot's body.

        Args:
            body: the ``body`` of a robot description.
            added_mass_kg: payload at the centre of each link: one number, or one a link. It adds no inertia.
            extra_drag_n: Coulomb friction on top of ``ct0``: one number, or one a link (a wheel that rubs).
            eps: see the class.

        Raises:
            BadInputError: a number or a shape that no robot has.
        """
        n, half = body.links, body.half_length_m
        link_mass = _per_link(body.link_mass_kg, n, "link_mass_kg")
        friction = body.friction
        return cls(
            mass=link_mass + _per_link(added_mass_kg, n, "added_mass_kg"),
            half_length=_per_link(half, n, "half_length_m"),
            inertia=link_mass * half**2 / 3,
            ct=_per_link(friction.ct, n, "ct"),
            cn=_per_link(friction.cn, n, "cn"),
            ct0=_per_link(friction.ct0, n, "ct0") + _per_link(extra_drag_n, n, "extra_drag_n"),
            cn0=_per_link(friction.cn0, n, "cn0"),
            contact=_per_link(1.0 if friction.contact == "distributed" else 0.0, n, "contact"),
            slope_rad=math.radians(body.slope_deg),
            eps=eps,
        )

    @property
    def links(self) -> int:
        return int(self.mass.size)

    @property
    def joints(self) -> int:
        return self.links - 1

    @property
    def rotational_drag(self) -> Floats:
        """Friction torque over angular speed of each link, N m s.

        The printed c_n J / m (11)-(12) is the integral of c_n s^2 / (2 l) over the length of a uniform link,
        c_n l^2 / 3. In this form a payload does not change it.
        """
        drag: Floats = self.contact * self.cn * self.half_length**2 / 3
        return drag

    def with_eps(self, eps: float) -> ChainModel:
        return replace(self, eps=eps)


def _per_link(value: float | Sequence[float] | Floats | None, links: int, name: str) -> Floats:
    given = np.asarray(0.0 if value is None else value, dtype=np.float64)
    if given.shape not in ((), (links,)):
        raise BadInputError(
            f"physics: {name} has shape {given.shape}; give one number, or one for each of {links} links"
        )
    return np.broadcast_to(given, (links,)).copy()
