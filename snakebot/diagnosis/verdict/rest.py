"""The rest: what the best explanation leaves over, and how much of the gap that is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Bools
from snakebot.diagnosis.evidence.gap import Gap, gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import Scoring
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.search.acceptance import MOST_LEFT
from snakebot.diagnosis.verdict.localise import beyond_allowed


@dataclass(frozen=True, eq=False)
class Rest:
    """What an explanation leaves over.

    Attributes:
        share: of the gap above what is allowed, in mean squares.
        gap: joint by joint and over ground.
        bent: joints (1-based) on which it bends with the angle, where what explains them is straight.
    """

    share: float
    gap: Gap
    bent: tuple[int, ...] = ()

    @property
    def significant(self) -> bool:
        return self.gap.any or bool(self.bent)

    @property
    def is_too_much(self) -> bool:
        """Whether it is beyond noise and tolerance, and so large that the gap is not explained; or plainly of another
        law, however small it is.
        """
        return (self.gap.any and self.share > MOST_LEFT) or bool(self.bent)


def rest_of(evidence: Evidence, nominal: Trial, best: Trial) -> Rest:
    """Measure the rest of ``best`` against the gap of ``nominal``, in the blocks that decide."""
    share = _share(evidence, nominal, best, evidence.scoring.decides)
    return Rest(share, gap_of(evidence.scoring, best.held_square))


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
    rest = Rest(share, gap)
    return rest if rest.is_too_much else None


def runs_with_gap(scoring: Scoring, shown: tuple[int, ...], trial: Trial) -> tuple[int, ...]:
    """Of the shown runs those in which ``trial`` leaves a gap; all of them if no single one shows it."""
    found = tuple(i for i in shown if gap_of(scoring, trial.held_square, scoring.run == i).any)
    return found or shown


def _share(evidence: Evidence, nominal: Trial, best: Trial, rows: Bools) -> float:
    """Share of the gap left over in some blocks: of the angles and of the ground, by how far each was beyond what is
    allowed.
    """
    before = gap_of(evidence.scoring, nominal.held_square, rows)
    weights = beyond_allowed(evidence.scoring, before, nominal, rows)
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
