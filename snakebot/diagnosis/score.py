"""The score of an explanation: how small its residuals are, block by block, against what noise and tolerance allow.

With m the mean square of a block's residual and s its allowed spread, a block scores ``-1/2 log(1 + m / s^2)``. The
logarithm keeps one violent run from outvoting the calm ones, where dead band and backlash show; near the floor
it is the usual sum of squares.

The allowed spread is the noise floor and the *tolerance*: no servo is quite the first-order lag that the nominal model
takes it for, nor quite stiff, so a small share of that lag's own mark and a little sag under load are no gap. What the
nominal numbers themselves may be off by is dealt with in ``allowance``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.blocks import BlockMap

Floats = NDArray[np.float64]

SHAPE_TOLERANCE = 0.02  # share of the mark of the nominal lag that a sound servo may differ in
SAG_TOLERANCE_RAD_NM = 1e-3  # to which a sound servo holds its angle under load
CHANGED = 0.1  # of what a block is allowed, by which its mean square must differ to count


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
