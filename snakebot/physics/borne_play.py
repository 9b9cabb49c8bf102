"""Play that the load takes up, under torques that are known: no body has to be simulated for it."""

from __future__ import annotations

from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.physics.compiled import jit

# In which a joint crosses its play once the torque turns. Measured on the four described robots with play of 0.3 and
# 1 deg: 0.33 of what it changes in the angles is left against the whole body simulated; as much with 0.06 and 0.08 s,
# 0.41 with 0.02 s. Play that friction holds in place leaves 1.2 of it: more than none.
CROSSING_S = 0.05


def borne_side(t_s: Floats, load_nm: Floats) -> Floats:
    """(T, joints) on which side of its play each joint lies, -1 to 1: the one that bears its torque (T, joints)."""
    side = np.zeros_like(load_nm)
    _cross(np.ascontiguousarray(t_s), np.ascontiguousarray(load_nm), side)
    return side


@jit
def _cross(t: Any, load: Any, side: Any) -> None:
    for row in range(1, t.size):
        stays = np.exp(-(t[row] - t[row - 1]) / CROSSING_S)
        for j in range(load.shape[1]):
            there = -np.sign(load[row, j])
            side[row, j] = there + stays * (side[row - 1, j] - there)
