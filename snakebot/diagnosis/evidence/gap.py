"""Whether there is a gap: joint by joint and over ground, against what noise and tolerance allow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence.blocks import mean_difference
from snakebot.diagnosis.evidence.data import MIN_SAMPLES
from snakebot.diagnosis.evidence.ground import Feature
from snakebot.diagnosis.evidence.score import Scoring
from snakebot.diagnosis.sizes import BEYOND_CHANCE, CLEAR, LITTLE

# Mean square over the allowed one, above which there is a gap: the floor is an estimate itself; chosen.
GAP_RATIO = 1.3
# Mean square over the allowed one that is a gap however few blocks show it.
CERTAIN_RATIO = BEYOND_CHANCE
# The same over ground, of each kind of feature. Measured: robots with no effect, whose numbers are some per cent off,
# come to 0.8, 1.0 and 1.1 at most (60 of the cases that ``tools/blind/make --set tune`` and ``--set calibrate``
# make; no command prints the ratios).
CERTAIN_RATIO_OVER_GROUND = CLEAR


@dataclass(frozen=True, eq=False)
class Gap:
    """What an explanation leaves over.

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


def gap_of(scoring: Scoring, mean_square: Floats, rows: Bools | None = None) -> Gap:
    """The gap that mean squares (B,) of residuals are, in the blocks ``rows`` (B,) or in those that decide."""
    asked = scoring.decides if rows is None else rows
    square, significant = np.zeros(scoring.joints), np.zeros(scoring.joints, dtype=bool)
    for joint in range(scoring.joints):
        mine = (scoring.joint == joint) & asked
        if not mine.any():
            continue
        found, allowed = mean_square[mine], scoring.allowed_square[mine]
        square[joint] = max(float(found.mean()) - float(scoring.floor_square[mine][0]), 0.0)
        significant[joint] = beyond(found, allowed, scoring.run[mine])
    mine = scoring.of_ground & asked
    ratio, ground = float("nan"), False
    if mine.any():
        ratio = float(np.mean(mean_square[mine] / scoring.allowed_square[mine]))
        ground = _ground_beyond(scoring, mean_square, asked)
    return Gap(square, significant, ratio, ground)


def hidden_gap(scoring: Scoring, mean_square: Floats, joints: Iterable[int]) -> Gap:
    """The gap on joints (0-based) whose floor is too large to be believed: all of the mean squares (B,) there."""
    square, significant = np.zeros(scoring.joints), np.zeros(scoring.joints, dtype=bool)
    for joint in joints:
        rows = (scoring.joint == joint) & scoring.decides
        if rows.any():
            square[joint], significant[joint] = float(mean_square[rows].mean()), True
    return Gap(square, significant, float("nan"), False)


def _ground_beyond(scoring: Scoring, mean_square: Floats, asked: Bools) -> bool:
    """Whether speed or turning is off beyond what is allowed, over all windows."""
    for kind in Feature:
        rows = (scoring.kind == kind) & asked
        found, allowed = mean_square[rows], scoring.allowed_square[rows]
        certain = certain_over_ground(found.size)
        if found.size < MIN_SAMPLES:
            if found.size >= 2 and np.mean(found / allowed) > certain:
                return True
        elif beyond(found, allowed, scoring.run[rows], certain):
            return True
    return False


def certain_over_ground(count: int) -> float:
    """Mean square over the allowed one that is a gap over ground for certain, of so many windows or speeds."""
    return CLEAR * GAP_RATIO if count < MIN_SAMPLES else CERTAIN_RATIO_OVER_GROUND


def beyond(square: Floats, allowed: Floats, run: Ints, certain: float = CERTAIN_RATIO) -> bool:
    """Whether the mean squares (b,) of some blocks are beyond those allowed (b,); ``certain``: a ratio that is."""
    excess = mean_difference(np.log1p(square / allowed) - np.log(1 + GAP_RATIO), run)
    overall = float(square.mean() / allowed.mean())
    return (excess.z > BEYOND_CHANCE and excess.mean > 0) or overall > certain


def named_joints(gap: Gap) -> tuple[int, ...]:
    """1-based joints with a significant gap that is not little beside the largest: every real joint has a gap."""
    share = gap.joint_shares
    least = LITTLE * share.max(initial=0.0)
    return tuple(j + 1 for j in range(share.size) if gap.significant[j] and share[j] >= least)
