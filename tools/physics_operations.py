"""How many operations a core can do, and how many a step of the chain takes, for `tools/bench_physics.py`."""

from __future__ import annotations

import time
import types
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from snakebot.physics import ChainModel, elementary, kernel, rosenbrock
from snakebot.physics.compiled import jit
from snakebot.physics.lanes import WIDTH, get_lane, lane_rows

CHAINS = 12  # independent multiply-adds in flight: more than latency times throughput of any core of today


@jit
def _multiply_adds(memory: Any, rounds: int) -> float:
    rows = lane_rows(memory, 1, CHAINS + 2)
    a, b = rows[0, CHAINS], rows[0, CHAINS + 1]
    x0, x1, x2, x3, x4, x5 = rows[0, 0], rows[0, 1], rows[0, 2], rows[0, 3], rows[0, 4], rows[0, 5]
    x6, x7, x8, x9, xa, xb = rows[0, 6], rows[0, 7], rows[0, 8], rows[0, 9], rows[0, 10], rows[0, 11]
    for _ in range(rounds):
        x0 = x0 * a + b
        x1 = x1 * a + b
        x2 = x2 * a + b
        x3 = x3 * a + b
        x4 = x4 * a + b
        x5 = x5 * a + b
        x6 = x6 * a + b
        x7 = x7 * a + b
        x8 = x8 * a + b
        x9 = x9 * a + b
        xa = xa * a + b
        xb = xb * a + b
    rows[0, 0] = x0 + x1 + x2 + x3 + x4 + x5 + x6 + x7 + x8 + x9 + xa + xb
    return get_lane(rows, 0, 0, 0)  # type: ignore[no-any-return]


def peak_gflops() -> float:
    """Of one core, per second of processor time; best of several tries."""
    memory = np.random.default_rng(0).uniform(0.1, 0.9, (CHAINS + 3) * WIDTH)
    rounds = 4_000_000
    _multiply_adds(memory, 1)
    best = 0.0
    for _ in range(5):
        cpu = time.process_time()
        _multiply_adds(memory, rounds)
        best = max(best, rounds * CHAINS * WIDTH * 2 / (time.process_time() - cpu) / 1e9)
    return best


class _Counting:
    """A number that counts what is done to it."""

    done = 0

    def __init__(self, value: float) -> None:
        self.value = value

    @classmethod
    def _counted(cls, value: float) -> _Counting:
        cls.done += 1
        return cls(value)

    def __add__(self, other: _Counting | float) -> _Counting:
        return self._counted(self.value + _value(other))

    def __radd__(self, other: _Counting | float) -> _Counting:
        return self._counted(_value(other) + self.value)

    def __sub__(self, other: _Counting | float) -> _Counting:
        return self._counted(self.value - _value(other))

    def __rsub__(self, other: _Counting | float) -> _Counting:
        return self._counted(_value(other) - self.value)

    def __mul__(self, other: _Counting | float) -> _Counting:
        return self._counted(self.value * _value(other))

    def __rmul__(self, other: _Counting | float) -> _Counting:
        return self._counted(_value(other) * self.value)

    def __truediv__(self, other: _Counting | float) -> _Counting:
        return self._counted(self.value / _value(other))

    def __rtruediv__(self, other: _Counting | float) -> _Counting:
        return self._counted(_value(other) / self.value)

    def __neg__(self) -> _Counting:
        return _Counting(-self.value)


def _value(number: _Counting | float) -> float:
    return number.value if isinstance(number, _Counting) else float(number)


def _as_python(module: Any, known: dict[str, Any]) -> dict[str, Any]:
    """A module's functions uncompiled, calling each other uncompiled."""
    names = dict(vars(module)) | known
    for name, value in vars(module).items():
        if hasattr(value, "py_func") and name not in known:
            code = value.py_func
            names[name] = types.FunctionType(code.__code__, names, name, code.__defaults__)
    return names


def operations_per_step(model: ChainModel) -> int:
    """Additions, multiplications and divisions of one robot's step with all joints prescribed."""

    def pass_through(function: Callable[[float], float]) -> Callable[[Any], Any]:
        return lambda x: _Counting(function(x.value))

    simple = {
        "magnitude": pass_through(abs),
        "at_most": lambda x, limit: _Counting(min(x.value, limit)),
        "power_of_two": pass_through(lambda shifted: 2.0 ** (shifted - 1.5 * 2.0**52)),
    }
    basic = _as_python(elementary, simple)
    equations = _as_python(kernel, {name: basic[name] for name in ("sine_cosine", "sign_over_speed")})
    called = ("kinematics", "generalised_to_links", "solve", "dissipation")
    step = _as_python(rosenbrock, {name: equations[name] for name in called})["step"]
    n = model.links
    number = np.frompyfunc(_Counting, 1, 1)
    vector = partial(number, np.random.default_rng(1).uniform(0.1, 0.2, n - 1))
    _Counting.done = 0
    step(
        model.packed, 0.0, _Counting(model.eps), _Counting(0.01), np.zeros(n - 1, dtype=int), number(np.zeros(6)),
        vector(), vector(), vector(), vector(), vector(), vector(), vector(), vector(), vector(),
        number(np.zeros((kernel.WORK_ROWS, n))), number(np.zeros((rosenbrock.STAGE_ROWS, max(6, n)))),
        number(np.zeros(n - 1)), number(np.zeros(2)),
    )  # fmt: skip
    own_reference = (n - 1) * 45  # sine, cosine and the products of the gait's angle, rate and acceleration
    return _Counting.done + own_reference
