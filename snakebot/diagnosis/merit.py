"""What an explanation must do to stand: gain clearly, matter, close enough of the gap."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.blocks import Difference
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.score import CHANGED
from snakebot.diagnosis.trial import Trial

Bools = NDArray[np.bool_]

CLEAR_SE = 2.0
WORTH = (
    0.005  # share of the whole gap that an effect beside the first must close, and at which a rest is let be
)
MATTERS = 0.05  # held-out score on the blocks an effect touches: a tenth of their mean square


def touched(context: Context, trial: Trial, base: Trial) -> Bools:
    """(B,) deciding blocks on which a trial does other than its base, better or worse.

    A limit that is reached in one gait of five says nothing in the other four.
    """
    changed = np.abs(trial.held_square - base.held_square) > CHANGED * context.allowed_square
    return np.asarray(changed & context.selects)


def lead(context: Context, trial: Trial, other: Trial) -> Difference:
    """How far a trial leads another, on the blocks where they differ."""
    rows = touched(context, trial, other)
    if not rows.any():
        return Difference(0.0, 0.0)
    return context.gain(trial.held_square, other.held_square, rows)


def accepted(context: Context, trial: Trial, base: Trial) -> bool:
    """Whether what was added to ``base`` gains more than two standard errors, and enough to matter, where
    there is a gap.
    """
    rows = touched(context, trial, base)
    gap = gap_of(context, base)
    joints = [
        j
        for j in np.unique(context.block_joint[rows])
        if (gap.ground_significant if j < 0 else gap.significant[j])
    ]
    if not joints:
        return False
    gain = context.gain(trial.held_square, base.held_square, rows)
    return gain.z > CLEAR_SE and gain.mean > MATTERS


def worth(context: Context, trial: Trial, base: Trial, nominal: Trial) -> bool:
    """Whether what was added closes enough of the whole gap, of the angles or over ground, to be named."""
    if not base.hypothesis.terms:
        return True
    side = np.asarray(
        context.block_joint < 0 if trial.hypothesis.terms[-1].stage == "body" else context.block_joint >= 0
    )
    fell = excess(context, base, side) - excess(context, trial, side)
    return fell > WORTH * excess(context, nominal, side)


def closed_enough(context: Context, trial: Trial, nominal: Trial) -> bool:
    """Whether nothing worth a further effect is left above what noise and tolerance allow."""
    gap = gap_of(context, trial)
    angle, ground = (np.asarray(context.block_joint >= 0), np.asarray(context.block_joint < 0))
    return not any(
        there and excess(context, trial, side) > WORTH * excess(context, nominal, side)
        for there, side in ((gap.significant.any(), angle), (gap.ground_significant, ground))
    )


def excess(context: Context, trial: Trial, side: Bools) -> float:
    """Mean square above the allowed one: of the angles in rad^2, of the ground against what each feature is allowed."""
    rows = side & context.selects
    allowed = context.allowed_square[rows]
    over = np.maximum(trial.held_square[rows] - allowed, 0.0)
    if not rows.any():
        return 0.0
    return float(np.mean(over / allowed if context.block_joint[rows][0] < 0 else over))
