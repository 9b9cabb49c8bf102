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

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.fit.trial import Trial, first_runs, run_trial
from snakebot.diagnosis.search.acceptance import LEAST_FALL
from snakebot.diagnosis.search.rounds import held_out, ranked

SIZES = (0.5, 1.0)  # of an effect as fitted alone: beside another one it is less; chosen
MOST_SINGLES = 24  # effects that pairs are made of, those that leave least; chosen
MOST_STARTS = 2  # of a pair, where several sizes of its effects promise something; chosen
MOST_PAIRS, MOST_PAIRS_HELD = 4, 2  # pairs fitted, and those of them that are cross-validated; chosen


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
    runs = first_runs(evidence)
    used = _used(evidence, nominal, runs)
    left = _stacked([evidence.data.runs[i].measured_rad - nominal.readings[i] for i in runs], used)

    def marks_of(trial: Trial) -> list[_Mark]:
        found = []
        for size in SIZES:
            theta = _at_size(trial.hypothesis.terms[0], trial.theta, size)
            made = evidence.predictor.readings(trial.hypothesis.specs(theta), runs, rough=True)
            change = [new - nominal.readings[i] for i, new in zip(runs, made, strict=True)]
            found.append(_Mark(trial.hypothesis.terms[0], theta, _stacked(change, used)))
        return found

    marks = [mark for some in in_parallel(marks_of, alone[:MOST_SINGLES]) for mark in some]
    chosen = _most_promising(marks, left)
    looks = in_parallel(
        lambda h: run_trial(evidence, h, chosen[h], cross=False, rough=True, last=False), list(chosen)
    )
    looks.sort(key=lambda t: -t.fitted_score(evidence.scoring))
    return ranked(evidence.scoring, held_out(evidence, looks[:MOST_PAIRS_HELD], ahead=ahead))


def _used(evidence: Evidence, nominal: Trial, runs: Sequence[int]) -> list[Bools]:
    """Per run (N, k) the readings that are compared, on joints with a gap."""
    with_gap = gap_of(evidence.scoring, nominal.held_square).significant
    return [
        evidence.data.runs[i].use
        & with_gap
        & np.isfinite(evidence.data.runs[i].measured_rad - nominal.readings[i])
        for i in runs
    ]


def _stacked(parts: Sequence[Floats], used: Sequence[Bools]) -> Floats:
    """(N,) the used readings of all runs; what is not predicted is no change."""
    return np.concatenate([np.nan_to_num(part[mine]) for part, mine in zip(parts, used, strict=True)])


def _at_size(term: Term, theta: Floats, size: float) -> Floats:
    """(p,) the parameters of a single effect, the first of them at a share of its distance from neutral."""
    first = term.open[0]
    return np.array([first.clip(first.neutral + size * (float(theta[0]) - first.neutral)), *theta[1:]])


def _most_promising(marks: Sequence[_Mark], left: Floats) -> dict[Hypothesis, list[Floats]]:
    """The pairs whose changes together come nearest to what is ``left`` (N,), and where to start them.

    Both are scaled as least squares has it; a pair does not promise anything where one of them is to act backwards,
    or where one alone does nearly as well.
    """
    if not marks:
        return {}
    change = np.stack([mark.change for mark in marks])
    gram, along = change @ change.T, change @ left
    power = np.maximum(np.diag(gram), np.finfo(float).tiny)
    whole = float(left @ left)
    least = whole - float(np.max(np.square(np.maximum(along, 0.0)) / power))
    found: dict[Hypothesis, list[tuple[float, Floats]]] = {}
    for i, j in combinations(range(len(marks)), 2):
        one, other = marks[i], marks[j]
        if one.term.effect == other.term.effect or _apart(one.term, other.term):
            continue
        block = gram[np.ix_([i, j], [i, j])]
        if np.linalg.det(block) <= 1e-9 * power[i] * power[j]:  # the same change: rounding errors decide
            continue
        share = np.linalg.solve(block, along[[i, j]])
        rest = whole - float(share @ along[[i, j]])
        if (share > 0).all() and rest < (1 - LEAST_FALL) * least:
            together = Hypothesis((one.term, other.term))
            start = [_at_size(m.term, m.theta, float(s)) for m, s in zip((one, other), share, strict=True)]
            found.setdefault(together, []).append((rest, np.concatenate(start)))
    best = sorted(found, key=lambda h: min(rest for rest, _ in found[h]))
    by_name: dict[frozenset[str], Hypothesis] = {}
    for hypothesis in best:
        by_name.setdefault(frozenset(hypothesis.names), hypothesis)
    return {
        h: [theta for _, theta in sorted(found[h], key=lambda row: row[0])[:MOST_STARTS]]
        for h in list(by_name.values())[:MOST_PAIRS]
    }


def _apart(one: Term, other: Term) -> bool:
    """Whether two effects share no joint: the search finds these one after the other."""
    return one.joints is not None and other.joints is not None and not set(one.joints) & set(other.joints)
