"""Effects put into the blind robot: those that the product's library names, and those that it does not hold.

Each is a function of one magnitude, which ``cases`` sets from the size of the gap that is asked for. A fault returns
what is true in the units of the library's parameters, so that estimates can be scored.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import radians

import numpy as np

from blind.robot import JOINTS, LOOP_LAG_S, Parameters

Truth = dict[str, float]
Draw = np.random.Generator


@dataclass(frozen=True)
class Fault:
    """``apply(parameters, joints, magnitude, rng)``; joints are 0-based. ``low`` to ``high``: of the magnitude."""

    name: str
    stage: str
    apply: Callable[[Parameters, np.ndarray, float, Draw], Truth]
    low: float
    high: float
    per_joint: bool = True
    known: bool = True  # the product's library holds it
    scaled: bool = True  # false: it is there or it is not


FAULTS: dict[str, Fault] = {}


def fault(
    name: str, stage: str, low: float, high: float, **options: bool
) -> Callable[[Callable[..., Truth]], Callable[..., Truth]]:
    def add(apply: Callable[..., Truth]) -> Callable[..., Truth]:
        FAULTS[name] = Fault(name, stage, apply, low, high, **options)
        return apply

    return add


@fault("command_delay", "link", 1e-3, 0.4, per_joint=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.latency_s += m
    return {"delay_s": m}


@fault("command_loss", "link", 0.01, 0.93, per_joint=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.loss = m
    return {"probability": m}


@fault("clock_drift", "link", 100.0, 20000.0, per_joint=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.clock_ppm += m
    return {"ppm": m}


@fault("servo_lag", "servo", 0.03, 20.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    lag = p.nominal_lag_s * (1 + m)
    p.joint("lag_s")[at] = lag - LOOP_LAG_S
    return {"time_constant_s": lag}


@fault("second_order", "servo", 0.02, 10.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    damping = float(rng.uniform(0.25, 0.7))
    inner = 0.002
    frequency = 2 * damping / ((p.nominal_lag_s - inner - LOOP_LAG_S) * (1 + m))  # at m = 0 late as nominal
    p.joint("natural_rad_s")[at] = frequency
    p.joint("damping")[at] = damping
    p.joint("lag_s")[at] = inner
    return {"natural_freq_rad_s": frequency, "damping_ratio": damping}


@fault("rate_limit", "servo", 0.2, 10.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.joint("rate_plus_rad_s")[at] = p.joint("rate_minus_rad_s")[at] = 4 / m
    return {"limit_rad_s": 4 / m}


@fault("torque_speed", "servo", 0.25, 12.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    """The motor's own line from no load to stall, low enough to be met."""
    stall = float(rng.uniform(1.0, 3.0)) / m
    p.joint("no_load_rad_s")[at] = 5 / m
    p.joint("stall_nm")[at] = stall
    return {"no_load_rad_s": 5 / m, "stall_nm": stall}


