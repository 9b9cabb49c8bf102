"""Faults as they happen to a robot on wheels, and the honest answer to each, written down before any was diagnosed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import radians

import numpy as np

from blind_wheels.body import FLOOR_CELLS, FLOOR_HALF_M, WHEEL_RADIUS_M
from blind_wheels.robot import Wheeled

Truth = dict[str, float]
Draw = np.random.Generator


@dataclass(frozen=True)
class Fault:
    """``apply(robot, at, magnitude, rng)``; ``at``: 0-based joint or link. ``low`` to ``high``: of the magnitude.

    ``names``: causes that say what is the matter, or leave the same mark. ``open``: partly or unexplained, at one of
    ``stages``, is as honest, because the product's library does not hold the fault.
    """

    apply: Callable[[Wheeled, int, float, Draw], Truth]
    at: str  # joint, link or all
    low: float
    high: float
    names: frozenset[str]
    open: bool
    stages: frozenset[str]
    why: str


FAULTS: dict[str, Fault] = {}


def fault(
    name: str,
    at: str,
    low: float,
    high: float,
    names: str,
    stages: str,
    why: str,
    *,
    may_be_open: bool = True,
) -> Callable[[Callable[[Wheeled, int, float, Draw], Truth]], Callable[[Wheeled, int, float, Draw], Truth]]:
    def add(apply: Callable[[Wheeled, int, float, Draw], Truth]) -> Callable[..., Truth]:
        FAULTS[name] = Fault(
            apply, at, low, high, frozenset(names.split()), may_be_open, frozenset(stages.split()), why
        )
        return apply

    return add


@fault(
    "dry_bearings", "all", 0.05, 20.0, "ground_friction", "body", "more drag along, most of it at low speed"
)
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    before = r.bearings[0].copy()
    r.bearings[0] = (1 + m) * before
    r.bearings[1] = (1 + m) * before  # half of the drag at rest is gone once it rolls
    return {}


@fault(
    "loose_horn", "joint", 0.1, 15.0, "backlash deadband joint_friction", "servo",
    "play between gear and link: the library holds it", may_be_open=False,
)  # fmt: skip
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    r.body.second_hinge |= {at}
    r.joint("play_rad")[at] = radians(m)
    return {"width_deg": m}


@fault(
    "slipping_wheels", "link", 0.1, 4.0, "ground_friction", "body",
    "one link has lost its grip; the library changes that of all links alike",
)  # fmt: skip
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    r.body.grip[at] *= np.exp(-m)
    return {}


@fault(
    "worn_tooth", "joint", 0.1, 15.0, "backlash", "servo",
    "play in a few degrees and nowhere else; the library's play is everywhere",
)  # fmt: skip
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    r.body.second_hinge |= {at}
    r.joint("worn_rad")[at] = radians(m)
    r.joint("worn_at_rad")[at] = radians(float(rng.uniform(-8, 8)))
    r.joint("worn_width_rad")[at] = radians(4.0)
    return {}


@fault(
    "loose_connector", "joint", 0.03, 3.0, "command_loss joint_free", "link servo",
    "now and then the servo goes limp; the library loses set-points, or has a joint that is always limp",
)  # fmt: skip
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    r.dropouts_hz[at] = m
    return {}


@fault(
    "cold_battery", "all", 0.2, 30.0, "voltage_sag torque_speed rate_limit torque_limit servo_lag compliance", "servo",
    "volts fall when motors pull, and with them speed, torque and the gain of every loop",
)  # fmt: skip
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    r.battery[1] += m
    return {}


@fault(
    "warm_motor", "joint", 20.0, 250.0, "servo_lag compliance joint_friction torque_speed torque_limit", "servo",
    "more resistance and a weaker magnet: a softer loop that is late otherwise",
)  # fmt: skip
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    r.joint("heat_k")[at] = m
    return {}


@fault(
    "pulling_cable", "joint", 20.0, 2e5, "compliance servo_offset command_gain", "servo",
    "a cable that is taut on one side of the swing and slack on the other; the library has no spring of one side",
)  # fmt: skip
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    r.body.pulling[at] = (m, float(rng.uniform(0.92, 1.0)))
    return {}


@fault(
    "magnet_off_centre", "joint", 0.002, 0.5, "encoder_gain encoder_offset", "sensor",
    "the reading errs by about a sine of the angle: within a swing a gain, and a bow that the library lacks",
)  # fmt: skip
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    r.magnet[:, at] = m, rng.uniform(0, 2 * np.pi)
    return {}


@fault(
    "sticking_wheel",
    "link",
    0.1,
    60.0,
    "wheel_drag",
    "body",
    "one wheel drags: one-sided, which turns it, too",
)
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    wheel = 2 * at + int(rng.integers(2))
    extra = m * float(r.bearings[0].mean())
    r.bearings[0, wheel] += extra
    return {"extra_n": extra / WHEEL_RADIUS_M}


@fault("uneven_floor", "all", 1e-4, 0.02, "", "body", "hills and hollows; the library has a slope alone")
def _(r: Wheeled, at: int, m: float, rng: Draw) -> Truth:
    x = np.linspace(-FLOOR_HALF_M, FLOOR_HALF_M, FLOOR_CELLS)
    hills = np.zeros((FLOOR_CELLS, FLOOR_CELLS))
    for _ in range(12):
        way, k = float(rng.uniform(0, 2 * np.pi)), 2 * np.pi / float(rng.uniform(0.3, 0.8))
        hills += np.sin(
            k * (np.cos(way) * x[None] + np.sin(way) * x[:, None]) + float(rng.uniform(0, 2 * np.pi))
        )
    hills -= hills.min()
    r.body.floor_m = m * hills / hills.std()
    return {}
