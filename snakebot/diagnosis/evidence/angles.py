"""The measured joint angles, block by block, and how far each block may be off without being evidence of anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.blocks import BlockMap
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.tolerance import ShiftLimits, StackedTimes, shifts_s


@dataclass(frozen=True, eq=False)
class AngleEvidence:
    """The joint angles of all runs.

    Attributes:
        data: the runs.
        blocks: which block each sample belongs to; B blocks in all.
        floor_square: (B,) squared noise floor, rad^2.
        tolerance_square: (B,) mean square that the tolerance of a sound servo brings in, rad^2.
        misfit_square: (B,) mean square that all everyday effects together leave over, rad^2: the error of the library's
            effects themselves. Fits and scores allow for it.
    """

    data: Data
    blocks: BlockMap
    floor_square: Floats
    tolerance_square: Floats
    misfit_square: Floats | float = 0.0
    _times: dict[tuple[int, ...], StackedTimes] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def allowed_square(self) -> Floats:
        """(B,) squared allowed spread: noise floor and tolerance."""
        return self.floor_square + self.tolerance_square

    @cached_property
    def fitted_square(self) -> Floats:
        """(B,) squared spread that a fit reckons with: the allowed one and the misfit."""
        return self.allowed_square + self.misfit_square

    def residuals(self, readings: Sequence[Floats], shift_s: Floats | None = None) -> list[Floats]:
        """Measured less predicted (N, k) a run; zero where not used.

        Args:
            shift_s: (k,) by how much less than stated the joints lag.
        """
        left = [run.measured_rad - reading for run, reading in zip(self.data.runs, readings, strict=True)]
        if shift_s is not None and shift_s.any():
            times = self.times_of(range(len(left)))
            marks = np.split(times.lag_marks(np.concatenate(readings)), times.ends[:-1])
            left = [residual - shift_s * mark for residual, mark in zip(left, marks, strict=True)]
        return [np.where(run.use, residual, 0.0) for run, residual in zip(self.data.runs, left, strict=True)]

    def times_of(self, runs: Sequence[int]) -> StackedTimes:
        """Of some runs, one below the other."""
        key = tuple(runs)
        if key not in self._times:
            times_s = [self.data.runs[i].t_s for i in runs]
            self._times[key] = StackedTimes.of(times_s, self.data.robot.servo.time_constant_s)
        return self._times[key]

    def mean_square(self, readings: Sequence[Floats]) -> Floats:
        """(B,) mean squares of the residuals that predicted readings leave, not shifted in time."""
        return self.blocks.mean_square(self.residuals(readings))

    def shifts_s(self, readings: Sequence[Floats], runs: Sequence[int], limits: ShiftLimits) -> Floats:
        """(k,) by how much less than stated each joint lags, as suits some runs best; ``readings`` are of all runs."""
        if not limits.any or not len(runs):
            return np.zeros_like(limits.each_s)
        picked = [self.data.runs[i] for i in runs]
        made = np.concatenate([readings[i] for i in runs])
        mark = self.times_of(runs).lag_marks(made)
        residual = np.concatenate([run.measured_rad for run in picked]) - made
        block = np.concatenate([self.blocks.of_sample[i] for i in runs])
        return shifts_s(residual, mark, block, self.allowed_square, limits)
