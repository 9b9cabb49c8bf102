"""A chain whose joints all follow given angles: the sums over its links against the general chain, step by step."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.physics import ChainModel, replay, replayed_pose
from snakebot.physics.kernel import PRESCRIBED
from snakebot.physics.model import STANDARD_GRAVITY_M_S2
from snakebot.physics.rosenbrock import step, workspace
from snakebot.robot import load_robot

STEP_S = 0.005  # between samples: no more than one step of the chain each
START = (0.3, -0.2, 1.3)  # m, m, rad


def uneven(robot: str, *, slope_rad: float, dry: float, rng: np.random.Generator) -> ChainModel:
    """A robot no two links of which are alike; ``dry``: share of its Coulomb friction."""
    body = load_robot(robot).body
    assert body is not None
    model = ChainModel.from_body(body)
    factors = rng.uniform(0.7, 1.3, size=(8, model.links))
    names = ("mass", "half_length", "inertia", "ct", "cn", "contact")
    changed = {name: getattr(model, name) * factor for name, factor in zip(names, factors, strict=False)}
    coulomb_n = rng.uniform(0.0, 1.0, size=(2, model.links)) * dry
    return replace(model, **changed, ct0=coulomb_n[0], cn0=coulomb_n[1], slope_rad=slope_rad)


def step_by_step(model: ChainModel, t: Floats, angle: Floats) -> tuple[Floats, Floats, Floats]:
    """Pose (T, 3), torque (T, joints) and power (T, 2) by the general chain, along the same cubics."""
    n, k = model.links, model.joints
    work, stage = workspace(n)
    kind, none = np.full(k, PRESCRIBED), np.zeros(k)
    rate = np.gradient(angle, t, axis=0, edge_order=2)
    base = np.array([*START, 0.0, 0.0, 0.0])
    pose, torque, power = np.zeros((t.size, 3)), np.zeros((t.size, k)), np.zeros((t.size, 2))
    pose[0] = START
    for i in range(1, t.size):
        h = t[i] - t[i - 1]
        way = angle[i] - angle[i - 1]
        c2 = 3 * way - h * (2 * rate[i - 1] + rate[i])
        c3 = -2 * way + h * (rate[i - 1] + rate[i])
        phi, dphi = angle[i - 1].copy(), rate[i - 1].copy()
        slope = STANDARD_GRAVITY_M_S2 * math.sin(model.slope_rad)
        step(
            model.packed, slope, model.eps, h, kind, base, phi, dphi, 2 * c2 / h**2, angle[i], rate[i],
            (2 * c2 + 6 * c3) / h**2, none, none, none, work, stage, torque[i], power[i],
        )  # fmt: skip
        pose[i] = base[:3]
    torque[0], power[0] = torque[1], power[1]
    return pose, torque, power


@pytest.mark.parametrize("slope_rad", [0.0, -0.2])
@pytest.mark.parametrize("dry", [0.0, 0.5])
@pytest.mark.parametrize("robot", ["saito_wheeled", "penn_state"])
def test_moves_and_bears_what_the_general_chain_does(robot: str, dry: float, slope_rad: float) -> None:
    rng = np.random.default_rng(5)
    model = uneven(robot, slope_rad=slope_rad, dry=dry, rng=rng)
    t: Floats = np.linspace(0.0, 400 * STEP_S * rng.uniform(0.7, 1.0), 401)
    angle = 0.7 * np.sin(6 * t[:, None] + rng.uniform(0, 6, model.joints)) * np.minimum(2 * t, 1)[:, None]
    pose, torque, power = step_by_step(model, t, angle)
    moved = replay(model, t, angle, x_m=START[0], y_m=START[1], heading_rad=START[2])
    np.testing.assert_allclose(np.column_stack([moved.com_m, moved.heading_rad]), pose, rtol=0, atol=1e-10)
    np.testing.assert_allclose(moved.joint_torque_nm, torque, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(moved.power_in_w, power[:, 0], rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(moved.power_dissipated_w, power[:, 1], rtol=1e-8, atol=1e-10)
    np.testing.assert_array_equal(
        replayed_pose(model, t, angle, START), np.column_stack([moved.com_m, moved.heading_rad])
    )
