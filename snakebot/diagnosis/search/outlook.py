"""Whether a first look at an effect is worth its time: what the effect could close at best, seen from one prediction at
each start.

The change that an effect makes at a start is scaled as suits best. A fit bends on from there, but not from a change
that points nowhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.fit_runs import StackedAngles, shift_limits
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.fit.trial import Trial, informative_runs
from snakebot.diagnosis.search.candidate import Candidate
from snakebot.diagnosis.sizes import CLEAR, HALF, LITTLE, MUCH, OUTSTANDING

# Shares of the change that an effect makes at a start, and multiples, beside the one of least squares, which is between
# the first and the last: the best is what a fit might reach; chosen.
SHARES = (MUCH, HALF, 1.0, CLEAR, OUTSTANDING)


def promising(evidence: Evidence, base: Trial, candidates: Sequence[Candidate]) -> list[Candidate]:
    """Those of ``candidates`` that promise a share of what the best promises over ``base``, and those of which a
    few predictions tell nothing: where nothing is fitted, or only the motion over ground changes.
    """
    told = [c for c in candidates if c.starts[0].size and c.hypothesis.terms[-1].stage != "body"]
    promised = dict(zip(told, in_parallel(partial(promise, evidence, base), told), strict=True))
    least = LITTLE * max(promised.values(), default=0.0)
    return [c for c in candidates if promised.get(c, np.inf) >= max(least, 0.0)]


def promise(evidence: Evidence, base: Trial, candidate: Candidate) -> float:
    """The largest gain in mean score over ``base``, on the two runs that tell most."""
    runs, scoring = informative_runs(evidence), evidence.scoring
    rows = scoring.of_angles & np.isin(scoring.run, runs)
    old = _unchanged(evidence, base, runs)
    return max(scoring.gain(new, old, rows).mean for new in _scaled(evidence, base, runs, candidate))


def _unchanged(evidence: Evidence, base: Trial, runs: Sequence[int]) -> Floats:
    """(B,) mean squares of ``base``, the nominal lags off by what suits it in these runs."""
    stacked = _stacked(evidence.angles, runs, base.hypothesis)
    return _squares(evidence, base, runs, stacked, [base.readings[i] for i in runs])


def _scaled(evidence: Evidence, base: Trial, runs: Sequence[int], candidate: Candidate) -> Iterator[Floats]:
    """(B,) mean squares with each share of the change that a candidate makes to ``base`` in some runs at each start."""
    stacked = _stacked(evidence.angles, runs, candidate.hypothesis)
    for start in candidate.starts:
        made = evidence.predictor.readings(candidate.hypothesis.specs(start), runs, rough=True)
        change = [new - base.readings[i] for i, new in zip(runs, made, strict=True)]
        for share in (*SHARES, _least_squares(evidence.data, base, runs, change)):
            mixed = [base.readings[i] + share * part for i, part in zip(runs, change, strict=True)]
            yield _squares(evidence, base, runs, stacked, mixed)


def _stacked(angles: AngleEvidence, runs: Sequence[int], hypothesis: Hypothesis) -> StackedAngles:
    """All joints in some runs, to be as late beside a hypothesis as suits what it predicts."""
    limits = shift_limits(angles, hypothesis)
    return StackedAngles.of(angles, range(angles.data.joints), runs, limits)


def _least_squares(data: Data, base: Trial, runs: Sequence[int], change: Sequence[Floats]) -> float:
    """The share of a ``change`` of the readings in some runs that leaves the least of what ``base`` leaves there."""
    gained = power = 0.0
    for index, part in zip(runs, change, strict=True):
        run = data.runs[index]
        used = run.use & np.isfinite(part)
        gained += float((part[used] * (run.measured_rad - base.readings[index])[used]).sum())
        power += float(np.square(part[used]).sum())
    return float(np.clip(gained / power, SHARES[0], SHARES[-1])) if power > 0 else SHARES[0]


def _squares(
    evidence: Evidence, base: Trial, runs: Sequence[int], stacked: StackedAngles, readings: Sequence[Floats]
) -> Floats:
    """(B,) mean squares with other ``readings`` in some runs, ``stacked``."""
    of_run = dict(zip(runs, np.split(stacked.residual(readings), stacked.times.ends[:-1]), strict=True))
    left = [of_run.get(i, rest) for i, rest in enumerate(base.left)]
    square = base.held_square.copy()
    square[evidence.scoring.of_angles] = evidence.angles.blocks.mean_square(left)
    return evidence.scoring.credited(square)
