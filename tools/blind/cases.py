"""Which cases there are, and how large their effects: drawn from a seed, scaled to the noise floor.

Robots have 3 to 12 joints, other lags, rates and motions, all of which the session says.

The floor of a case is what robots like its own differ by from the nominal one without any effect: mass, friction, lag
and play off within their tolerance, plus sensor noise. One robot alone would not do: one that happens to be nearly
nominal has hardly a floor, and an effect of ten such floors is one that nobody could tell from healthy robots. The
size of an effect is the RMS of what it adds, over that floor: of the joint readings or, for effects of the body, of the
path of the centre of mass; of the speed along it, where a lab records no more.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from blind.chain import Floats
from blind.faults import FAULTS, KNOWN, UNKNOWN, Fault, draw_joints, go_together
from blind.motions import Motion, draw_motions
from blind.records import Records, records_of, speed_along
from blind.robot import Build, Parameters, Recording, Robot, real_robot

# First seed of each set, a million each, and the sizes it draws from: no two have any in common.
SETS: dict[str, tuple[int, tuple[float, ...]]] = {
    "tune": (100_000_000, (1.2, 2.4, 6.0)),
    "calibrate": (200_000_000, (1.9, 4.2, 13.0)),
    "score": (300_000_000, (1.5, 3.0, 10.0)),
    "reduced": (400_000_000, (3.6, 5.0, 8.0)),  # for a test of the suite: large enough to be named
    "triple": (900_000_000, (3.3, 5.5, 9.0)),
    # how large a dominant fault is beside the rest is drawn in ``worn``
    "worn": (500_000_000, ()),
    "worn_calibrate": (1_000_000_000, ()),
}
WORN_SETS = ("worn", "worn_calibrate")
CALIBRATING_SETS = ("calibrate", "worn_calibrate")
PER_SET = 1_000_000
RATES_HZ = (50.0, 100.0, 100.0, 200.0)  # one is drawn
LAGS_S = (
    0.015,
    0.08,
)  # bounds of the nominal lag, evenly in its logarithm; the built-in robot's for half of the cases
JOINTS_FROM_TO = (3, 12)  # as many as the built-in robot has for half of the cases
OTHER_ROBOTS = 3  # whose floor counts beside that of the case's own
PROBE_S = 5.0  # length of the runs that set the size of an effect
SEVERAL = {"pair": 2, "triple": 3}  # strata of robots with as many effects
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
    share: float | None = None  # of the gap of a worn robot; see ``worn``
    dominant: bool = False


@dataclass(frozen=True)
class Label:
    """The truth about a case."""

    stratum: str
    asked_size: float
    effects: list[Effect]
    floor_rad: float
    floor_m: float
    joints: int = 5  # of the robot

    def mapping(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True)
class Case:
    """A robot with what is wrong in it, before it is run; ``rng`` makes the noise of its runs, ``sound`` is the same
    robot with nothing wrong, where that is kept.
    """

    label: Label
    exclude: str | None  # taken out of the library when it is answered; for some a decoy
    motions: list[Motion]
    build: Build
    parameters: Parameters
    rng: np.random.Generator
    sound: Parameters | None = None
    records: Records = field(default_factory=Records)

    def runs(self) -> list[Recording]:
        """Once: the motions, and the first one again."""
        robot, t = Robot(self.parameters), ticks(self.build, self.records.duration_s)
        return [
            robot.run(t, motion.command(t, self.build.joints), self.rng)
            for motion in [*self.motions, self.motions[0]]
        ]


def ticks(build: Build, duration_s: float) -> Floats:
    """Times (T,) at which a robot is commanded and read."""
    return np.arange(round(duration_s * build.rate_hz)) / build.rate_hz


def shares_of(set_name: str) -> dict[str, float]:
    """Shares of the strata in a set."""
    if set_name == "triple" or set_name in WORN_SETS:
        return {set_name.removesuffix("_calibrate"): 1.0}
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
    chosen = [str(rng.choice(names))]
    while len(chosen) < SEVERAL[stratum]:
        chosen.append(str(rng.choice([n for n in names if all(go_together(c, n) for c in chosen)])))
    return stratum, tuple(chosen)


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
    if set_name in WORN_SETS:
        from blind.worn import make_worn

        return make_worn(first + seed, number)
    rng = np.random.default_rng([first + seed, number])
    records = records_of(first + seed, number)
    shares = shares_of(set_name)
    stratum, names = plan(number, cases, rng, shares)
    asked = float(sizes[_size_index(number, cases, rng, shares)]) * float(rng.uniform(0.97, 1.03))
    build = draw_build(rng)
    real = real_robot(rng, build)
    motions = draw_motions(rng, records.motions, build.joints)
    stage = Stage(build, motions, records.pose)
    floor = floor_of(real, stage, int(rng.integers(1 << 31)))
    faulty, effects = real.copy(), []
    for name in names:
        faulty, effect = _put_in(name, faulty, real, stage, floor, asked, rng)
        effects.append(effect)
    if stratum == "left_out":
        exclude: str | None = names[0]
    else:  # as many again have something taken out that is not theirs
        exclude = None
        if rng.random() < STRATA["left_out"] / (1 - STRATA["left_out"]):
            others = [n for n in KNOWN if n not in names]
            exclude = str(rng.choice(others))
    label = Label(stratum, round(asked, 3), effects, floor[0], floor[1], build.joints)
    return Case(label, exclude, motions, build, faulty, rng, real, records)


def draw_build(rng: np.random.Generator) -> Build:
    """What the lab says of a robot."""
    joints = (
        Build().joints if rng.random() < 0.5 else int(rng.integers(JOINTS_FROM_TO[0], JOINTS_FROM_TO[1] + 1))
    )
    lag_s = Build().lag_s if rng.random() < 0.5 else float(np.exp(rng.uniform(*np.log(LAGS_S))))
    return Build(joints, round(lag_s, 4), float(rng.choice(RATES_HZ)))


@dataclass(frozen=True)
class Stage:
    """On what the size of an effect is taken. ``pose``: whether the lab records one; else a speed alone shows it."""

    build: Build
    motions: list[Motion]
    pose: bool = True


def probes(parameters: Parameters, stage: Stage, seed: int, noiseless: bool) -> tuple[Floats, Floats]:
    """Readings (T, k) on the slowest and the fastest motion, and what is recorded of the way: the path (T, 2), or the
    speed along it of each (2, 1).
    """
    t = ticks(stage.build, PROBE_S)
    order = sorted(stage.motions, key=lambda motion: motion.omega_rad_s)
    robot = Robot(parameters.noiseless() if noiseless else parameters)
    made = [
        robot.run(t, motion.command(t, stage.build.joints), np.random.default_rng(seed))
        for motion in (order[0], order[-1])
    ]
    way = [m.pose[:, :2] if stage.pose else np.array([[speed_along(m)]]) for m in made]
    return np.concatenate([m.encoder_rad for m in made]), np.concatenate(way)


def rms(table: Floats) -> float:
    return float(np.sqrt(np.mean(table**2)))


def floor_of(real: Parameters, stage: Stage, seed: int) -> tuple[float, float]:
    """RMS between real robots without an effect, this one and others, and the nominal one: rad a joint, and m, or m/s
    where a speed alone is recorded.
    """
    rng = np.random.default_rng(seed)
    should_rad, should_m = probes(Parameters.of(stage.build), stage, seed, noiseless=True)
    found = [
        probes(robot, stage, seed, noiseless=False)
        for robot in (real, *(real_robot(rng, stage.build) for _ in range(OTHER_ROBOTS)))
    ]
    return (
        rms(np.stack([is_rad - should_rad for is_rad, _ in found])),
        rms(np.stack([is_m - should_m for _, is_m in found])),
    )


def scaled(fault: Fault, size: float, gap: Callable[[float], float]) -> tuple[float, float]:
    """The magnitude of a fault that leaves a gap of this size, within a tenth if it can; and the size reached."""
    magnitude = float(np.sqrt(fault.low * fault.high))
    reached = gap(magnitude)
    if not fault.scaled:
        return magnitude, reached
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
    return magnitude, reached


def _put_in(
    name: str,
    onto: Parameters,
    real: Parameters,
    stage: Stage,
    floor: tuple[float, float],
    size: float,
    rng: np.random.Generator,
) -> tuple[Parameters, Effect]:
    """Scale the effect alone on the real robot until its gap is ``size`` floors; then add it to ``onto``.

    The gap is the RMS over the joints at fault, so that one bad joint of five is as visible there as five.
    """
    fault = FAULTS[name]
    joints = draw_joints(name, rng, real.joint_count)
    at = np.arange(real.joint_count) if joints is None else joints
    choices = int(rng.integers(1 << 31))
    clean_rad, clean_m = probes(real, stage, choices, noiseless=True)
    body = fault.stage == "body"

    def gap(magnitude: float) -> float:
        p = real.copy()
        fault.apply(p, at, magnitude, np.random.default_rng(choices))
        noise = p.reading_noise_rad.copy() if name == "encoder_noise" else None
        p = p.noiseless()
        if noise is not None:
            p.reading_noise_rad = noise
        rad, metres = probes(p, stage, choices, noiseless=name != "encoder_noise")
        return rms(metres - clean_m) / floor[1] if body else rms((rad - clean_rad)[:, at]) / floor[0]

    magnitude, reached = scaled(fault, size, gap)
    faulty = onto.copy()
    values = fault.apply(faulty, at, magnitude, np.random.default_rng(choices))
    listed = None if joints is None else [int(j) + 1 for j in joints]
    return faulty, Effect(
        name, fault.stage, listed, {k: float(v) for k, v in values.items()}, round(reached, 3)
    )
