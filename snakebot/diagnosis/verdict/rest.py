"""The rest: what the best explanation leaves over, how much of the gap that is, and whether it can be predicted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Bools
from snakebot.diagnosis.evidence.gap import Gap, gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import Scoring
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.verdict.flexible_model import residual_prediction
from snakebot.diagnosis.verdict.localise import relative_angle, relative_ground

MUCH_LEFT = 0.2  # share of the gap that no explanation may leave over; chosen


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


def rest_of(evidence: Evidence, nominal: Trial, best: Trial) -> Rest:
    """Measure the rest of ``best`` against the gap of ``nominal``, in the blocks that decide."""
    gap = gap_of(evidence.scoring, best.held_square)
    share = _share(evidence, nominal, best, evidence.scoring.decides)
    predictable = 0.0
    if gap.significant.any():
        residual = best.left
        simulator = evidence.predictor.simulator
        loads = [simulator.load(i) for i in range(len(evidence.data.runs))]
        known = [load for load in loads if load is not None]
        guess = residual_prediction(
            evidence.data,
            evidence.predictor.nominal,
            residual,
            known if len(known) == len(loads) else None,
            evidence.split.folds,
        )
        blocks = evidence.angles.blocks
        left = blocks.mean_square(
            [
                r - np.where(run.use, g, 0.0)
                for r, g, run in zip(residual, guess, evidence.data.runs, strict=True)
            ]
        )
        whole = best.held_square[: blocks.count]
        over = np.maximum(whole - evidence.angles.floor_square, 0.0)
        if over.sum() > 0:
            predictable = float(np.clip((whole - left).sum() / over.sum(), -1.0, 1.0))
    return Rest(share, gap, predictable, _ratio(evidence.scoring, best, gap))


def held_out_rest(evidence: Evidence, nominal: Trial, best: Trial) -> Rest | None:
    """The same in the runs that the user holds out; None without such runs, or where it is no reason for a verdict.

    Nothing was fitted there, and nothing chosen: a gap that does not close there, or that shows nowhere else, is not
    explained.
    """
    scoring = evidence.scoring
    rows = np.isin(scoring.run, evidence.split.shown)
    if np.array_equal(rows, scoring.decides):
        return None
    gap = gap_of(scoring, best.held_square, rows)
    share = _share(evidence, nominal, best, rows)
    return Rest(share, gap, 0.0, 0.0) if gap.any and share > MUCH_LEFT else None


def runs_with_gap(scoring: Scoring, shown: tuple[int, ...], trial: Trial) -> tuple[int, ...]:
    """Of the shown runs those in which ``trial`` leaves a gap; all of them if no single one shows it."""
    found = tuple(i for i in shown if gap_of(scoring, trial.held_square, scoring.run == i).any)
    return found or shown


def _ratio(scoring: Scoring, best: Trial, gap: Gap) -> float:
    joints = np.flatnonzero(gap.significant)
    rows = np.isin(scoring.joint, joints) & scoring.decides
    if not rows.any():
        return 0.0
    return float(best.held_square[rows].mean() / scoring.allowed_square[rows].mean())


def _share(evidence: Evidence, nominal: Trial, best: Trial, rows: Bools) -> float:
    """Share of the gap left over in some blocks: of the angles and of the ground, by how large each was against the
    motion.
    """
    before = gap_of(evidence.scoring, nominal.held_square, rows)
    weights = (relative_angle(evidence.data, before), relative_ground(evidence.ground, before, nominal))
    count = evidence.angles.blocks.count
    allowed = evidence.scoring.allowed_square
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
