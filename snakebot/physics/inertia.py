"""What one joint of a chain feels of the rest of it: inertia against its own motion, the other joints held."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats

if TYPE_CHECKING:
    from snakebot.physics.model import ChainModel


def felt_inertia_kg_m2(model: ChainModel) -> Floats:
    """(joints,) torque per angular acceleration at the straight pose, the body floating."""
    n = model.links
    rotation = np.hstack(
        [np.zeros((n, 1)), np.tril(np.ones((n, n)))]
    )  # of each link, from (y, first angle, joint angles)
    lateral = np.zeros((n, n + 1))
    lateral[:, 0] = 1.0
    for i in range(1, n):
        turn = model.half_length[i - 1] * rotation[i - 1] + model.half_length[i] * rotation[i]
        lateral[i] = lateral[i - 1] + turn
    mass = lateral.T @ (model.mass[:, None] * lateral) + rotation.T @ (model.inertia[:, None] * rotation)
    base, cross, joints = mass[:2, :2], mass[:2, 2:], mass[2:, 2:]
    felt: Floats = np.diag(joints - cross.T @ np.linalg.solve(base, cross)).copy()
    return felt
