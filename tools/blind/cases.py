"""Which cases there are, and how large their effects: drawn from a seed, scaled to the noise floor.

The floor of a case is what robots like its own differ by from the nominal one without any effect: mass, friction, lag
and play a few per cent off, plus sensor noise. One robot alone would not do: one that happens to be nearly nominal has
hardly a floor, and an effect of ten such floors is one that nobody could tell from healthy robots. The size of
an effect is the RMS of what it adds, over that floor: of the joint readings or, for effects of the body, of the path of
the centre of mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from blind.chain import Table
from blind.faults import FAULTS, KNOWN, UNKNOWN, draw_joints
from blind.robot import Parameters, Recording, Robot, gait_command, real_robot

# First seed of each set, a million each, and the sizes it draws from: no two have any in common.
SETS: dict[str, tuple[int, tuple[float, ...]]] = {
    "tune": (100_000_000, (1.2, 2.4, 6.0)),
    "calibrate": (200_000_000, (1.9, 4.2, 13.0)),
    "score": (300_000_000, (1.5, 3.0, 10.0)),
    "reduced": (400_000_000, (3.6, 5.0, 8.0)),  # for a test of the suite: large enough to be named
}
PER_SET = 1_000_000
RATE_HZ = 100.0
DURATION_S = 10.0
GAITS = 5
OTHER_ROBOTS = 3  # whose floor counts beside that of the case's own
PROBE_S = 5.0  # length of the runs that set the size of an effect
# Shares of the strata. The rest are single effects.
STRATA = {"no_gap": 0.3, "unknown": 0.1, "pair": 0.1, "left_out": 0.1}
STRATA_TO_SCORE = {**STRATA, "no_gap": 0.34}  # a hundred of 300, to see false alarms of two per cent


@dataclass(frozen=True)
class Effect:
    name: str
    stage: str
    joints: list[int] | None  # 1-based
    values: dict[str, float]
    size: float  # over the floor, as reached


@dataclass(frozen=True)
class Label:
    """The truth about a case."""

    stratum: str
    asked_size: float
    effects: list[Effect]
    floor_rad: float
    floor_m: float

    def mapping(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True)
class Case:
    """A robot with what is wrong in it, before it is run; ``rng`` makes the noise of its runs."""

    label: Label
    exclude: str | None  # taken out of the library when it is answered; for some a decoy
    gaits: list[tuple[float, float, float]]
    parameters: Parameters
    rng: np.random.Generator

    def runs(self) -> list[Recording]:
        """Once: the gaits, and the first one again."""
        robot = Robot(self.parameters)
        t = np.arange(round(DURATION_S * RATE_HZ)) / RATE_HZ
        return [robot.run(t, gait_command(t, *gait), self.rng) for gait in [*self.gaits, self.gaits[0]]]


def shares_of(set_name: str) -> dict[str, float]:
    """Shares of the strata in a set."""
    return STRATA_TO_SCORE if set_name == "score" else STRATA


def plan(
    number: int, cases: int, rng: np.random.Generator, shares: Mapping[str, float]
) -> tuple[str, tuple[str, ...]]:
    """Stratum and effects of the n-th of so many cases; names go round so that each is met."""
    quota = {s: round(share * cases) for s, share in shares.items()}
    stratum = "single"
    for name, count in quota.items():
        if number < count:
            stratum = name
            break
        number -= count
    if stratum == "single":
        return stratum, (KNOWN[number % len(KNOWN)],)
    if stratum == "no_gap":
        return stratum, ()
    if stratum == "unknown":
        return stratum, (UNKNOWN[number % len(UNKNOWN)],)
    if stratum == "left_out":
        return stratum, (KNOWN[(7 * number + 1) % len(KNOWN)],)
    names = [n for n in KNOWN if FAULTS[n].scaled and n != "encoder_noise"]
    first, second = rng.choice(names, 2, replace=False)
    return stratum, (str(first), str(second))


def _size_index(number: int, cases: int, rng: np.random.Generator, shares: Mapping[str, float]) -> int:
    """Single effects meet each size in turn, so that every effect is there at every size; the others draw one."""
    drawn, before = int(rng.integers(3)), sum(round(share * cases) for share in shares.values())
    single = number - before
    return drawn if single < 0 else (single // len(KNOWN) + single % len(KNOWN)) % 3


def make_case(set_name: str, seed: int, number: int, cases: int) -> Case:
    """The n-th of so many cases of a seed."""
    first, sizes = SETS[set_name]
    if not 0 <= seed < PER_SET:
        raise ValueError(f"--seed {seed}: 0 to {PER_SET - 1}")
    rng = np.random.default_rng([first + seed, number])
    shares = shares_of(set_name)
    stratum, names = plan(number, cases, rng, shares)
    asked = float(sizes[_size_index(number, cases, rng, shares)]) * float(rng.uniform(0.97, 1.03))
    real = real_robot(rng)
    gaits = [_draw_gait(rng) for _ in range(GAITS)]
    floor = _floor(real, gaits, int(rng.integers(1 << 31)))
    faulty, effects = real.copy(), []
    for name in names:
        faulty, effect = _put_in(name, faulty, real, gaits, floor, asked, rng)
        effects.append(effect)
    if stratum == "left_out":
        exclude: str | None = names[0]
    else:  # as many again have something taken out that is not theirs
        exclude = None
        if rng.random() < STRATA["left_out"] / (1 - STRATA["left_out"]):
            others = [n for n in KNOWN if n not in names]
            exclude = str(rng.choice(others))
    label = Label(stratum, round(asked, 3), effects, floor[0], floor[1])
    return Case(label, exclude, gaits, faulty, rng)


def _draw_gait(rng: np.random.Generator) -> tuple[float, float, float]:
    """alpha, beta in rad, omega in rad/s; slow ones swing wide, as on a real robot."""
    omega = float(np.exp(rng.uniform(np.log(1.0), np.log(5.0))))
    alpha = float(np.radians(min(70.0, rng.uniform(90.0, 150.0) / omega)))
    return alpha, float(np.radians(rng.uniform(60, 100))), omega


def _probes(
    parameters: Parameters, gaits: list[tuple[float, float, float]], seed: int, noiseless: bool
) -> tuple[Table, Table]:
    """Readings (T, k) and path (T, 2) on the slowest and the fastest gait."""
    t = np.arange(round(PROBE_S * RATE_HZ)) / RATE_HZ
    order = sorted(gaits, key=lambda g: g[2])
    robot = Robot(parameters.noiseless() if noiseless else parameters)
    made = [robot.run(t, gait_command(t, *g), np.random.default_rng(seed)) for g in (order[0], order[-1])]
    return np.concatenate([m.encoder_rad for m in made]), np.concatenate([m.pose[:, :2] for m in made])


def _rms(table: Table) -> float:
    return float(np.sqrt(np.mean(table**2)))


def _floor(real: Parameters, gaits: list[tuple[float, float, float]], seed: int) -> tuple[float, float]:
    """RMS between real robots without an effect, this one and others, and the nominal one: rad a joint, m."""
    rng = np.random.default_rng(seed)
    should_rad, should_m = _probes(Parameters(), gaits, seed, noiseless=True)
    found = [
        _probes(robot, gaits, seed, noiseless=False)
        for robot in (real, *(real_robot(rng) for _ in range(OTHER_ROBOTS)))
    ]
    return (
        _rms(np.stack([is_rad - should_rad for is_rad, _ in found])),
        _rms(np.stack([is_m - should_m for _, is_m in found])),
    )


def _put_in(
    name: str,
    onto: Parameters,
    real: Parameters,
    gaits: list[tuple[float, float, float]],
    floor: tuple[float, float],
    size: float,
    rng: np.random.Generator,
) -> tuple[Parameters, Effect]:
    """Scale the effect alone on the real robot until its gap is ``size`` floors; then add it to ``onto``.

    The gap is the RMS over the joints at fault, so that one bad joint of five is as visible there as five.
    """
    fault = FAULTS[name]
    joints = draw_joints(name, rng)
    at = np.arange(JOINT_COUNT) if joints is None else joints
    choices = int(rng.integers(1 << 31))
    clean_rad, clean_m = _probes(real, gaits, choices, noiseless=True)
    body = fault.stage == "body"

    def gap(magnitude: float) -> float:
        p = real.copy()
        fault.apply(p, at, magnitude, np.random.default_rng(choices))
        noise = p.reading_noise_rad.copy() if name == "encoder_noise" else None
        p = p.noiseless()
        if noise is not None:
            p.reading_noise_rad = noise
        rad, metres = _probes(p, gaits, choices, noiseless=name != "encoder_noise")
        return _rms(metres - clean_m) / floor[1] if body else _rms((rad - clean_rad)[:, at]) / floor[0]

    magnitude = float(np.sqrt(fault.low * fault.high))
    reached = gap(magnitude)
    if fault.scaled:
        low, high = np.log(fault.low), np.log(fault.high)
        for _ in range(12):
            if abs(np.log(max(reached, 1e-9) / size)) < 0.1:
                break
            if reached < size:
                low = np.log(magnitude)
            else:
                high = np.log(magnitude)
            guess = np.log(magnitude) + np.log(size / max(reached, 1e-9))  # as if proportional
            inside = low + 0.1 * (high - low) < guess < high - 0.1 * (high - low)
            magnitude = float(np.exp(guess if inside else 0.5 * (low + high)))
            reached = gap(magnitude)
    faulty = onto.copy()
    values = fault.apply(faulty, at, magnitude, np.random.default_rng(choices))
    listed = None if joints is None else [int(j) + 1 for j in joints]
    return faulty, Effect(
        name, fault.stage, listed, {k: float(v) for k, v in values.items()}, round(reached, 3)
    )


JOINT_COUNT = Parameters().joints.shape[1]
