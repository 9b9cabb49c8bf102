"""All that the search shares: prepared data, simulator, blocks with their allowed spread, folds, the measured
ground.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis import ground as ground_motion
from snakebot.diagnosis.blocks import BlockMap, Difference, block_map, mean_difference
from snakebot.diagnosis.data import Data
from snakebot.diagnosis.floor import Floor, noise_floor
from snakebot.diagnosis.folds import Fold, folds
from snakebot.diagnosis.score import LAG_TOLERANCE, Scale
from snakebot.diagnosis.simulate import Simulator, smoothed
from snakebot.effects.observed import Observed
from snakebot.effects.spec import EffectSpec

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
    def selects(self) -> Bools:
        """(B,) blocks that may decide between explanations: not those of runs that the user holds out."""
        held = np.array([run.hold_out for run in self.data.runs])
        if held.all():
            return np.ones(self.block_run.size, dtype=bool)
        return np.asarray(~held[self.block_run])

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

    def residuals(self, readings: Sequence[Floats]) -> list[Floats]:
        """Measured less predicted (N, k) a run; zero where not used."""
        return [
            np.where(run.use, run.measured_rad - reading, 0.0)
            for run, reading in zip(self.data.runs, readings, strict=True)
        ]

    def ground_square(self, specs: Iterable[EffectSpec]) -> Floats:
        """(G,) squared errors of the ground's features under some effects; empty without a measured ground."""
        if self.ground is None:
            return np.zeros(0)
        wanted = self.ground.value
        return np.square(self.ground_features(specs) - wanted)

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
    floor = noise_floor(data)
    blocks = block_map(data)
    nominal = [p.reading_rad for p in simulator.predict(())]
    other = _with_lag(data, simulator, 1 + LAG_TOLERANCE)
    moved = [a - b for a, b in zip(nominal, other, strict=True)]
    tolerance = blocks.mean_square(moved)
    floor_square = np.square(floor.rad)[blocks.joint]
    measured = ground_motion.measured_ground(data)
    allowed = np.zeros(0)
    if measured is not None:
        stages = simulator.stages(())
        assert stages.model is not None
        noisier = _noisier(data, simulator, floor)
        spread = ground_motion.tolerance_square(measured, data, simulator.smooth, noisier, stages.model)
        allowed = measured.floor_square + spread
    return Context(
        data=data,
        simulator=simulator,
        floor=floor,
        scale=Scale(blocks, floor_square, tolerance),
        ground=measured,
        ground_allowed_square=allowed,
        folds=folds(data),
        observed=Observed(data.robot, data.runs),
        nominal=nominal,
        known=known,
        seed=seed,
    )


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
    other = Simulator(Data(robot, data.runs, data.spikes))
    return [p.reading_rad for p in other.predict(())]
