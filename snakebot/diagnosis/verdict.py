"""From what the search found to a verdict: explained, no gap, or unexplained; what is left, and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.context import Context
from snakebot.diagnosis.gap import Gap, gap_of
from snakebot.diagnosis.localise import relative_angle, relative_ground
from snakebot.diagnosis.reference import residual_prediction
from snakebot.diagnosis.trial import Trial

Floats = NDArray[np.float64]

MUCH_LEFT = 0.2  # share of the gap that no explanation may leave over
SOME_LEFT = 0.08  # ... nor this much, if a model that names nothing predicts it
PREDICTABLE = 0.4  # share of the rest that such a model must predict on held-out gaits (or it is over ground)
FAR_ABOVE = 20.0  # ... or if it stands this far above what is allowed, in mean squares


@dataclass(frozen=True, eq=False)
class Rest:
    """What an explanation leaves over.

    Attributes:
        share: of the gap above what is allowed, in mean squares.
        gap: joint by joint and over ground.
        predictable: share of it that the flexible reference predicts on held-out gaits.
        ratio: mean square over the allowed one, on the joints with a rest.
    """

    share: float
    gap: Gap
    predictable: float
    ratio: float

    @property
    def significant(self) -> bool:
        return self.gap.any


def rest_of(context: Context, nominal: Trial, best: Trial) -> Rest:
    """Measure the rest of ``best`` against the gap of ``nominal``, in the blocks that decide."""
    gap = gap_of(context, best)
    share = _share(context, nominal, best, context.selects)
    predictable = 0.0
    if gap.significant.any():
        residual = best.left
        loads = [context.simulator.load(i) for i in range(len(context.data.runs))]
        known = [load for load in loads if load is not None]
        guess = residual_prediction(
            context.data,
            context.nominal,
            residual,
            known if len(known) == len(loads) else None,
            context.folds,
        )
        blocks = context.angle_blocks
        left = blocks.mean_square(
            [
                r - np.where(run.use, g, 0.0)
                for r, g, run in zip(residual, guess, context.data.runs, strict=True)
            ]
        )
        whole = best.held_square[: blocks.count]
        over = np.maximum(whole - context.scale.floor_square, 0.0)
        if over.sum() > 0:
            predictable = float(np.clip((whole - left).sum() / over.sum(), -1.0, 1.0))
    return Rest(share, gap, predictable, _ratio(context, best, gap))


def held_out_rest(context: Context, nominal: Trial, best: Trial) -> Rest | None:
    """The same in the runs that the user holds out; None without such runs, or where it is no reason for a verdict.

    Nothing was fitted there, and nothing chosen: a gap that does not close there, or that shows nowhere else, is not
    explained.
    """
    rows = context.shown
    if np.array_equal(rows, context.selects):
        return None
    gap = gap_of(context, best, rows)
    share = _share(context, nominal, best, rows)
    return Rest(share, gap, 0.0, 0.0) if gap.any and share > MUCH_LEFT else None


def runs_with_gap(context: Context, trial: Trial) -> tuple[int, ...]:
    """Of the shown runs those in which ``trial`` leaves a gap; all of them if no single one shows it."""
    found = tuple(i for i in context.shown_runs if gap_of(context, trial, context.block_run == i).any)
    return found or context.shown_runs


def _ratio(context: Context, best: Trial, gap: Gap) -> float:
    joints = np.flatnonzero(gap.significant)
    rows = np.isin(context.block_joint, joints) & context.selects
    if not rows.any():
        return 0.0
    return float(best.held_square[rows].mean() / context.allowed_square[rows].mean())


def _share(context: Context, nominal: Trial, best: Trial, rows: NDArray[np.bool_]) -> float:
    """Share of the gap left over in some blocks: of the angles and of the ground, by how large each was against the
    motion.
    """
    before = gap_of(context, nominal, rows)
    weights = (relative_angle(context, before), relative_ground(context, before, nominal))
    count = context.angle_blocks.count
    allowed = context.allowed_square
    total = 0.0
    for part, weight in zip((slice(0, count), slice(count, None)), weights, strict=True):
        use = rows[part]
        if weight <= 0 or not use.any():
            continue
        # the ground's features have units of their own: count them by what each is allowed
        unit = allowed[part][use] if part.start else np.ones(int(use.sum()))
        over = np.maximum(nominal.held_square[part][use] - allowed[part][use], 0.0) / unit
        after = np.maximum(best.held_square[part][use] - allowed[part][use], 0.0) / unit
        if over.sum() > 0:
            total += weight * float(after.sum() / over.sum())
    return total / sum(weights) if sum(weights) > 0 else 0.0


def decide(
    nominal: Gap, best: Trial, rest: Rest, noise_only: bool
) -> Literal["explained", "no_gap", "unexplained"]:
    """The verdict."""
    if not nominal.any:
        return "explained" if noise_only else "no_gap"
    if not best.hypothesis.terms:
        return "unexplained"
    if not rest.significant:
        return "explained"
    if rest.share > MUCH_LEFT or (
        rest.share > SOME_LEFT
        and (rest.predictable > PREDICTABLE or rest.ratio > FAR_ABOVE or rest.gap.ground_significant)
    ):
        return "unexplained"
    return "explained"
