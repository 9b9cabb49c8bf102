"""All that the search shares: prepared data, simulator, blocks with their allowed spread, folds, the measured
ground.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis import ground as ground_motion
from snakebot.diagnosis.allowance import bounded_share, rate_of, shift_limit_s, shifts_s
from snakebot.diagnosis.blocks import BlockMap, Difference, block_map, mean_difference
from snakebot.diagnosis.data import Data
from snakebot.diagnosis.floor import Floor, noise_floor
from snakebot.diagnosis.folds import Fold, folds
from snakebot.diagnosis.hypothesis import Hypothesis
from snakebot.diagnosis.score import SAG_TOLERANCE_RAD_NM, SHAPE_TOLERANCE, Scale
from snakebot.diagnosis.simulate import Simulator
from snakebot.diagnosis.smoothing import smoothed
from snakebot.effects.observed import Observed
from snakebot.effects.registry import find_effect
from snakebot.effects.spec import EffectSpec

if TYPE_CHECKING:
    from snakebot.physics import ChainModel

PARTS = 5  # of a sample's interval, for the motion between samples

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(eq=False)
class Context:
    """See the module. Blocks are those of the angles, then one for each feature of the ground."""

    data: Data
    simulator: Simulator
    floor: Floor
    scale: Scale  # of the angles
    ground: ground_motion.Ground | None
    ground_allowed_square: Floats  # (G,)
    ground_marks: (
        Floats  # (G, 5) of the tolerances of friction along, across, mass, ripple, and the readings' noise
    )
    folds: tuple[Fold, ...]
    observed: Observed
    nominal: list[Floats]  # predicted readings, (N, k) a run
    known: Mapping[str, float] = field(default_factory=dict)
    least_square: Floats | None = None  # (B,) see ``settle``
    seed: int = 0
    _ground_cache: dict[tuple[str, ...], Floats] = field(default_factory=dict)
    _lock: Lock = field(default_factory=Lock)

    @property
    def angle_blocks(self) -> BlockMap:
        return self.scale.blocks

    @property
    def block_run(self) -> Ints:
        """(B,) run of every block, ground included."""
        return (
            self.angle_blocks.run
            if self.ground is None
            else np.concatenate([self.angle_blocks.run, self.ground.run])
        )

    @property
    def block_joint(self) -> Ints:
        """(B,) 0-based joint of every block, -1 for the ground."""
        if self.ground is None:
            return self.angle_blocks.joint
        return np.concatenate([self.angle_blocks.joint, np.full(self.ground.count, -1, dtype=np.int64)])

    @property
    def allowed_square(self) -> Floats:
        return np.concatenate([self.scale.square, self.ground_allowed_square])

    @property
    def block_samples(self) -> Floats:
        """(B,) samples of every block; a feature of the ground counts as one."""
        ground = 0 if self.ground is None else self.ground.count
        return np.concatenate([self.angle_blocks.samples, np.ones(ground)])

    @property
    def selects(self) -> Bools:
        """(B,) blocks that may decide between explanations: not those of runs that the user holds out."""
        held = np.array([run.hold_out for run in self.data.runs])
        if held.all():
            return np.ones(self.block_run.size, dtype=bool)
        return np.asarray(~held[self.block_run])

    @property
    def shown_runs(self) -> tuple[int, ...]:
        """Runs on which before and after are told: those that the user holds out, else all."""
        held = tuple(i for i, run in enumerate(self.data.runs) if run.hold_out)
        return held or tuple(range(len(self.data.runs)))

    @property
    def scored_runs(self) -> tuple[int, ...]:
        """Runs that closure is taken on: those shown that no parameter was fitted to, each predicted from the others.

        None where only one motion may be fitted: what is left of it was fitted too.
        """
        held = any(run.hold_out for run in self.data.runs)
        return self.shown_runs if held or self.folds else ()

    @property
    def shown(self) -> Bools:
        """(B,) blocks of the shown runs."""
        return np.isin(self.block_run, self.shown_runs)

    @property
    def free_runs(self) -> tuple[int, ...]:
        """Runs that may be fitted."""
        return tuple(i for i, run in enumerate(self.data.runs) if not run.hold_out)

    @property
    def telling_runs(self) -> tuple[int, ...]:
        """Two of the free runs for a first look at what is dear to simulate: the largest gap, and the middling one."""
        blocks = self.angle_blocks
        gap = blocks.mean_square(self.residuals(self.nominal))
        size = {i: float(gap[blocks.run == i].mean()) for i in self.free_runs if np.any(blocks.run == i)}
        order = sorted(size, key=lambda i: (-size[i], i))
        return tuple(dict.fromkeys((order[0], order[len(order) // 2]))) if order else self.free_runs

    def settle(self, healthy: Bools, nominal_square: Floats) -> None:
        """From now on no explanation is credited for doing better than the nominal one where there is no gap.

        Args:
            healthy: (B,) blocks of joints (or of the ground) without a gap.
            nominal_square: (B,).
        """
        self.least_square = np.where(healthy, nominal_square, 0.0)

    def credited(self, mean_square: Floats) -> Floats:
        """(B,) mean squares, no better than nominal where there is nothing to explain."""
        return mean_square if self.least_square is None else np.maximum(mean_square, self.least_square)

    def score(self, mean_square: Floats) -> Floats:
        return np.asarray(-0.5 * np.log1p(mean_square / self.allowed_square))

    def gain(self, better: Floats, worse: Floats, rows: Bools | None = None) -> Difference:
        """Mean score over all deciding blocks of one explanation over another's, from their mean squares (B,)."""
        use = self.selects if rows is None else rows
        difference = (self.score(better) - self.score(worse))[use]
        return mean_difference(difference, self.block_run[use])

    def residuals(self, readings: Sequence[Floats], shift_s: Floats | None = None) -> list[Floats]:
        """Measured less predicted (N, k) a run; zero where not used.

        Args:
            shift_s: (k,) by which the readings come early.
        """
        out = []
        for run, reading in zip(self.data.runs, readings, strict=True):
            residual = run.measured_rad - reading
            if shift_s is not None and shift_s.any():
                residual -= shift_s * rate_of(reading, run.t_s)
            out.append(np.where(run.use, residual, 0.0))
        return out

    def shift_limits_s(self, hypothesis: Hypothesis) -> Floats:
        """(k,) how far an explanation may shift each joint in time."""
        limit = np.full(self.data.joints, shift_limit_s(self.data.robot.servo.time_constant_s))
        for term in hypothesis.terms:
            if "delay" in find_effect(term.effect).covers:
                limit[[j - 1 for j in term.joints] if term.joints is not None else slice(None)] = 0.0
        return limit

    def shifts_s(self, readings: Sequence[Floats], runs: Sequence[int], limit_s: Floats) -> Floats:
        """(k,) advance of each joint that suits some runs best; ``readings`` are of all runs."""
        if not limit_s.any() or not len(runs):
            return np.zeros_like(limit_s)
        picked = [self.data.runs[i] for i in runs]
        made = [readings[i] for i in runs]
        rate = np.concatenate([rate_of(r, run.t_s) for r, run in zip(made, picked, strict=True)])
        residual = np.concatenate([run.measured_rad - r for r, run in zip(made, picked, strict=True)])
        block = np.concatenate([self.angle_blocks.of_sample[i] for i in runs])
        return shifts_s(residual, rate, block, self.scale.square, limit_s)

    def ground_square(self, specs: Iterable[EffectSpec]) -> Floats:
        """(G,) squared errors of the ground's features under some effects; empty without a measured ground."""
        if self.ground is None:
            return np.zeros(0)
        return np.square(self.ground_left(specs, self.free_runs))

    def ground_left(
        self, specs: Iterable[EffectSpec], fitted: Sequence[int], runs: Sequence[int] | None = None
    ) -> Floats:
        """(G,) measured less predicted features, nan for runs not asked for.

        Friction and mass may be off by their tolerances, servos may ripple between samples, and the readings' noise may
        not be in the motion, as the ``fitted`` runs say; not what an effect sets itself.
        """
        assert self.ground is not None
        specs = tuple(specs)
        left = np.asarray(self.ground.value - self.ground_features(specs, runs))
        free = [2, 3, 4] if any("friction" in s.effect.covers for s in specs) else [0, 1, 2, 3, 4]
        marks = self.ground_marks[:, free]
        least = np.array([-1.0, -1.0, -1.0, 0.0, 0.0])[free]
        known = np.where(np.isin(self.ground.run, list(fitted)), left, np.nan)
        return np.asarray(left - marks @ bounded_share(known, marks, least, self.ground_allowed_square))

    def ground_features(self, specs: Iterable[EffectSpec], runs: Sequence[int] | None = None) -> Floats:
        """(G,) features that the measured joint angles make on this body, nan for runs not asked for."""
        assert self.ground is not None
        specs = tuple(s for s in specs if s.effect.stage in ("body", "sensor"))
        key = (*sorted(str(s) for s in specs), "" if runs is None else str(sorted(runs)))
        found = self._ground_cache.get(key)
        if found is None:
            stages = self.simulator.stages(specs)
            assert stages.model is not None
            angles = [
                stages.true_angle(run.t_s, measured)
                for run, measured in zip(self.data.runs, self.simulator.smooth, strict=True)
            ]
            found = ground_motion.predicted(self.ground, self.data, angles, stages.model, runs)
            with self._lock:
                self._ground_cache[key] = found
        return found


