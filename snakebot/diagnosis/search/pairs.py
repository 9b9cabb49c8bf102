"""Two effects that only work together: one of them alone is a worse compromise than some third effect, so that a search
that adds them one by one goes another way.

Play and a dead band of one size are taken for friction; friction and both together are not. Each effect has been fitted
alone: how much two of them could close together is seen from what each changes at that size and at half of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.fit_runs import StackedAngles
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.fit.trial import Trial, first_runs, run_trial
from snakebot.diagnosis.search.candidate import SIZE_BESIDE, Candidate, scaled
from snakebot.diagnosis.search.rounds import FOLLOWED_UP, LOOKED_AT, held_out, ranked
from snakebot.diagnosis.sizes import LITTLE, SOME

MOST_SINGLES = SOME * LOOKED_AT  # effects that pairs are made of, those that leave least


@dataclass(frozen=True, eq=False)
class _Mark:
    """What an effect changes at one size: ``change`` (N,) of the readings that are compared."""

    term: Term
    theta: Floats
    change: Floats


def pairs(evidence: Evidence, nominal: Trial, fits: Sequence[Trial], ahead: Trial) -> list[Trial]:
    """Trials of two effects of servo, link or sensor together, best first by held-out score: of those that promise to
    close most, if that is clearly more than one of them does alone.

    Args:
        fits: single effects as fitted.
        ahead: what a pair is to beat; see ``run_trial_against``.
    """
    alone = [t for t in fits if t.theta.size and t.hypothesis.terms[0].stage != "body"]
    alone.sort(key=lambda t: -t.fitted_score(evidence.scoring))
    runs, with_gap = first_runs(evidence), gap_of(evidence.scoring, nominal.held_square).significant
    stacked = StackedAngles.of(evidence.angles, np.flatnonzero(with_gap).tolist(), runs, None)
    nothing = stacked.residual([nominal.readings[i] for i in runs])

    def mark(trial: Trial, theta: Floats, readings: Sequence[Floats]) -> _Mark:
        change = nothing - stacked.residual(readings)
        return _Mark(trial.hypothesis.terms[0], theta, np.nan_to_num(change[stacked.use]))

    def marks_of(trial: Trial) -> list[_Mark]:
        theta = scaled(trial.hypothesis.terms[0], trial.theta, SIZE_BESIDE)
        made = evidence.predictor.readings(trial.hypothesis.specs(theta), runs, rough=True)
        return [mark(trial, theta, made), mark(trial, trial.theta, [trial.readings[i] for i in runs])]

    marks = [mark for some in in_parallel(marks_of, alone[:MOST_SINGLES]) for mark in some]
    looks = in_parallel(
        lambda c: run_trial(evidence, c.hypothesis, c.starts, cross=False, rough=True, last=False),
        _most_promising(marks, np.nan_to_num(nothing[stacked.use])),
    )
    looks.sort(key=lambda t: -t.fitted_score(evidence.scoring))
    return ranked(evidence.scoring, held_out(evidence, looks[:FOLLOWED_UP], ahead=ahead))


def _most_promising(marks: Sequence[_Mark], left: Floats) -> list[Candidate]:
    """The pairs whose changes together come nearest to what is ``left`` (N,), and where to start them.

    Both are scaled as least squares has it; a pair does not promise anything where one of them is to act backwards,
    or where one alone does nearly as well.
    """
    if not marks:
        return []
    change = np.stack([mark.change for mark in marks])
    gram, along = change @ change.T, change @ left
    power = np.maximum(np.diag(gram), np.finfo(float).tiny)
    whole = float(left @ left)
    least = whole - float(np.max(np.square(np.maximum(along, 0.0)) / power))
    promised: list[tuple[float, Hypothesis, Floats]] = []
    for i, j in combinations(range(len(marks)), 2):
        one, other = marks[i], marks[j]
        if one.term.effect == other.term.effect or _apart(one.term, other.term):
            continue
        block = gram[np.ix_([i, j], [i, j])]
        if np.linalg.det(block) <= 1e-9 * power[i] * power[j]:  # the same change: rounding errors decide
            continue
        share = np.linalg.solve(block, along[[i, j]])
        rest = whole - float(share @ along[[i, j]])
        if (share > 0).all() and rest < (1 - LITTLE) * least:
            begin = [scaled(m.term, m.theta, float(f)) for m, f in zip((one, other), share, strict=True)]
            promised.append((rest, Hypothesis((one.term, other.term)), np.concatenate(begin)))
    of_names: dict[frozenset[str], Candidate] = {}
    for _, hypothesis, start in sorted(promised, key=lambda row: row[0]):
        candidate = of_names.setdefault(frozenset(hypothesis.names), Candidate(hypothesis, []))
        if candidate.hypothesis == hypothesis and len(candidate.starts) < FOLLOWED_UP:
            candidate.starts.append(start)
    return list(of_names.values())[:SOME]


def _apart(one: Term, other: Term) -> bool:
    """Whether two effects share no joint: the search finds these one after the other."""
    return one.joints is not None and other.joints is not None and not set(one.joints) & set(other.joints)
