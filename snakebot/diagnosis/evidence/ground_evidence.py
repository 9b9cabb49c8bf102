"""The measured motion over ground, and how far it may be off without being evidence of anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence import ground as ground_motion
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.floor import Floor
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.diagnosis.evidence.tolerance import bounded_share
from snakebot.smoothing import smoothed

if TYPE_CHECKING:
    from snakebot.physics import ChainModel
from snakebot.diagnosis.sizes import BEYOND_CHANCE, HALF, LITTLE, MUCH

# How far apart the steps are at most, s. Measured with a servo of 30 ms behind set-points at 50 Hz: steps of 4 ms give
# another ripple altogether, steps of 2 ms the same within a fifth.
SUBSTEP_S = 0.001
ADDED_SPREAD = HALF  # standard deviation of the shares of ripple and noise, which are never negative
# Standard deviation of the ripple's share from run to run: a servo smooths a slow motion more than a fast one.
RIPPLE_SPREAD = MUCH
RIPPLE_SHAPE = LITTLE  # share of the ripple by which that of a sound servo differs from window to window


@dataclass(frozen=True, eq=False)
class GroundTolerance:
    """What the motion over ground may be off by: shares of m marks, each believed to be near zero.

    Attributes:
        marks: (G, m) change of the features by a share of one.
        least, most: (m,) bounds of the shares.
        spread: (m,) their standard deviations.
        of_friction: (m,) marks of what an effect may set itself.
    """

    marks: Floats
    least: Floats
    most: Floats
    spread: Floats
    of_friction: Bools

    @staticmethod
    def of(numbers: Floats, ripple: Floats, shaken: Floats, run: Ints) -> GroundTolerance:
        """
        Args:
            numbers: (G, 3 n) by standard deviations of friction along, friction across and mass, n times.
            ripple: (G,) by all that the servos do between samples.
            shaken: (G,) by noise of the readings that is no motion.
            run: (G,) of each feature.
        """
        by_run = np.stack([np.where(run == r, ripple, 0.0) for r in np.unique(run)], axis=1)
        kinds = (
            (numbers, -BEYOND_CHANCE, BEYOND_CHANCE, 1.0),
            (np.column_stack([ripple, shaken]), 0.0, 1.0, ADDED_SPREAD),
            (by_run, -BEYOND_CHANCE * RIPPLE_SPREAD, BEYOND_CHANCE * RIPPLE_SPREAD, RIPPLE_SPREAD),
        )
        box = np.concatenate([np.tile(kind[1:], (kind[0].shape[1], 1)) for kind in kinds])
        marks = np.column_stack([kind[0] for kind in kinds])
        of_friction = (np.arange(marks.shape[1]) % 3 != 2) & (np.arange(marks.shape[1]) < numbers.shape[1])
        return GroundTolerance(marks, box[:, 0], box[:, 1], box[:, 2], of_friction)

    def taken_off(self, residual: Floats, known: Bools, allowed_square: Floats, but: Bools) -> Floats:
        """(G,) what is left of a residual, with shares as those rows say that are ``known`` (G,); without marks ``but``
        (m,).
        """
        use = ~but
        marks = self.marks[:, use]
        share = bounded_share(
            np.where(known, residual, np.nan),
            marks,
            self.least[use],
            self.most[use],
            self.spread[use],
            allowed_square,
        )
        return np.asarray(residual - marks @ share)


@dataclass(frozen=True, eq=False)
class GroundEvidence:
    """Features of the motion over ground.

    Attributes:
        features: as measured; G of them.
        allowed_square: (G,) squared allowed spread.
        tolerance: what they may be off by beside.
    """

    features: ground_motion.GroundFeatures
    allowed_square: Floats
    tolerance: GroundTolerance

    @property
    def tolerance_square(self) -> Floats:
        """(G,) squared spread of the features by all that they may be off by."""
        return np.asarray(np.square(self.tolerance.marks * self.tolerance.spread).sum(axis=1))

    def residuals(self, predicted: Floats, fitted: Sequence[int], *, friction_is_set: bool) -> Floats:
        """(G,) measured less predicted features (G,), nan where these are.

        Friction and mass may be off by their tolerances, servos may ripple between samples, and the readings' noise may
        not be in the motion, as the ``fitted`` runs say. ``friction_is_set``: an effect sets it, so no tolerance.
        """
        known = np.isin(self.features.run, list(fitted))
        left = np.asarray(self.features.value - predicted)
        return self.tolerance.taken_off(
            left, known, self.allowed_square, self.tolerance.of_friction & friction_is_set
        )


def ground_evidence(
    data: Data, simulator: Simulator, nominal: Sequence[Floats], floor: Floor
) -> GroundEvidence | None:
    """The evidence of a session; None where it says nothing of the ground. ``nominal``: readings (N, k) a run."""
    measured = ground_motion.measured_ground(data, floor.like)
    if measured is None:
        return None
    model = simulator.stages(()).model
    assert model is not None
    noisier = _noisier(data, simulator, floor)
    doubt, shaken = ground_motion.doubt(measured, data, simulator.smooth, noisier, model)
    tolerances = ground_motion.tolerance_marks(measured, data, simulator.smooth, model)
    ripple = _between_samples(data, simulator, measured, nominal, model)
    tolerance = GroundTolerance.of(tolerances, ripple, -shaken, measured.run)
    doubt += np.square(RIPPLE_SHAPE * ripple)
    return GroundEvidence(measured, measured.floor_square + doubt, tolerance)


def _between_samples(
    data: Data,
    simulator: Simulator,
    ground: ground_motion.GroundFeatures,
    nominal: Sequence[Floats],
    model: ChainModel,
) -> Floats:
    """(G,) features of the nominal motion less those of its samples, smoothed as the measured ones are.

    Held set-points make an ideal servo ripple between the samples, which costs speed that no replay of samples sees.
    A real servo ripples less.
    """
    parts = [ceil(run.period_s / SUBSTEP_S) for run in data.runs]
    fine = [simulator.between_samples(i, p) for i, p in enumerate(parts)]
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