def make_context(data: Data, known: Mapping[str, float], seed: int) -> Context:
    """Prepare everything that does not depend on an explanation."""
    simulator = Simulator(data)
    blocks = block_map(data)
    nominal = [p.reading_rad for p in simulator.predict(())]
    floor = noise_floor(data, nominal)
    other = _with_lag(data, simulator, 1 + SHAPE_TOLERANCE)
    moved = [a - b for a, b in zip(nominal, other, strict=True)]
    tolerance = blocks.mean_square(moved)
    loads = [simulator.load(i) for i in range(len(data.runs))]
    tolerance += blocks.mean_square(
        [
            np.zeros_like(a) if load is None else SAG_TOLERANCE_RAD_NM * load
            for a, load in zip(nominal, loads, strict=True)
        ]
    )
    floor_square = np.square(floor.rad)[blocks.joint]
    measured = ground_motion.measured_ground(data, floor.like)
    allowed, marks = np.zeros(0), np.zeros((0, 5))
    if measured is not None:
        stages = simulator.stages(())
        assert stages.model is not None
        noisier = _noisier(data, simulator, floor)
        doubt, shaken = ground_motion.doubt(measured, data, simulator.smooth, noisier, stages.model)
        allowed = measured.floor_square + doubt
        marks = ground_motion.tolerance_marks(measured, data, simulator.smooth, stages.model)
        ripple = _between_samples(data, simulator, measured, nominal, stages.model)
        marks = np.column_stack([marks, ripple, -shaken])
    return Context(
        data=data,
        simulator=simulator,
        floor=floor,
        scale=Scale(blocks, floor_square, tolerance),
        ground=measured,
        ground_allowed_square=allowed,
        ground_marks=marks,
        folds=folds(data),
        observed=Observed(data.robot, data.runs),
        nominal=nominal,
        known=known,
        seed=seed,
    )


