"""Halving the step, and halving eps: neither may move speed or power by 0.2 %."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.physics import ChainModel, gait_eps_m_s, simulate_gaits
from snakebot.physics.gaits import FREE_STEPS_PER_CYCLE, default_steps_per_cycle
from snakebot.robot import load_robot

GAITS = [("saito", 22, 60), ("saito_wheeled", 27, 78), ("penn_state", 66, 80)]


def measures(robot: str, alpha: float, beta: float, omega: float, **options: Any) -> Floats:
    body = load_robot(robot).body
    assert body is not None
    model = ChainModel.from_body(body)
    eps = options.pop("eps_share", 1.0) * gait_eps_m_s(model, math.radians(alpha), omega)
    model = model.with_eps(eps)
    result = simulate_gaits(model, [math.radians(alpha), math.radians(beta), omega], **options)
    return np.array([result.speed_m_s[0], result.power_in_w[0], result.power_dissipated_w[0]])


@pytest.mark.parametrize("omega", [1.0, 2.0, 5.0])
@pytest.mark.parametrize(("robot", "alpha", "beta"), GAITS)
def test_halving_the_default_step_moves_nothing(robot: str, alpha: float, beta: float, omega: float) -> None:
    coarse = measures(robot, alpha, beta, omega)
    body = load_robot(robot).body
    assert body is not None
    steps = default_steps_per_cycle(ChainModel.from_body(body))
    fine = measures(robot, alpha, beta, omega, steps_per_cycle=2 * steps)
    assert coarse == pytest.approx(fine, rel=2e-3)


@pytest.mark.parametrize("omega", [0.5, 1.0, 2.0, 5.0])
def test_halving_the_default_eps_moves_nothing(omega: float) -> None:
    whole = measures("penn_state", 66, 80, omega, steps_per_cycle=1600)
    half = measures("penn_state", 66, 80, omega, steps_per_cycle=1600, eps_share=0.5)
    assert whole == pytest.approx(half, rel=2e-3)


@pytest.mark.parametrize("faults", [{"rigid_joints": [1]}, {"rigid_joints": [4]}, {"rigid_joints": {2: 0.3}}])
def test_halving_step_and_eps_with_rigid_joints(faults: dict[str, Any]) -> None:
    whole = measures("penn_state", 66, 80, 2.0, **faults)
    assert whole == pytest.approx(
        measures("penn_state", 66, 80, 2.0, steps_per_cycle=1600, **faults), rel=2e-3
    )
    fine = measures("penn_state", 66, 80, 2.0, steps_per_cycle=1600, **faults)
    assert fine == pytest.approx(
        measures("penn_state", 66, 80, 2.0, steps_per_cycle=1600, eps_share=0.5, **faults), rel=2e-3
    )


@pytest.mark.parametrize("free", [[1], [4], [5], [4, 5]])
def test_halving_the_step_with_free_joints(free: list[int]) -> None:
    """Joints 2 and 3 are left out: there the free part swings wide and the speed is sensitive to everything."""
    whole = measures("penn_state", 66, 80, 2.0, free_joints=free)
    half = measures("penn_state", 66, 80, 2.0, free_joints=free, steps_per_cycle=2 * FREE_STEPS_PER_CYCLE)
    assert whole == pytest.approx(half, rel=2e-3)


def test_the_error_falls_with_the_square_of_the_step() -> None:
    exact = measures("penn_state", 66, 80, 2.0, steps_per_cycle=12800)
    errors = [
        np.abs(measures("penn_state", 66, 80, 2.0, steps_per_cycle=s) / exact - 1).max()
        for s in (400, 800, 1600, 3200)
    ]
    assert all(after < before / 3 for before, after in pairwise(errors))
    assert errors[-1] < 1e-4
