"""Elementary functions, and lanes against single numbers."""

from __future__ import annotations

import importlib
import inspect
import math
import os
import pkgutil
import subprocess
import sys
import time
from fnmatch import fnmatch
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from physics_peers import gait_reference

import snakebot.physics
from snakebot.physics import Chain, ChainModel, Drive, compiled, gait_eps_m_s, gait_trajectory, simulate_gaits
from snakebot.physics.elementary import sign_over_speed, sine_cosine


def test_sine_and_cosine_to_the_last_bits() -> None:
    x = np.concatenate(
        (np.random.default_rng(1).uniform(-1e4, 1e4, 20000), np.arange(-40, 41) * math.pi / 4, [0.0])
    )
    got = np.array([sine_cosine(v) for v in x])
    assert np.abs(got[:, 0] - np.sin(x)).max() < 4e-16
    assert np.abs(got[:, 1] - np.cos(x)).max() < 4e-16


def test_the_regularised_sign_over_speed_to_the_last_bits() -> None:
    v = np.concatenate((10.0 ** np.linspace(-250, 4, 5000), -(10.0 ** np.linspace(-9, 2, 500))))
    got = np.array([sign_over_speed(a, 1 / 2e-3) for a in v])
    assert got == pytest.approx(np.tanh(v / 2e-3) / v, rel=1e-15)
    assert sign_over_speed(0.0, 1 / 2e-3) == pytest.approx(500.0)


def six_links() -> ChainModel:
    mass, half = np.linspace(0.8, 1.4, 6), np.linspace(0.07, 0.1, 6)
    return ChainModel(
        mass=mass, half_length=half, inertia=mass * half**2 / 3, ct=np.full(6, 0.8), cn=np.linspace(30, 50, 6),
        ct0=np.full(6, 0.4), cn0=np.full(6, 2.0), contact=np.array([0, 1, 0, 1, 0, 1.0]), slope_rad=0.01,
    )  # fmt: skip


def test_a_chain_alone_moves_as_one_of_eight() -> None:
    """The online stepper runs the kernel on numbers, a gait on lanes; only the way the drive is told differs."""
    model, gait = six_links(), (0.9, 1.3, 2.0)
    lanes = gait_trajectory(model, gait, cycles=2, steps_per_cycle=1000)
    chain = Chain(model.with_eps(gait_eps_m_s(model, gait[0], gait[2])), lanes.t_s[1])
    drive, follow = Drive.at_rest(5), gait_reference(*gait, 5)
    for now in lanes.t_s[1:]:
        drive.angle_rad[:], drive.rate_rad_s[:], _ = follow(now)
        chain.step(drive)
    # The chain takes the mean acceleration of each step, the gait the exact ones at both ends: second order apart.
    assert chain.com_m == pytest.approx(lanes.com_m[-1], abs=3e-4)
    assert chain.joint_torque_nm == pytest.approx(lanes.joint_torque_nm[-1], abs=2e-2)


def test_results_do_not_depend_on_neighbours_order_or_threads() -> None:
    rng = np.random.default_rng(4)
    gaits = np.column_stack((rng.uniform(0.1, 1.2, 21), rng.uniform(0.3, 2, 21), rng.uniform(0.5, 5, 21)))
    model = six_links()
    speeds = partial(simulate_gaits, model, cycles=2, averaged_cycles=1)
    alone = [speeds(gait).speed_m_s[0] for gait in gaits]
    together = speeds(gaits, threads=1).speed_m_s
    backwards = speeds(gaits[::-1], threads=3).speed_m_s[::-1]
    assert np.array_equal(alone, together)  # to the last bit
    assert np.array_equal(together, backwards)


def test_compiled_code_is_found_again_and_dropped_when_a_source_is_newer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    for sources, _ in compiled._BUILT_INTO:
        for source in sources:
            (tmp_path / f"{source}.py").touch()
    now = time.time()
    for name, age in (("gaits.old", 10.0), ("gaits.new", -10.0)):
        (cache / f"{name}.nbi").touch()
        os.utime(cache / f"{name}.nbi", (now - age, now - age))
    monkeypatch.setattr(compiled, "_HERE", tmp_path)
    compiled.drop_stale_caches()
    assert [p.name for p in cache.iterdir()] == ["gaits.new.nbi"]


def test_every_source_that_is_built_into_another_is_listed() -> None:
    """A compiled function that calls one of another file holds that file's code, whose changes numba does not see."""

    def holds(module: str, name: str) -> bool:
        return any(
            name in sources and fnmatch(f"{module}.x.nbi", pattern)
            for sources, pattern in compiled._BUILT_INTO
        )

    built_in = set()
    for found in pkgutil.iter_modules(snakebot.physics.__path__):
        module = importlib.import_module(f"snakebot.physics.{found.name}")
        functions = [f for f in vars(module).values() if hasattr(f, "py_func")]
        for function in (f for f in functions if f.__module__ == module.__name__):
            for name in function.py_func.__code__.co_names:
                value = vars(module).get(name)
                called = value.__name__ if inspect.ismodule(value) else getattr(value, "__module__", "")
                if called.startswith("snakebot.physics.") and called != module.__name__:
                    built_in.add((found.name, called.rpartition(".")[2]))
    assert ("gait_loop", "rosenbrock") in built_in
    assert ("servo_chain", "servo_grip") in built_in
    assert [pair for pair in sorted(built_in) if not holds(*pair)] == []


def test_a_second_start_compiles_nothing() -> None:
    simulate_gaits(six_links(), [0.5, 1.0, 2.0], cycles=1, averaged_cycles=1)
    program = (
        "from snakebot.physics import ChainModel, gait_loop, simulate_gaits\n"
        "import numpy as np\n"
        "model = ChainModel(*(np.ones(3) for _ in range(8)))\n"
        "simulate_gaits(model, [0.5, 1.0, 2.0], cycles=1, averaged_cycles=1)\n"
        "stats = gait_loop.run_blocks.stats\n"
        "print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))\n"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["1", "0"]
