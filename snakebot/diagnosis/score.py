"""The score of an explanation: how small its residuals are, block by block, against what noise and tolerance allow.

With m the mean square of a block's residual and s its allowed spread, a block scores ``-1/2 log(1 + m / s^2)``. The
logarithm keeps one violent run from outvoting the calm ones, where dead band and backlash show; near the floor
it is the usual sum of squares.

The allowed spread is the noise floor and the *tolerance*: how far the prediction moves when the nominal servo's
time constant is off by ``LAG_TOLERANCE``. A simulation is never better than its own numbers; what lies within
them is no gap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.blocks import BlockMap, Difference, mean_difference

Floats = NDArray[np.float64]

LAG_TOLERANCE = 0.06  # relative error of the nominal time constant that is taken for granted


@dataclass(frozen=True, eq=False)
class Scale:
    """The allowed spread, per block of a block map.

    Attributes:
        blocks: the block map.
        floor_square: (B,) noise floor squared.
        tolerance_square: (B,) mean square that the nominal tolerance brings in.
    """

    blocks: BlockMap
    floor_square: Floats
    tolerance_square: Floats

    @property
    def square(self) -> Floats:
        return self.floor_square + self.tolerance_square

    def score(self, mean_square: Floats) -> Floats:
        """(B,) score of each block; zero is perfect, the noise floor itself scores -0.35."""
        return np.asarray(-0.5 * np.log1p(mean_square / self.square))


def gain(better: Floats, worse: Floats, scale: Scale, rows: NDArray[np.bool_] | None = None) -> Difference:
    """Held-out score of one explanation over another's, from mean squares (B,) each; ``rows`` selects blocks."""
    difference = scale.score(better) - scale.score(worse)
    run = scale.blocks.run
    # neighbouring blocks of one run, over all joints, are one cluster
    if rows is not None:
        difference, run = difference[rows], run[rows]
    return mean_difference(difference, run)
