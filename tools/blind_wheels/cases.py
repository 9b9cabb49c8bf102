"""Which cases there are: eleven faults and three healthy robots in turn, sized against what healthy runs differ by.

The floor of a case is the RMS between its healthy robot and what the lab's own description foretells: measured numbers
that are a little off, what no such description holds, and noise. The size of a fault is the RMS of what it adds, over
that floor: of the readings of the joint at fault, of all readings, or of the path of the centre of mass.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from blind.motions import Motion, draw_motions
from blind.robot import Recording

from blind_wheels.body import Floats
from blind_wheels.described import foretold
from blind_wheels.faults import FAULTS, Fault
from blind_wheels.lab import Description, measured
from blind_wheels.robot import Wheeled, healthy_robot

# First seed of each set, a million each, apart from each other and from those of the first robot; sizes in floors.
SETS: dict[str, tuple[int, tuple[float, ...]]] = {
    "tune": (600_000_000, (7.0, 3.5)),
    "score": (700_000_000, (6.0, 3.0)),
}
PER_SET = 1_000_000
HEALTHY = 3  # beside each round of the faults
ROUND = len(FAULTS) + HEALTHY
DURATION_S, PROBE_S = 6.0, 3.0
MOTIONS = 3
SLOWER = 0.6  # than those of the first robot: wheels that skid teach nothing
TRIES = 5  # at a magnitude


@dataclass(frozen=True)
class Label:
    """The truth about a case. ``joints``: at fault, 1-based; None where joints have no say."""

    fault: str | None
    asked_size: float
    size: float  # as reached
    joints: list[int] | None
    link: int | None
    values: dict[str, float]
    floor_rad: float
    floor_m: float
    links: int

    def mapping(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True)
class Case:
    label: Label
    about: Description
    motions: list[Motion]
    robot: Wheeled
    rng: np.random.Generator

    def runs(self) -> list[Recording]:
        """Once: the motions, and the first one again."""
        t = ticks(self.robot, DURATION_S)
        return [
            self.robot.run(t, motion.command(t, self.robot.joint_count), self.rng)
            for motion in [*self.motions, self.motions[0]]
        ]


def ticks(robot: Wheeled, duration_s: float) -> Floats:
    return np.arange(round(duration_s * robot.rate_hz)) / robot.rate_hz


def fault_of(number: int) -> str | None:
    """Of the n-th case; None: healthy."""
    place = number % ROUND
    return list(FAULTS)[place] if place < len(FAULTS) else None


def drawn_motions(rng: np.random.Generator, joints: int) -> list[Motion]:
    return [replace(m, omega_rad_s=SLOWER * m.omega_rad_s) for m in draw_motions(rng, MOTIONS, joints)]


def probes(robot: Wheeled, motions: list[Motion], seed: int) -> tuple[Floats, Floats]:
    """Readings (T, k) and path (T, 2) on the slowest and the fastest motion."""
    t, order = ticks(robot, PROBE_S), sorted(motions, key=lambda m: m.omega_rad_s)
    made = [
        robot.run(t, m.command(t, robot.joint_count), np.random.default_rng(seed))
        for m in (order[0], order[-1])
    ]
    return np.concatenate([m.encoder_rad for m in made]), np.concatenate([m.pose[:, :2] for m in made])


def told(about: Description, robot: Wheeled, motions: list[Motion]) -> tuple[Floats, Floats]:
    """The same, as the description foretells it."""
    t, order = ticks(robot, PROBE_S), sorted(motions, key=lambda m: m.omega_rad_s)
    made = [foretold(about, t, m.command(t, robot.joint_count)) for m in (order[0], order[-1])]
    return np.concatenate([a for a, _ in made]), np.concatenate([p[:, :2] for _, p in made])


def rms(table: Floats) -> float:
    return float(np.sqrt(np.mean(table**2)))


def make_case(set_name: str, seed: int, number: int) -> Case:
    """The n-th case of a seed; each round of ``ROUND`` has another size."""
    first, sizes = SETS[set_name]
    if not 0 <= seed < PER_SET:
        raise ValueError(f"--seed {seed}: 0 to {PER_SET - 1}")
    rng = np.random.default_rng([first + seed, number])
    asked = sizes[number // ROUND % len(sizes)]
    robot = healthy_robot(rng)
    about = measured(robot, rng)
    motions = drawn_motions(rng, robot.joint_count)
    probe_seed, choices = (int(v) for v in rng.integers(1 << 31, size=2))
    at_joint, at_link = int(rng.integers(robot.joint_count)), int(rng.integers(robot.body.links))
    foretold_rad, foretold_m = told(about, robot, motions)
    is_rad, is_m = probes(robot, motions, probe_seed)
    floor_rad, floor_m = rms(is_rad - foretold_rad), rms(is_m - foretold_m)
    name = fault_of(number)
    if name is None:
        label = Label(None, 0.0, 0.0, None, None, {}, floor_rad, floor_m, robot.body.links)
        return Case(label, about, motions, robot, rng)
    fault = FAULTS[name]
    at = at_joint if fault.at == "joint" else at_link
    clean_rad, clean_m = probes(robot.noiseless(), motions, probe_seed)

    def gap(magnitude: float) -> float:
        r = robot.copy()
        fault.apply(r, at, magnitude, np.random.default_rng(choices))
        try:
            rad, metres = probes(r.noiseless(), motions, probe_seed)
        except FloatingPointError:
            return float("inf")  # more than a simulation can bear
        if "body" in fault.stages:
            return rms(metres - clean_m) / floor_m
        where = [at] if fault.at == "joint" else list(range(robot.joint_count))
        return rms((rad - clean_rad)[:, where]) / floor_rad

    magnitude, reached = sized(fault, asked, gap)
    faulty = robot.copy()
    values = fault.apply(faulty, at, magnitude, np.random.default_rng(choices))
    label = Label(
        name, asked, round(reached, 3), [at + 1] if fault.at == "joint" else None,
        at + 1 if fault.at == "link" else None, {"magnitude": magnitude, **values}, floor_rad, floor_m,
        robot.body.links,
    )  # fmt: skip
    return Case(label, about, motions, faulty, rng)


def sized(fault: Fault, size: float, gap: Any) -> tuple[float, float]:
    """The magnitude that leaves a gap of this size, within a fifth if a few tries find it; and the size reached."""
    low, high = np.log(fault.low), np.log(fault.high)
    best: tuple[float, float] | None = None
    guess = 0.5 * (low + high)
    for _ in range(TRIES):
        reached = gap(float(np.exp(guess)))
        if best is None or abs(np.log(max(reached, 1e-9) / size)) < abs(np.log(max(best[1], 1e-9) / size)):
            best = float(np.exp(guess)), reached
        if abs(np.log(max(reached, 1e-9) / size)) < 0.2:
            break
        if reached < size:
            low = guess
        else:
            high = guess
        proportional = guess + np.log(size / max(reached, 1e-9))
        inside = low + 0.15 * (high - low) < proportional < high - 0.15 * (high - low)
        guess = float(proportional if inside else 0.5 * (low + high))
    assert best is not None
    return best
