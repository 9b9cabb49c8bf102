"""What one joint of a chain feels of the rest of it: inertia and drag against its own motion, the others held.

Both are taken at the straight pose with the body floating. They only shape how a joint falls behind its torque
limit; the load itself comes from the full dynamics.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from snakebot.physics.model import ChainModel

Vector = npt.NDArray[np.float64]


def felt_inertia_kg_m2(model: ChainModel) -> Vector:
    """(joints,) torque per angular acceleration."""
    lateral, rotation = _lateral_motion(model)
    return _felt(
        lateral.T @ (model.mass[:, None] * lateral) + rotation.T @ (model.inertia[:, None] * rotation)
    )


def felt_drag_nm_s(model: ChainModel) -> Vector:
    """(joints,) torque per angular rate against the viscous ground friction; 0 where the ground does not resist."""
    lateral, rotation = _lateral_motion(model)
    drag = lateral.T @ (model.cn[:, None] * lateral) + rotation.T @ (
        model.rotational_drag[:, None] * rotation
    )
    return _felt(drag)


def _lateral_motion(model: ChainModel) -> tuple[Vector, Vector]:
    """From (y, angle of link 1, joint angles) to lateral shifts and rotations of the links, at the straight pose."""
    n = model.links
    rotation = np.tril(np.ones((n, n)))  # link i turns by the first angle and all joints before it
    rotation = np.hstack([np.zeros((n, 1)), rotation])
    lateral = np.zeros((n, n + 1))
    lateral[:, 0] = 1.0
    for i in range(1, n):
        lateral[i] = (
            lateral[i - 1] + model.half_length[i - 1] * rotation[i - 1] + model.half_length[i] * rotation[i]
        )
    return lateral, rotation


def _felt(matrix: Vector) -> Vector:
    """Diagonal of the joints' block with the floating body (first two coordinates) eliminated."""
    base, cross, joints = matrix[:2, :2], matrix[:2, 2:], matrix[2:, 2:]
    left = joints - cross.T @ np.linalg.pinv(base) @ cross
    felt: Vector = np.maximum(np.diag(left), 0.0).copy()
    return felt
