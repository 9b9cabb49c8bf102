"""The ranking: every explanation that was tried, how far it is behind the best, and where."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.result import RankingEntry
from snakebot.diagnosis.search.acceptance import gains, touched
from snakebot.diagnosis.search.search import SearchResult
from snakebot.diagnosis.verdict.joints import joints_of
from snakebot.diagnosis.verdict.probability import beside, shared
from snakebot.diagnosis.verdict.regime import MOST_ROWS


def ranked(
    evidence: Evidence, found: SearchResult, best: Trial, weighed: Sequence[tuple[float, Sequence[Trial]]]
) -> tuple[RankingEntry, ...]:
    """Explanations tried, best first. Probabilities: of the best, that all its causes are right, shared in
    its group; of the others, by how far they are behind it, and none is more likely than it.

    Args:
        weighed: of each cause its probability, and those that it cannot be told from.
    """
    scoring = evidence.scoring
    top = float(np.prod([probability for probability, _ in weighed])) if weighed else 0.0
    group = [best, *(t for _, rivals in weighed for t in rivals)]
    parts = shared(top, [t.score(scoring) for t in group]) if weighed else []
    entries: dict[Hypothesis, RankingEntry] = {}
    listed = [
        best,
        found.best,
        *(t for _, rivals in weighed for t in rivals),
        *found.singles,
        *(t for r in found.rivals for t in r),
        found.nominal,
    ]
    for trial in listed:
        if trial.hypothesis in entries:
            continue
        behind = scoring.gain(best.held_square, trial.held_square)
        own = next((p for t, p in zip(group, parts, strict=False) if t is trial), None)
        entries[trial.hypothesis] = RankingEntry(
            effects=trial.hypothesis.names,
            joints=joints_of(evidence.angles, trial.hypothesis),
            held_out_score=round(trial.score(scoring), 5),
            delta=round(behind.mean, 5),
            delta_se=round(behind.se, 5) if np.isfinite(behind.se) else 0.0,
            probability=round(own, 3) if own is not None else 0.0,
            parameters=len(trial.theta),
            rms_after=_rms_shown(evidence.angles, evidence.split.shown, trial),
            worse_in=_worse_in(evidence, best, trial),
        )
    rest = max(0.0, 1 - sum(e.probability for e in entries.values()))
    others = [h for h, e in entries.items() if e.probability == 0.0]
    if others and weighed:
        small = beside(parts[0], best.score(scoring), [entries[h].held_out_score for h in others], 0.5 * rest)
        for h, p in zip(others, small, strict=True):
            entries[h] = entries[h].model_copy(update={"probability": round(p, 3)})
    return tuple(sorted(entries.values(), key=lambda e: -e.held_out_score))[:MOST_ROWS]


def _rms_shown(angles: AngleEvidence, shown: Sequence[int], trial: Trial) -> float:
    """Error of the joint angles on the runs of the closure, rad."""
    blocks = angles.blocks
    rows = np.isin(blocks.run, shown)
    size = blocks.samples[rows]
    square = angles.mean_square(trial.readings)[rows]
    return round(float(np.sqrt(square @ size / size.sum())), 8) if rows.any() else 0.0


def _worse_in(evidence: Evidence, best: Trial, trial: Trial) -> tuple[str, ...]:
    """Runs of the closure in which it is behind by as much as an effect must gain to be named."""
    scoring, names = evidence.scoring, []
    for index in evidence.split.shown:
        rows = touched(scoring, trial, best) & (scoring.run == index)
        if rows.any() and gains(scoring.gain(best.held_square, trial.held_square, rows)):
            names.append(evidence.data.runs[index].name)
    return tuple(names)
