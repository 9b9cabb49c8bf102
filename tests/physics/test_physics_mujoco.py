"""The kernel against MuJoCo: the same links, servos and ground, another engine, another integrator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from physics_peers import MujocoChain
from samples import sample

from snakebot.arrays import Floats
from snakebot.physics import ChainModel, Pid, gait_eps_m_s, gait_trajectory
from snakebot.physics.model import STANDARD_GRAVITY_M_S2

pytest.importorskip("mujoco")

FRICTION: dict[str, dict[str, Any]] = {
    "viscous, distributed": {"ct": 0.1, "cn": 10.0, "ct0": 0.0, "cn0": 0.0, "contact": 1.0},
    "viscous, wheels": {"ct": 0.1, "cn": 10.0, "ct0": 0.0, "cn0": 0.0, "contact": 0.0},
    "viscous and Coulomb": {"ct": 0.8, "cn": 50.0, "ct0": 0.5, "cn0": 2.3, "contact": 0.0},
}
GaitParameters = tuple[float, float, float]  # alpha_rad, beta_rad, omega_rad_s
Case = tuple[ChainModel, GaitParameters, tuple[int, ...], dict[int, float]]
CYCLES = 3
SAMPLES = 20  # a cycle
MUJOCO_STEP_S = 2.5e-4


def both(
    model: ChainModel,
    gait: GaitParameters,
    kp: float,
    kd: float,
    free: Sequence[int] = (),
    rigid: dict[int, float] | None = None,
    step_s: float = MUJOCO_STEP_S,
) -> tuple[Floats, Floats]:
    """Rows (com_x, com_y, psi, power_in, power_dissipated) of MuJoCo and of the kernel, at the same times."""
    period = 2 * math.pi / gait[2]
    every = math.ceil(period / SAMPLES / step_s)
    same_eps = model.with_eps(gait_eps_m_s(model, gait[0], gait[2]))
    peer = MujocoChain(
        same_eps, dt_s=period / SAMPLES / every, kp=kp, kd=kd, free=tuple(free), rigid=rigid or {}
    )  # fmt: skip
    other = peer.run(gait, CYCLES * SAMPLES * every, every)[:, 1:]
    steps = 800
    ours = gait_trajectory(
        model, gait, free_joints=free, rigid_joints=rigid or {}, pid=Pid(kp, 0.0, kd), cycles=CYCLES,
        steps_per_cycle=steps,
    )  # fmt: skip
    rows = np.column_stack((ours.com_m, ours.heading_rad))[steps // SAMPLES :: steps // SAMPLES]
    powers = np.column_stack((ours.power_in_w, ours.power_dissipated_w))[1:]
    means = powers.reshape(len(rows), -1, 2).mean(axis=1)
    return other, np.column_stack((rows, means))


def assert_same(model: ChainModel, gait: GaitParameters, other: Floats, ours: Floats) -> None:
    length = float(2 * model.half_length.sum())
    way = np.linalg.norm(np.diff(other[:, :2], axis=0), axis=1).sum()
    # MuJoCo's semi-implicit Euler step errs in first order: a fourth of the step leaves a fourth of the distance.
    assert np.abs(ours[:, :2] - other[:, :2]).max() < 0.01 * way + 0.002 * length
    assert np.abs(ours[:, 2] - other[:, 2]).max() < 0.02
    last = slice(-SAMPLES, None)
    speeds = [
        np.linalg.norm(rows[-1, :2] - rows[-1 - SAMPLES, :2]) * gait[2] / (2 * math.pi)
        for rows in (other, ours)
    ]
    swing = (
        gait[0] * gait[2] * float(model.half_length.mean())
    )  # what the links move by, even where the robot does not
    assert speeds[1] == pytest.approx(speeds[0], rel=0.01, abs=0.005 * swing)
    powers = [rows[last, 3:].mean(axis=0) for rows in (other, ours)]
    slack = 1e-3 * float(model.cn.mean()) * swing**2
    assert powers[1][0] == pytest.approx(powers[0][0], rel=0.01, abs=slack)
    # Its explicit ground force chatters in dry friction, and what it loses is then not what joints and gravity put in:
    # the dissipation is compared no more sharply than MuJoCo's own balance over the cycle closes.
    downhill = other[-1 - SAMPLES, 0] - other[-1, 0]
    weight = float(model.mass.sum()) * STANDARD_GRAVITY_M_S2 * math.sin(model.slope_rad)
    gravity = weight * downhill * gait[2] / (2 * math.pi)
    unbalanced = abs(powers[0][1] - powers[0][0] - gravity)
    assert powers[1][1] == pytest.approx(powers[0][1], rel=0.01, abs=slack + unbalanced)


def assert_converges(
    model: ChainModel, gait: GaitParameters, free: Sequence[int], rigid: dict[int, float]
) -> None:
    """The same with loose servos; where MuJoCo's step is too long for that, with a fourth of it.

    On a slope the joints may put in a hundredth of what the ground takes: a small difference of two large powers.
    """
    try:
        assert_same(model, gait, *both(model, gait, 30.0, 0.3, free, rigid))
    except AssertionError:
        assert_same(model, gait, *both(model, gait, 30.0, 0.3, free, rigid, step_s=MUJOCO_STEP_S / 4))


IN_BRIEF: tuple[
    tuple[str, tuple[int, ...], dict[int, float]], ...
] = (  # every friction, and every kind of joint
    ("viscous, distributed", (4,), {}),
    ("viscous, wheels", (), {2: 0.4}),
    ("viscous and Coulomb", (), {}),
)


@pytest.mark.parametrize(
    ("friction", "free", "rigid"),
    [
        pytest.param(*case, marks=[pytest.mark.slow] * (case not in IN_BRIEF))
        for friction in FRICTION
        for joints in (((), {}), ((4,), {}), ((), {2: 0.4}), ((5,), {1: 0.0}))
        for case in [(friction, *joints)]
    ],
)
def test_six_links_move_as_in_mujoco(friction: str, free: Sequence[int], rigid: dict[int, float]) -> None:
    model = ChainModel(
        mass=np.full(6, 1.0), half_length=np.full(6, 0.1), inertia=np.full(6, 0.01 / 3), **FRICTION[friction]
    )
    gait = (math.radians(50), math.radians(75), 2.0)
    assert_same(model, gait, *both(model, gait, 60.0, 1.0, free, rigid))


@st.composite
def cases(draw: st.DrawFn) -> Case:
    n = draw(st.integers(2, 7))

    def number(low: float, high: float) -> st.SearchStrategy[float]:
        return st.floats(low, high).map(lambda v: round(v, 4))

    def per_link(low: float, high: float) -> Floats:
        return np.array(draw(st.lists(number(low, high), min_size=n, max_size=n)))

    mass, half = per_link(0.5, 2.0), per_link(0.06, 0.15)
    coulomb = draw(st.booleans())
    cn = per_link(10.0, 40.0)
    model = ChainModel(
        mass=mass, half_length=half, inertia=mass * half**2 / 3, ct=per_link(0.1, 2.0), cn=cn,
        ct0=per_link(0.1, 0.6) * coulomb, cn0=per_link(0.5, 2.0) * coulomb,
        contact=np.full(n, float(draw(st.booleans()))), slope_rad=draw(number(-0.02, 0.02)),
    )  # fmt: skip
    joints = draw(st.permutations(range(1, n)))
    free = joints[: draw(st.integers(0, min(1, n - 2)))]
    rigid = {
        j: draw(number(-0.6, 0.6))
        for j in joints[len(free) : len(free) + draw(st.integers(0, max(0, n - 4)))]
    }
    gait = (draw(number(0.3, 1.0)), draw(number(0.6, 1.8)), draw(number(1.0, 3.0)))
    return model, gait, tuple(free), rigid


@settings(
    max_examples=12, derandomize=True, deadline=None, suppress_health_check=list(HealthCheck), database=None
)
@given(cases())
def test_random_chains_move_as_in_mujoco(case: Case) -> None:
    assert_converges(*case)


@pytest.mark.slow
@pytest.mark.timeout(600)
@settings(
    max_examples=sample(150, 50),
    derandomize=True,
    deadline=None,
    suppress_health_check=list(HealthCheck),
    database=None,
)
@given(cases())
def test_many_random_chains_move_as_in_mujoco(case: Case) -> None:
    assert_converges(*case)
