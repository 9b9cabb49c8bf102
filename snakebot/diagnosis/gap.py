"""Whether there is a gap: joint by joint and over ground, against what noise and tolerance allow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis import ground as ground_motion
from snakebot.diagnosis.blocks import mean_difference
from snakebot.diagnosis.context import Context

if TYPE_CHECKING:
    from snakebot.diagnosis.trial import Trial

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

GAP_SE = 3.0
GAP_SIZE = 1.3  # mean square over the allowed one, above which a gap is one: the floor is an estimate itself
FEW_WINDOWS = 8  # over ground, below which their scatter says nothing
SURELY = 2.5 * GAP_SIZE  # however few blocks show it
# The same over ground. Healthy robots, a few per cent off, come to 1.2, 1.9 and 0.9 at most (102 of the blind check's
# cases without a gap).
SURELY_OVER_GROUND = {ground_motion.FORWARD: 1.7, ground_motion.LATERAL: 2.4, ground_motion.TURN: 1.7}
LEAST_SHARE = 0.05  # of the gap, for a joint to be named


@dataclass(frozen=True, eq=False)
class Gap:
    """The gap of one trial.

    Attributes:
        joint_square: (k,) mean squares above the floor, rad^2.
        significant: (k,) whether they are beyond noise and tolerance.
        ground_ratio: mean square of the ground's features over what is allowed; nan without a ground.
        ground_significant: the same for the ground.
    """

    joint_square: Floats
    significant: Bools
    ground_ratio: float
    ground_significant: bool

    @property
    def any(self) -> bool:
        return bool(self.significant.any()) or self.ground_significant

    @property
    def joint_shares(self) -> Floats:
        """(k,) adding up to one; zeros without a gap."""
        total = self.joint_square.sum()
        return self.joint_square / total if total > 0 else np.zeros_like(self.joint_square)


def gap_of(context: Context, trial: Trial, rows: Bools | None = None) -> Gap:
    """What a trial leaves over, joint by joint and over ground, in the blocks ``rows`` (B,) or in those that decide."""
    k = context.data.joints
    asked = context.selects if rows is None else rows
    square, significant = np.zeros(k), np.zeros(k, dtype=bool)
    for joint in range(k):
        rows = (context.block_joint == joint) & asked
        if not rows.any():
            continue
        held, allowed = trial.held_square[rows], context.allowed_square[rows]
        square[joint] = max(float(held.mean()) - float(context.floor.rad[joint] ** 2), 0.0)
        significant[joint] = beyond(held, allowed, context.block_run[rows])
    rows = (context.block_joint == -1) & asked
    ratio, ground = float("nan"), False
    if rows.any():
        ratio = float(np.mean(trial.held_square[rows] / context.allowed_square[rows]))
        ground = _ground_beyond(context, trial, asked)
    return Gap(square, significant, ratio, ground)


def hidden_gap(context: Context, trial: Trial) -> Gap:
    """The gap on joints whose floor is too large to be believed: all that a trial leaves over there."""
    k = context.data.joints
    square, significant = np.zeros(k), np.zeros(k, dtype=bool)
    for joint in context.floor.doubts:
        rows = (context.block_joint == joint) & context.selects
        if rows.any():
            square[joint], significant[joint] = float(trial.held_square[rows].mean()), True
    return Gap(square, significant, float("nan"), False)


def _ground_beyond(context: Context, trial: Trial, asked: Bools) -> bool:
    """Whether speed or turning is off beyond what is allowed, over all windows."""
    ground = context.ground
    assert ground is not None
    first = context.angle_blocks.count
    held, allowed = trial.held_square[first:], context.ground_allowed_square
    use = asked[first:]
    for kind, surely in SURELY_OVER_GROUND.items():
        rows = (ground.kind == kind) & use
        few = rows.sum() < FEW_WINDOWS
        if few and rows.sum() >= 2 and np.mean(held[rows] / allowed[rows]) > 2.0 * GAP_SIZE:
            return True
        if not few and beyond(held[rows], allowed[rows], ground.run[rows], surely):
            return True
    return False


def beyond(square: Floats, allowed: Floats, run: NDArray[np.int64], surely: float = SURELY) -> bool:
    """Whether the mean squares (b,) of some blocks are beyond those allowed (b,)."""
    excess = mean_difference(np.log1p(square / allowed) - np.log(1 + GAP_SIZE), run)
    overall = float(square.mean() / allowed.mean())
    return (excess.z > GAP_SE and excess.mean > 0) or overall > surely


def named_joints(gap: Gap) -> tuple[int, ...]:
    """1-based joints with a gap worth naming."""
    share = gap.joint_shares
    return tuple(
        j + 1 for j in range(share.size) if gap.significant[j] and share[j] >= LEAST_SHARE / share.size
    )
