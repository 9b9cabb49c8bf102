"""The limiter's compiled arithmetic: the same as its Python source to the last bit, and compiled before any tick."""

from __future__ import annotations

import importlib.util
import random
import subprocess
import sys
from types import ModuleType
from typing import Any

import numba
import numpy as np
import pytest

from snakebot.gait import SlewLimiter, slew
from snakebot.gait.limits import WIRE_STEP_RAD


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """``slew`` as the interpreter runs it."""

    def interpreted(*given: Any, **_: Any) -> Any:
        return given[0] if callable(given[0]) else lambda function: function

    monkeypatch.setattr(numba, "njit", interpreted)
    assert slew.__spec__ is not None
    spec = importlib.util.spec_from_file_location("plain_slew", slew.__spec__.origin)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("seed", range(20))
def test_compiled_and_interpreted_agree_to_the_last_bit(plain: ModuleType, seed: int) -> None:
    draw = random.Random(seed)
    joints, slack = draw.choice([1, 5, 16]), draw.choice([0.0, WIRE_STEP_RAD])
    limits = [[draw.uniform(low, high) for _ in range(joints)] for low, high in ((0.3, 2), (1, 10), (5, 100))]
    pair = [SlewLimiter(*limits, slack_rad=slack) for _ in range(2)]
    pair[1]._compiled_step = plain.step
    angles, changed = [0.0] * joints, 0
    for _ in range(200):
        dt = draw.choice([0.01, 0.01, 0.002, 0.0007, 0.033])
        spread = draw.choice([0.001, 0.02, 0.3])
        angles = [min(max(angle + draw.gauss(0, spread), -3), 3) for angle in angles]
        if draw.random() < 0.02:
            joint, angle = draw.randrange(joints), draw.uniform(-0.3, 0.3)
            for limiter in pair:
                limiter.follow(joint, angle)
        if draw.random() < 0.02:  # a limit that is tightened below where the joint is
            joint, tight = draw.randrange(joints), draw.uniform(0.1, 0.3)
            for limiter in pair:
                limiter.angle_rad[joint] = tight
        done = [limiter.execute(angles, dt, 1, dt) for limiter in pair]
        assert done[0] == done[1]
        assert np.array_equal(pair[0]._paths, pair[1]._paths)
        changed += done[0] is not None and done[0][1] > 0
    assert changed > 20, "the limits had work to do"


def test_a_tick_never_waits_for_the_compiler() -> None:
    limiter = SlewLimiter([1.6], [8.0], [60.0])
    before = list(slew.step.signatures)
    assert len(before) == 1
    limiter.execute([0], 1, 1, 1)  # integers, tuples and arrays: all become the one type
    limiter.execute((0.1,), 0.01, 1, 0.01)
    limiter.execute([0.1], 0.01, 1, 0.01)
    assert slew.step.signatures == before
    assert limiter._compiled_step is slew.step


def test_who_only_checks_a_motion_does_not_load_the_compiler() -> None:
    code = "import snakebot.gait, sys; assert 'numba' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_copy_goes_the_same_way_and_each_has_limits_of_its_own() -> None:
    one = SlewLimiter([1.0, 1.0], [2.0, 3.0], [20.0, 30.0])
    one.execute([0.2, -0.3], 0.01, 1, 0.01)
    other = one.copy()
    for limiter in (one, other):
        limiter.execute([0.5, -0.5], 0.01, 1, 0.01)
    assert other.applied_rad == one.applied_rad
    other.speed_rad_s[:] = 0.1
    assert one.speed_rad_s.tolist() == [2.0, 3.0]
    for _ in range(20):
        one.execute([0.9, -0.9], 0.01, 1, 0.01)
        other.execute([0.9, -0.9], 0.01, 1, 0.01)
    assert abs(one.applied_rad[0]) > abs(other.applied_rad[0])
