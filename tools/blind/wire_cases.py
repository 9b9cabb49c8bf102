"""Cases that go through a wire: few, each with one effect that is plain to see, or none, or one that nobody knows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blind.cases import Effect, Label
from blind.chain import Floats
from blind.faults import FAULTS, draw_joints
from blind.robot import Parameters, Robot, gait_command, real_robot

FIRST_SEED = 400_000_000  # shares no draws with the sets of ``cases``
PER_SET = 1_000_000
Gait = tuple[float, float, float]  # alpha, beta in degrees, omega in rad/s

# What to put in, and its magnitude from and to (see ``faults``), chosen to lie above 3 floors.
KINDS: tuple[tuple[str, float, float], ...] = (
    ("rate_limit", 2.5, 3.8),
    ("no_gap", 0.0, 0.0),
    ("backlash", 3.0, 8.0),
    ("command_delay", 0.03, 0.08),
    ("command_gain", 0.05, 0.15),
    ("servo_offset", 3.0, 8.0),
    ("payload", 1.5, 3.5),
    ("unknown", 0.0, 0.0),
)
UNKNOWN = (
    ("neighbour_crosstalk", 0.08, 0.2),
    ("encoder_eccentricity", 3.0, 6.0),
    ("gear_eccentricity", 2.0, 5.0),
)
OMEGA_RAD_S = ((0.9, 1.4), (1.8, 2.6), (3.2, 4.5))  # of the gaits of a wire case
_PROBE_RATE_HZ = 100.0
PLAIN = 3.0  # floors: what an effect of these sets moves its robot by at least
_TRIES = 50  # robots drawn for one case


@dataclass(frozen=True)
class WireCase:
    """The truth about one case, and what its robot does."""

    label: Label
    parameters: Parameters
    gaits: list[Gait]
    carrier: str  # pty or can
    seed: int


def draw_case(seed: int, number: int, gaits: list[Gait] | None = None) -> WireCase:
    """The n-th case of a seed, on gaits of its own or on those given.

    Raises:
        ValueError: no such seed, or no robot in which the effect is plain to see.
    """
    if not 0 <= seed < PER_SET:
        raise ValueError(f"--seed {seed}: 0 to {PER_SET - 1}")
    rng = np.random.default_rng([FIRST_SEED + seed, number])
    name, low, high = KINDS[number % len(KINDS)]
    stratum = name if name in ("no_gap", "unknown") else "single"
    if name == "unknown":
        name, low, high = UNKNOWN[int(rng.integers(len(UNKNOWN)))]
    chosen = gaits or _gaits(rng)
    for _ in range(_TRIES):
        real = real_robot(rng)
        floor = _apart(_probes(Parameters(), chosen, clean=True), _probes(real, chosen, clean=False))
        faulty, effects = real.copy(), []
        if stratum != "no_gap":
            effects.append(
                _put_in(
                    name, float(np.exp(rng.uniform(np.log(low), np.log(high)))), faulty, chosen, floor, rng
                )
            )
        if all(effect.size >= PLAIN for effect in effects):
            break
    else:
        raise ValueError(
            f"--seed {seed}: no {name} stands out of its robot in case {number}; choose another seed"
        )
    asked = effects[0].size if effects else 0.0
    label = Label(stratum, asked, effects, *floor)
    carrier = ("pty", "can")[(number + seed) % 2]
    return WireCase(label, faulty, chosen, carrier, int(rng.integers(1 << 31)))


def _put_in(
    name: str,
    magnitude: float,
    faulty: Parameters,
    gaits: list[Gait],
    floor: tuple[float, float],
    rng: np.random.Generator,
) -> Effect:
    """Put a fault into the robot; its size is counted in floors (rad, m)."""
    real, fault, joints = faulty.copy(), FAULTS[name], draw_joints(name, rng)
    at = np.arange(real.joints.shape[1]) if joints is None else joints
    values = fault.apply(faulty, at, magnitude, rng)
    off = _apart(_probes(real, gaits, clean=True), _probes(faulty, gaits, clean=True), at)
    size = off[1] / floor[1] if fault.stage == "body" else off[0] / floor[0]
    listed = None if joints is None else [int(j) + 1 for j in joints]
    return Effect(name, fault.stage, listed, {k: float(v) for k, v in values.items()}, round(size, 3))


def _gaits(rng: np.random.Generator) -> list[Gait]:
    """Slow to fast; slow ones swing wide."""
    made = []
    for low, high in OMEGA_RAD_S:
        omega = round(float(rng.uniform(low, high)), 2)
        alpha = round(min(60.0, float(rng.uniform(90.0, 130.0)) / omega), 1)
        made.append((alpha, round(float(rng.uniform(70.0, 90.0)), 1), omega))
    return made


def _probes(parameters: Parameters, gaits: list[Gait], *, clean: bool) -> list[tuple[Floats, Floats]]:
    """Readings (T, k) and path (T, 2) on each gait, two cycles or 4 s."""
    robot = Robot(parameters.noiseless() if clean else parameters)
    made = []
    for alpha, beta, omega in gaits:
        t = np.arange(round(max(4.0, min(4 * np.pi / omega, 10.0)) * _PROBE_RATE_HZ)) / _PROBE_RATE_HZ
        command = gait_command(t, float(np.radians(alpha)), float(np.radians(beta)), omega)
        run = robot.run(t, command, np.random.default_rng(0))
        made.append((run.encoder_rad, run.pose[:, :2]))
    return made


def _apart(
    first: list[tuple[Floats, Floats]], second: list[tuple[Floats, Floats]], at: np.ndarray | None = None
) -> tuple[float, float]:
    """RMS between two robots: of the joints (rad) and of the path (m)."""
    joints = np.concatenate([b[0] - a[0] for a, b in zip(first, second, strict=True)])
    path = np.concatenate([b[1] - a[1] for a, b in zip(first, second, strict=True)])
    if at is not None:
        joints = joints[:, at]
    return float(np.sqrt(np.mean(joints**2))), float(np.sqrt(np.mean(path**2)))
