"""What the body effects change, gathered before one chain model is built from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats

if TYPE_CHECKING:
    from snakebot.physics.model import ChainModel
    from snakebot.robot import Body


@dataclass
class Ground:
    """Changes to a body of n links, neutral at first.

    Attributes:
        ct_scale, cn_scale, ct0_scale, cn0_scale: factors on the friction coefficients of (25).
        added_mass_kg, extra_drag_n: (n,) payload and extra Coulomb friction along each link.
        slope_deg: added to the body's own.
    """

    body: Body
    ct_scale: float = 1.0
    cn_scale: float = 1.0
    ct0_scale: float = 1.0
    cn0_scale: float = 1.0
    slope_deg: float = 0.0

    def __post_init__(self) -> None:
        self.added_mass_kg: Floats = np.zeros(self.body.links)
        self.extra_drag_n: Floats = np.zeros(self.body.links)

    def model(self) -> ChainModel:
        from snakebot.physics.model import ChainModel

        friction = self.body.friction
        scaled = {
            key: _times(getattr(friction, key), getattr(self, f"{key}_scale"))
            for key in ("ct", "cn", "ct0", "cn0")
        }
        body = self.body.model_copy(
            update={
                "friction": friction.model_copy(update=scaled),
                "slope_deg": self.body.slope_deg + self.slope_deg,
            }
        )
        return ChainModel.from_body(body, self.added_mass_kg, self.extra_drag_n)


def _times(value: float | tuple[float, ...], factor: float) -> float | tuple[float, ...]:
    return tuple(v * factor for v in value) if isinstance(value, tuple) else value * factor