def _between_samples(
    data: Data,
    simulator: Simulator,
    ground: ground_motion.Ground,
    nominal: Sequence[Floats],
    model: ChainModel,
) -> Floats:
    """(G,) features of the nominal motion less those of its samples, smoothed as the measured ones are.

    Held set-points make an ideal servo ripple between the samples, which costs speed that no replay of samples sees.
    A real servo ripples less.
    """
    fine = [simulator.between_samples(i, PARTS) for i in range(len(data.runs))]
    whole = ground_motion.predicted(ground, data, [a for _, a in fine], model, t_s=[t for t, _ in fine])
    coarse = [smoothed(run.t_s, angle) for run, angle in zip(data.runs, nominal, strict=True)]
    return np.nan_to_num(whole - ground_motion.predicted(ground, data, coarse, model))


def _noisier(data: Data, simulator: Simulator, floor: Floor) -> list[Floats]:
    """Measured angles with as much white noise again as they have already, smoothed as for a replay."""
    rng = np.random.default_rng(0)
    return [
        smoothed(run.t_s, angle + rng.normal(size=angle.shape) * floor.white_rad)
        for run, angle in zip(data.runs, simulator.measured, strict=True)
    ]


def _with_lag(data: Data, simulator: Simulator, factor: float) -> list[Floats]:
    """Nominal readings with the servo's time constant changed."""
    servo = data.robot.servo
    robot = data.robot.model_copy(
        update={"servo": servo.model_copy(update={"time_constant_s": servo.time_constant_s * factor})}
    )
    other = Simulator(replace(data, robot=robot))
    return [p.reading_rad for p in other.predict(())]
