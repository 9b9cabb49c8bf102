"""Robots as they are after some use: every joint has a little of everything, and one or two faults stand out.

Each joint has a lag, a delay, an offset, play and friction of its own. On that come one or two *dominant* faults, each
as large as half of the gap or so. The label tells the share of every effect in the gap of the readings r (robot less
nominal prediction) over the motions of the session, from start to end: a battery that sags and an offset share out five
seconds otherwise than ten. With the nominal robot R(S) that has only the effects S,

    v(S) = |r|^2 - |R(all) - R(S)|^2

is what these effects explain, as a closure counts it. The share of an effect is the mean of what it adds to nothing and
of what goes when it alone is taken away, over |r|^2: the Shapley value, wherever effects add up in the readings. What a
healthy robot is off by within its tolerance is one of the S. In joint angles it is a lag other than the stated one, so
that its share is one of being late: who sees only the gap cannot tell 2 ms of tolerance and 2 ms of fault apart.

The spreads are those of real servos, none is taken from the product. Makers state a play of 0.25 deg (Dynamixel
X, e-manual) and at most 0.5 deg (Feetech STS3215), and 0.8 to 1.3 deg are measured on the latter (public tests by
Robonine and in the SO-ARM100 project). ``tools/baseline_real`` on an arm of five such servos gives 1.2 to 1.7 deg where
no gravity bears on a joint, 49 to 60 ms of delay and lag (standard deviation 9 %), of which 16 to 60 ms delay, and
offsets of 0.05, 0.08 and 0.6 deg; 2 to 4 deg hold the sag of an arm and are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from blind.cases import (
    PROBE_S,
    Case,
    Effect,
    Label,
    Stage,
    draw_build,
    floor_of,
    rms,
    scaled,
    ticks,
)
from blind.chain import Floats
from blind.faults import FAULTS, Fault, draw_joints, go_together
from blind.motions import Motion, draw_motions
from blind.records import records_of
from blind.robot import Build, Parameters, Robot, real_robot
from blind.worn_kinds import TOLERANCE, kind_of

# Of a joint's own wear. Standard deviations; of what cannot be negative, of its logarithm.
LAG_SPREAD = 0.1
COMMON_DELAY_S = (0.0, 0.008)  # of all joints, evenly
DELAY_SPREAD_S = 0.002
OFFSET_SPREAD_DEG = 0.5
PLAY_DEG, PLAY_SPREAD = 0.5, 0.6
FRICTION_NM, FRICTION_SPREAD = 0.05, 0.6

# What may stand out: scaled effects of link, servo and sensor that show in the joint angles.
STAND_OUT = (
    "command_delay", "servo_lag", "second_order", "rate_limit", "torque_speed", "torque_limit", "voltage_sag",
    "deadband", "backlash", "joint_friction", "compliance", "servo_offset", "command_gain", "encoder_offset",
    "encoder_gain",
)  # fmt: skip
TWO = 0.4  # share of the robots with two of them
# A dominant fault's mean square over that of all the rest: with one, with two. Drawn evenly in the logarithm.
OVER_THE_REST = {1: (1.5, 4.0), 2: (1.0, 2.0)}
Draw = np.random.Generator


@dataclass(frozen=True, eq=False)
class Part:
    """One effect of a worn robot, on whatever joints it has it. ``put_in`` leaves all that is not its own alone.

    A part is equal to itself only: two of the same values may stand side by side.
    """

    name: str
    stage: str
    joints: list[int] | None  # 1-based
    values: dict[str, float]
    put_in: tuple[Callable[[Parameters], Any], ...]
    dominant: bool = False


def make_worn(seed: int, number: int) -> Case:
    """The n-th worn robot of a seed, which is of a set: see ``cases.SETS``."""
    rng, records = np.random.default_rng([seed, number]), records_of(seed, number)
    build = draw_build(rng)
    healthy = real_robot(rng, build)
    motions = draw_motions(rng, records.motions, build.joints)
    stage = Stage(build, motions)
    floor = floor_of(healthy, stage, int(rng.integers(1 << 31)))
    count = 2 if rng.random() < TWO else 1
    names = [str(rng.choice(STAND_OUT))]
    if count == 2:
        names.append(
            str(
                rng.choice(
                    [n for n in STAND_OUT if go_together(names[0], n) and kind_of(n) != kind_of(names[0])]
                )
            )
        )
    chosen = [(name, draw_joints(name, rng, build.joints)) for name in names]
    wear = _wear(chosen, build.joints, rng)
    bench = Bench.short(healthy, stage)
    parts = _with_dominant(wear, chosen, bench, rng)
    robot = _built(healthy, parts)
    told, tolerance = shares(Bench(healthy, build, tuple(motions), records.duration_s), parts)
    sound = bench.readings(())
    effects = [
        Effect(
            part.name, part.stage, part.joints, part.values,
            round(rms(bench.readings([part]) - sound) / floor[0], 3), round(share, 4), part.dominant,
        )
        for part, share in zip(parts, told, strict=True)
    ]  # fmt: skip
    off = round(rms(sound - bench.readings((), nominal=True)) / floor[0], 3)
    effects.append(Effect(TOLERANCE, "servo", None, {}, off, round(tolerance, 4)))
    effects.sort(key=lambda effect: (not effect.dominant, -(effect.share or 0.0)))
    label = Label("worn", 0.5, effects, floor[0], floor[1], build.joints)
    return Case(label, None, motions, build, robot, rng, records=records)


def _wear(chosen: Sequence[tuple[str, np.ndarray | None]], count: int, rng: Draw) -> list[Part]:
    """What every joint has, but for the joints on which a dominant fault writes the same."""
    lag = 1 + LAG_SPREAD * rng.normal(size=count)
    delay = np.maximum(0.0, rng.uniform(*COMMON_DELAY_S) + DELAY_SPREAD_S * rng.normal(size=count))
    offset = np.radians(OFFSET_SPREAD_DEG * rng.normal(size=count))
    play = np.radians(PLAY_DEG * np.exp(PLAY_SPREAD * rng.normal(size=count)))
    friction = FRICTION_NM * np.exp(FRICTION_SPREAD * rng.normal(size=count))

    def left_to(name: str) -> np.ndarray:
        left = np.ones(count, dtype=bool)
        for other, joints in chosen:
            if joints is not None and not go_together(name, other):
                left[joints] = False
        return left

    def row(name: str, of: str, values: Floats, factor: bool = False) -> Part:
        at = left_to(name)

        def put_in(p: Parameters) -> None:
            p.joint(of)[at] = p.joint(of)[at] * values[at] if factor else values[at]

        return Part(name, "servo", [int(j) + 1 for j in np.flatnonzero(at)], {}, (put_in,))

    def late(p: Parameters) -> None:
        p.delay_s += delay

    wear = [
        row("servo_lag", "lag_s", lag, factor=True),
        Part("command_delay", "link", None, {}, (late,)),
        row("servo_offset", "offset_rad", offset),
        row("backlash", "play_rad", play),
        row("joint_friction", "coulomb_nm", friction),
    ]
    return [part for part in wear if part.joints != []]


def _with_dominant(
    wear: list[Part],
    chosen: Sequence[tuple[str, np.ndarray | None]],
    bench: Bench,
    rng: Draw,
) -> list[Part]:
    """The faults that stand out, scaled against the wear, and the wear; an effect that is both is one."""
    parts = {part.name: part for part in wear}
    healthy = bench.healthy
    rest = bench.gap(_built(healthy, wear))
    bounds = np.log(OVER_THE_REST[len(chosen)])
    for name, joints in chosen:
        fault = FAULTS[name]
        at = np.arange(healthy.joint_count) if joints is None else joints
        size = rest * float(np.exp(0.5 * rng.uniform(*bounds)))
        seed = int(rng.integers(1 << 31))

        def gap(magnitude: float, fault: Fault = fault, at: np.ndarray = at, seed: int = seed) -> float:
            made = healthy.copy()
            fault.apply(made, at, magnitude, np.random.default_rng(seed))
            return bench.gap(made)

        magnitude, _ = scaled(fault, size, gap)
        values = fault.apply(healthy.copy(), at, magnitude, np.random.default_rng(seed))
        own = parts.get(name)
        listed = None if joints is None else [int(j) + 1 for j in joints]
        put_in = (*(own.put_in if own else ()), _putting(fault, at, magnitude, seed))
        told = {key: float(value) for key, value in values.items()}
        parts[name] = Part(name, fault.stage, listed, told, put_in, dominant=True)
    return list(parts.values())


def _putting(fault: Fault, at: np.ndarray, magnitude: float, seed: int) -> Callable[[Parameters], Any]:
    return lambda p: fault.apply(p, at, magnitude, np.random.default_rng(seed))


def _built(healthy: Parameters, parts: Sequence[Part]) -> Parameters:
    made = healthy.copy()
    for part in parts:
        for put_in in part.put_in:
            put_in(made)
    return made


@dataclass
class Bench:
    """A healthy robot, and what perfect sensors read of it with some effects put in; each is run once."""

    healthy: Parameters
    build: Build
    motions: tuple[Motion, ...]
    duration_s: float
    _known: dict[tuple[bool, tuple[Part, ...]], Floats] = field(default_factory=dict, repr=False)

    @classmethod
    def short(cls, healthy: Parameters, stage: Stage) -> Bench:
        """The first seconds of the slowest, the middle and the fastest motion: to try how large a fault must be."""
        order = sorted(stage.motions, key=lambda motion: motion.omega_rad_s)
        return cls(healthy, stage.build, (order[0], order[len(order) // 2], order[-1]), PROBE_S)

    def readings(self, parts: Sequence[Part], *, nominal: bool = False) -> Floats:
        """(T, k) rad, motions one after the other; ``nominal``: of a robot without any tolerance."""
        key = (nominal, tuple(parts))
        if key not in self._known:
            base = Parameters.of(self.build) if nominal else self.healthy
            self._known[key] = self.of(_built(base, parts))
        return self._known[key]

    def of(self, parameters: Parameters) -> Floats:
        """The same of any robot of this build."""
        t, joints = ticks(self.build, self.duration_s), self.build.joints
        robot = Robot(parameters.noiseless())
        return np.concatenate(
            [
                robot.run(t, motion.command(t, joints), np.random.default_rng(0)).encoder_rad
                for motion in self.motions
            ]
        )

    def gap(self, parameters: Parameters) -> float:
        """RMS between a robot and the healthy one, over all joints, rad."""
        return rms(self.of(parameters) - self.readings(()))


def shares(bench: Bench, parts: Sequence[Part]) -> tuple[list[float], float]:
    """The share of each effect in the gap, and that of the tolerance of the healthy robot; see the module."""
    nominal, true = bench.readings((), nominal=True), bench.readings(parts)
    gap2 = rms(true - nominal) ** 2

    def explained(some: Sequence[Part], *, healthy: bool = False) -> float:
        """v(S); ``healthy``: with the tolerance."""
        return gap2 - rms(true - bench.readings(some, nominal=not healthy)) ** 2

    def share(alone: float, without: float) -> float:
        return 0.5 * (alone + gap2 - without) / gap2

    return [
        share(explained([part]), explained([other for other in parts if other is not part], healthy=True))
        for part in parts
    ], share(explained((), healthy=True), explained(parts))
