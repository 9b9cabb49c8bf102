"""The score of an explanation: a Cauchy (Lorentzian) log-likelihood of its residuals, block by block.

With m the mean square of a block's residual and s its allowed spread, a block scores ``-1/2 log(1 + m / s^2)``: the
negative of the Cauchy loss, zero is perfect. The logarithm keeps one violent run from outvoting the calm ones, where
dead band and backlash show; near the floor it is the usual sum of squares.

The allowed spread is the noise floor and the tolerance of the nominal model (``tolerance``).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence.blocks import MeanDifference, mean_difference

GROUND = -1  # "joint" of the blocks of the motion over ground, by definition
# Difference of two mean scores below which there is no ground to prefer one: 4 % of the mean square; chosen.
ALIKE = 0.02


@dataclass(frozen=True, eq=False)
class Scoring:
    """What a score is made of: the blocks of the joint angles, then one for each feature of the motion over ground.

    Attributes:
        joints: of the robot.
        run, joint: (B,) of each block; ``joint`` is 0-based, ``GROUND`` for the ground.
        kind: (B,) which feature of the ground (``ground.Feature``), -1 for angles.
        samples: (B,) of each block; a feature of the ground counts as one.
        floor_square, allowed_square: (B,) squared noise floor and squared allowed spread, in the unit of the block.
        decides: (B,) blocks that may decide between explanations: not those of runs that the user holds out.
        misfit_square: (B,) beside the allowed one, what all everyday effects together leave over: differences below
            it decide nothing between explanations.
        healthy: (B,) blocks of joints (or of the ground) without a gap; None: as yet unknown.
        nominal_square: (B,) mean squares of the nominal prediction; see ``without_credit``.
    """

    joints: int
    run: Ints
    joint: Ints
    kind: Ints
    samples: Floats
    floor_square: Floats
    allowed_square: Floats
    decides: Bools
    healthy: Bools | None = None
    nominal_square: Floats | None = None
    misfit_square: Floats | float = 0.0

    @property
    def of_angles(self) -> Bools:
        """(B,) blocks of the joint angles."""
        return np.asarray(self.joint != GROUND)

    @property
    def of_ground(self) -> Bools:
        """(B,) blocks of the motion over ground."""
        return np.asarray(self.joint == GROUND)

    def score(self, mean_square: Floats) -> Floats:
        """(B,) scores of the mean squares (B,) of residuals."""
        return np.asarray(-0.5 * np.log1p(mean_square / (self.allowed_square + self.misfit_square)))

    def mean_score(self, mean_square: Floats) -> float:
        """Mean score over the deciding blocks."""
        return float(self.score(mean_square)[self.decides].mean())

    def gain(self, better: Floats, worse: Floats, rows: Bools | None = None) -> MeanDifference:
        """Mean score over all deciding blocks of one explanation over another's, from their mean squares (B,)."""
        use = self.decides if rows is None else rows
        difference = (self.score(better) - self.score(worse))[use]
        return mean_difference(difference, self.run[use])

    def without_credit(self, healthy: Bools, nominal_square: Floats) -> Scoring:
        """The same, where no explanation is credited for doing better than the nominal one where there is no gap.

        Args:
            healthy: (B,) blocks of joints (or of the ground) without a gap.
            nominal_square: (B,) mean squares of the nominal prediction.
        """
        return replace(self, healthy=healthy, nominal_square=nominal_square)

    def credited(self, mean_square: Floats) -> Floats:
        """(B,) mean squares, those of the nominal prediction where there is nothing to explain and the whole joint (or
        ground) does no worse.

        Block by block it would be a debit without a credit: by chance every explanation is worse somewhere.
        """
        if self.healthy is None or self.nominal_square is None:
            return mean_square
        change = np.where(self.decides, self.score(mean_square) - self.score(self.nominal_square), 0.0)
        worse = np.zeros(self.joints + 1, dtype=bool)  # the last one is the ground
        for joint in np.unique(self.joint[self.healthy]):
            worse[joint] = change[self.joint == joint].sum() < 0
        return np.where(self.healthy & ~worse[self.joint], self.nominal_square, mean_square)
