"""What the recorded runs would have shown under any effects: readings of the joints, and the motion over ground."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from threading import Lock

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence import ground as ground_motion
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.effects.spec import EffectSpec


@dataclass(frozen=True, eq=False)
class Predictor:
    """Predictions of all runs. May be used from several threads.

    Attributes:
        simulator: of the runs.
        nominal: readings (N, k) a run without any effect.
        ground: what was measured of the motion over ground, which is what is predicted of it.
    """

    simulator: Simulator
    nominal: tuple[Floats, ...]
    ground: ground_motion.GroundFeatures | None
    # of the ground: what a run shows under some effects, by their texts and its place; one after another, fits of some
    # of the runs ask for the same
    _cache: dict[tuple[tuple[str, ...], int], Floats] = field(default_factory=dict)
    _lock: Lock = field(default_factory=Lock)

    def with_simulator(self, simulator: Simulator) -> Predictor:
        """The same of another robot, or from other measured angles; joints that no effect acts on stay nominal."""
        return Predictor(simulator, self.nominal, self.ground)

    def readings(self, specs: Sequence[EffectSpec], runs: Sequence[int], rough: bool = False) -> list[Floats]:
        """Readings (N, k) of some runs; joints that no effect acts on are taken from the nominal prediction."""
        if all(s.effect.stage == "body" for s in specs):
            return [self.nominal[i] for i in runs]
        every = set(range(self.simulator.data.joints))
        acted = set().union(
            *(
                every if s.joints is None else {j - 1 for j in s.joints}
                for s in specs
                if s.effect.stage != "body"
            )
        )
        made = self.simulator.predict(specs, runs, rough=rough, columns=sorted(acted))
        out = []
        for index, predicted in zip(runs, made, strict=True):
            reading = predicted.reading_rad
            gone = ~np.isfinite(reading)
            out.append(np.where(gone, self.nominal[index], reading) if gone.any() else reading)
        return out

    def ground_features(self, specs: Iterable[EffectSpec], runs: Sequence[int] | None = None) -> Floats:
        """(G,) features that the measured joint angles make on this body, nan for runs not asked for."""
        ground, simulator = self.ground, self.simulator
        assert ground is not None
        specs = tuple(s for s in specs if s.effect.stage in ("body", "sensor"))
        name = tuple(sorted(str(s) for s in specs))
        wanted = range(len(simulator.data.runs)) if runs is None else runs
        missing = [i for i in wanted if (name, i) not in self._cache]
        if missing:
            stages = simulator.stages(specs)
            assert stages.model is not None
            angles = [
                stages.true_angle(run.t_s, measured)
                for run, measured in zip(simulator.data.runs, simulator.smooth, strict=True)
            ]
            made = ground_motion.predicted(ground, simulator.data, angles, stages.model, missing)
            with self._lock:
                self._cache.update(((name, i), made[ground.run == i]) for i in missing)
        out = np.full(ground.count, np.nan)
        for i in wanted:
            out[ground.run == i] = self._cache[name, i]
        return out
