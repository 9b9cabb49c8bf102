"""The rest: what the best explanation leaves over, and how much of the gap that is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Bools
from snakebot.diagnosis.evidence.gap import Gap, gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import Scoring
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.search.acceptance import MOST_LEFT, excess_in
from snakebot.diagnosis.sizes import NEXT_TO_NOTHING
from snakebot.diagnosis.verdict.localise import beyond_allowed


@dataclass(frozen=True, eq=False)
class Rest:
    """What an explanation leaves over.

    Attributes:
        share: of the gap above what is allowed, in mean squares.
        of_angles: the same of the gap of the angles alone; 0 where that is next to nothing beside the one over ground.
        of_ground: the same over ground.
        gap: joint by joint and over ground.
        bent: joints (1-based) on which it bends with the angle, where what explains them is straight.
    """

    share: float
    of_angles: float
    of_ground: float
    gap: Gap
    bent: tuple[int, ...] = ()

    @property
    def significant(self) -> bool:
        return self.gap.any or bool(self.bent)

    @property
    def is_too_much(self) -> bool:
        """Whether it is beyond noise and tolerance, in the angles or over ground, and so much of the gap there that
        this is not explained; or plainly of another law, however small it is.
        """
        in_angles = bool(self.gap.significant.any()) and self.of_angles > MOST_LEFT
        over_ground = self.gap.ground_significant and self.of_ground > MOST_LEFT
        return in_angles or over_ground or bool(self.bent)


def rest_of(evidence: Evidence, nominal: Trial, best: Trial) -> Rest:
    """Measure the rest of ``best`` against the gap of ``nominal``, in the blocks that decide."""
    return _rest(evidence, nominal, best, evidence.scoring.decides)


def brings_nearer(evidence: Evidence, nominal: Trial, best: Trial, rest: Rest) -> bool:
    """Whether ``best`` takes anything away on the runs of the closure: of the error of the angles as the user sees it,
    with the lags as stated, or of what is beyond tolerance over ground.
    """
    angles = evidence.angles
    size = np.where(np.isin(angles.blocks.run, evidence.split.shown), angles.blocks.samples, 0)
    before, after = (float(angles.mean_square(trial.readings) @ size) for trial in (nominal, best))
    over_ground = gap_of(evidence.scoring, nominal.held_square).ground_significant and rest.of_ground < 1
    return after < before or over_ground


def held_out_rest(evidence: Evidence, nominal: Trial, best: Trial) -> Rest | None:
    """The same in the runs that the user holds out; None without such runs, or where it is no reason for a verdict.

    Nothing was fitted there, and nothing chosen: a gap that does not close there, or that shows nowhere else, is not
    explained.
    """
    scoring = evidence.scoring
    rows = np.isin(scoring.run, evidence.split.shown)
    if np.array_equal(rows, scoring.decides):
        return None
    rest = _rest(evidence, nominal, best, rows)
    return rest if rest.is_too_much else None


def runs_with_gap(scoring: Scoring, shown: tuple[int, ...], trial: Trial) -> tuple[int, ...]:
    """Of the shown runs those in which ``trial`` leaves a gap; all of them if no single one shows it."""
    found = tuple(i for i in shown if gap_of(scoring, trial.held_square, scoring.run == i).any)
    return found or shown


def _rest(evidence: Evidence, nominal: Trial, best: Trial, rows: Bools) -> Rest:
    """What is left over in some blocks: of the angles and of the ground, and of both by how far each was beyond what is
    allowed.
    """
    scoring = evidence.scoring
    before = gap_of(scoring, nominal.held_square, rows)
    weights = beyond_allowed(scoring, before, nominal, rows)
    sides = (
        _left(scoring, nominal, best, side & rows) if weight > NEXT_TO_NOTHING * sum(weights) else 0.0
        for side, weight in zip((scoring.of_angles, scoring.of_ground), weights, strict=True)
    )
    of_angles, of_ground = sides
    both = weights[0] * of_angles + weights[1] * of_ground
    share = both / sum(weights) if sum(weights) > 0 else 0.0
    return Rest(share, of_angles, of_ground, gap_of(scoring, best.held_square, rows))


def _left(scoring: Scoring, nominal: Trial, best: Trial, rows: Bools) -> float:
    """Share of what ``nominal`` leaves above what is allowed, in blocks of one side, that ``best`` leaves there."""
    before = excess_in(scoring, nominal, rows)
    return excess_in(scoring, best, rows) / before if before > 0 else 0.0