@fault("torque_limit", "servo", 0.2, 20.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.joint("torque_limit_nm")[at] = 1 / m
    return {"limit_nm": 1 / m}


@fault("voltage_sag", "servo", 0.2, 10.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    drop = float(rng.uniform(0.03, 0.07))
    p.joint("rate_plus_rad_s")[at] = p.joint("rate_minus_rad_s")[at] = 4 / m
    p.joint("rate_drop_per_s")[at] = drop
    return {"initial_rad_s": 4 / m, "drop_per_s": drop}


@fault("deadband", "servo", 0.1, 25.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.joint("deadband_rad")[at] = radians(m)
    return {"width_deg": m}


@fault("backlash", "servo", 0.1, 40.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.joint("play_rad")[at] = radians(m)
    return {"width_deg": m}


@fault("joint_friction", "servo", 0.004, 0.4)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    coulomb = float(rng.uniform(0.2, 0.7))
    stiffness = coulomb / m
    p.joint("coulomb_nm")[at] = coulomb
    p.joint("integral_nm_rad")[at] = 0.0  # a proportional loop
    p.joint("loop_nm_s_rad")[at] = stiffness * p.joint("lag_s")[at]
    return {"coulomb_nm": coulomb, "stiffness_nm_rad": stiffness}


@fault("compliance", "servo", 0.005, 1.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.joint("gear_nm_rad")[at] = 1 / m
    p.joint("gear_nm_s_rad")[at] = 0.07 / m**0.5  # critically damped with a link on its end
    return {"stiffness_nm_rad": 1 / m}


@fault("servo_offset", "servo", 0.05, 30.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    offset = m * rng.choice([-1.0, 1.0])
    p.joint("offset_rad")[at] = radians(offset)
    return {"offset_deg": offset}


@fault("command_gain", "servo", 0.002, 0.6)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    gain = 1 + m * rng.choice([-1.0, 1.0])
    p.mixing[at, at] = gain
    return {"gain": gain}


@fault("joint_free", "servo", 1.0, 1.0, scaled=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.joint("free")[at] = 1.0
    return {}


@fault("joint_rigid", "servo", 1.0, 1.0, scaled=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    angle = float(rng.uniform(-20, 20))
    p.joint("stuck")[at] = 1.0
    p.joint("stuck_rad")[at] = radians(angle)
    return {"angle_deg": angle}


@fault("wiring", "servo", 1.0, 1.0, scaled=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    if at.size == 2:
        p.mixing[at] = p.mixing[at[::-1]]  # two leads swapped
    else:
        p.mixing[at] *= -1
    return {}


@fault("encoder_offset", "sensor", 0.05, 30.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    offset = m * rng.choice([-1.0, 1.0])
    p.reading_offset_rad[at] = radians(offset)
    return {"offset_deg": offset}


@fault("encoder_gain", "sensor", 0.002, 0.6)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    gain = 1 + m * rng.choice([-1.0, 1.0])
    p.reading_gain[at] = gain
    return {"gain": gain}


@fault("encoder_noise", "sensor", 0.05, 10.0)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    p.reading_noise_rad[at] = radians(m)
    return {"std_deg": m}


@fault("ground_friction", "body", 0.02, 3.0, per_joint=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    row = str(rng.choice(["ct", "cn", "ct0"]))
    scale = float(np.exp(m * rng.choice([-1.0, 1.0])))
    p.link(row)[:] *= scale
    return {f"{row}_scale": scale}


@fault("wheel_drag", "body", 0.02, 8.0, per_joint=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    link = int(rng.integers(p.links.shape[1]))
    p.link("ct0")[link] += m
    return {"link": link + 1.0, "extra_n": m}


@fault("payload", "body", 0.05, 10.0, per_joint=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    link = int(rng.integers(p.links.shape[1]))
    p.link("mass_kg")[link] += m
    return {"link": link + 1.0, "mass_kg": m}


@fault("slope", "body", 0.02, 8.0, per_joint=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    angle = m * rng.choice([-1.0, 1.0])
    p.ground[0] = radians(angle)
    return {"angle_deg": angle}


# --- what the library does not hold ---


@fault("gear_eccentricity", "servo", 0.05, 20.0, known=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    """The output runs ahead and behind by m degrees, several times a turn."""
    p.joint("eccentric_rad")[at] = radians(m)
    p.joint("eccentric_turns")[at] = rng.integers(7, 12)
    p.joint("eccentric_phase_rad")[at] = rng.uniform(0, 2 * np.pi, at.size)
    return {}


@fault("neighbour_crosstalk", "servo", 0.005, 1.0, known=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    """A share of the next joint's set-point leaks into a joint's own."""
    for j in at:
        p.mixing[j, (j + 1) % p.joint_count] += m
    return {}


@fault("directional_rate", "servo", 0.2, 12.0, known=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    """Turning one way is slower than turning the other."""
    p.joint("rate_plus_rad_s")[at] = 4 / m
    return {}


@fault("mount_resonance", "sensor", 1e-3, 0.6, known=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    """The encoder's mount sways with the joint's torque and rings at a frequency of its own."""
    p.joint("mount_gain_rad_nm")[at] = m
    p.joint("mount_rad_s")[at] = rng.uniform(8, 20)
    return {}


@fault("encoder_eccentricity", "sensor", 0.05, 25.0, known=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    """A code wheel off its centre: the reading errs by a sine of the angle."""
    p.reading_wave_rad[0, at] = radians(m)
    p.reading_wave_rad[1, at] = rng.uniform(0, 2 * np.pi, at.size)
    return {}


@fault("uneven_ground", "body", 1e-5, 0.02, per_joint=False, known=False)
def _(p: Parameters, at: np.ndarray, m: float, rng: Draw) -> Truth:
    """Hills and hollows m metres high, half a metre apart."""
    p.ground[1], p.ground[2], p.ground[3] = m, 2 * np.pi / 0.5, rng.uniform(0, 2 * np.pi)
    return {}


@cache
def go_together(first: str, second: str) -> bool:
    """Whether both can be in one robot: where one undoes or scales what the other wrote, a label would be void.

    Tried out, on all joints: it must not matter which is put in first.
    """
    if first == second:
        return False
    for seed in range(8):  # some draw what they write
        made = []
        for order in ((first, second), (second, first)):
            p = Parameters()
            for name in order:
                f = FAULTS[name]
                magnitude = (f.low * f.high) ** 0.5 * (1.1 if name == first else 0.9)
                f.apply(p, np.arange(p.joint_count), magnitude, np.random.default_rng(seed))
            made.append(vars(p))
        if not all(np.allclose(made[0][key], made[1][key], rtol=1e-12, atol=0.0) for key in made[0]):
            return False
    return True


KNOWN = tuple(name for name, f in FAULTS.items() if f.known)
UNKNOWN = tuple(name for name, f in FAULTS.items() if not f.known)


def draw_joints(name: str, rng: Draw, count: int = JOINTS) -> np.ndarray | None:
    """0-based joints at fault; all of them for half of the cases that can; None where joints have no say."""
    f = FAULTS[name]
    if not f.per_joint:
        return None
    if name == "wiring" and rng.random() < 0.5:
        first = int(rng.integers(count - 1))
        return np.array([first, first + 1])
    if f.scaled and rng.random() < 0.5:
        return np.arange(count)
    return np.array([int(rng.integers(count))])
