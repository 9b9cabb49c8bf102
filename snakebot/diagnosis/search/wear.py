"""Worn joints: all everyday effects are fitted at once, then those that a joint does not need are taken out.

Effects that only help together (an offset and a play) are not found one by one. But joints do not disturb each other,
so that all everyday effects of all joints can be fitted at once: one simulation serves every joint. What a joint
needs on runs left out of the fit stays, and becomes one explanation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import ALIKE, Scoring
from snakebot.diagnosis.fit.least_squares import (
    FEWEST_STEPS,
    SOME_STEPS,
    linearised,
    minimise,
    wide_allowance,
)
from snakebot.diagnosis.fit.trial import Trial, run_trial_against
from snakebot.diagnosis.search.acceptance import LEAST_GAIN, excess, excess_as_fitted, may_be_named
from snakebot.diagnosis.search.bench import Bench, Wear, as_wide_as, gain_on_joint, start_on
from snakebot.diagnosis.search.candidate import Candidate
from snakebot.diagnosis.search.everyday import (
    all_but,
    everyday_terms,
    is_one_of,
    other_kinds,
    takes_a_place,
)
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.search.rounds import FOLLOWED_UP, ranked
from snakebot.diagnosis.sizes import CLEAR, LITTLE, MUCH


def with_wear(
    evidence: Evidence, library: Library, nominal: Trial, first: Trial, fits: Sequence[Trial]
) -> tuple[Evidence, Library, Trial | None]:
    """The evidence with the misfit that all everyday effects together leave; and the everyday effects that the joints
    need, alone or beside a fault, if they explain clearly more than ``first`` does, with the library that knows of
    which kind they are. A fault must gain over them alone, but for one that takes the place of one of them: that
    explains no less.

    ``fits``: of single effects, and of two, those that may be the faults among them, as fitted.
    """
    whole = worn(evidence, library, nominal)
    if whole is None:
        return evidence, library, None
    library = library.of_kinds(whole.bench.terms)
    evidence = evidence.with_misfit(whole.left_square)
    alone = _accepted(evidence, nominal, first, whole.reduced().added_to(nominal.hypothesis, nominal.theta))
    found, everyday = {alone: whole}, everyday_terms(library)
    for fault in _faults(evidence.scoring, library, nominal, first, fits):
        with_fault = worn(evidence, library, fault)
        if with_fault is None:
            continue
        instead = takes_a_place(everyday, fault.hypothesis)
        if instead or with_fault.leaves_less_than(whole):
            candidate = with_fault.reduced().added_to(fault.hypothesis, fault.theta)
            found[_accepted(evidence, nominal, first if instead else alone or first, candidate)] = with_fault
    best = next(iter(ranked(evidence.scoring, [trial for trial in found if trial is not None])), None)
    if best is not None:
        library = library.of_kinds(found[best].bench.terms)
    return evidence, library, best


def _faults(
    scoring: Scoring, library: Library, nominal: Trial, first: Trial, fits: Sequence[Trial]
) -> list[Trial]:
    """What everyday effects are tried beside: ``first``, unless it is one of them, and what takes most of the gap away,
    with the next of those that do nearly as well: which of them it is may show when the everyday effects are there.

    The score hardly changes with a fault of a few moments before the everyday effects are in the prediction.
    """
    everyday = everyday_terms(library)
    gap_square = excess(scoring, nominal, scoring.of_angles)
    fault, left = all_but(everyday, first.hypothesis), {}
    nearest: dict[str, Trial] = {}
    for trial in fits:
        if all_but(everyday, trial.hypothesis) == trial.hypothesis.terms:
            left[trial] = excess_as_fitted(scoring, trial, scoring.of_angles)
    for trial in sorted(left, key=left.__getitem__):
        nearest.setdefault(trial.hypothesis.terms[-1].effect, trial)

    def does_well(trial: Trial) -> bool:
        peers = (left[t] for t in left if len(t.hypothesis.terms) == len(trial.hypothesis.terms))
        return left[trial] < min((1 - LITTLE) * gap_square, (1 + MUCH) * min(peers))

    others = [t for t in nearest.values() if t.hypothesis.terms != fault and does_well(t)][:FOLLOWED_UP]
    return [first, *others] if fault else others


def _accepted(evidence: Evidence, nominal: Trial, base: Trial, candidate: Candidate | None) -> Trial | None:
    """The trial of a candidate, if it is accepted on top of ``base``."""
    if candidate is None:
        return None
    trial = run_trial_against(evidence, base, candidate.hypothesis, candidate.starts)
    return trial if may_be_named(evidence.scoring, trial, base, nominal) else None


def worn(evidence: Evidence, library: Library, base: Trial) -> Whole | None:
    """All everyday effects on every joint where ``base`` leaves a gap; None where there is nothing to try."""
    gap = gap_of(evidence.scoring, base.held_square).significant
    joints = tuple(int(j) + 1 for j in np.flatnonzero(gap))
    everyday = everyday_terms(library)
    taken = {term.effect for term in all_but(everyday, base.hypothesis)}
    terms = tuple(term for term in everyday if term.effect not in taken)
    if not joints or not terms:
        return None
    rest = [
        spec
        for term, values in zip(base.hypothesis.terms, base.hypothesis.split(base.theta), strict=True)
        if not is_one_of(terms, term)
        for spec in term.specs(values.tolist())
    ]
    return _of_the_kind_that_shows(library, _whole(Bench(evidence, terms, joints, rest), library))


def _of_the_kind_that_shows(library: Library, whole: Whole) -> Whole:
    """All everyday effects, those with switches of the kind that leaves least. What one kind says of a delay another
    says of a width: a kind that is wrong spoils the others' share of the gap.
    """
    bench = whole.bench
    for term in bench.terms:
        for other in other_kinds(bench.evidence, library, term):
            terms = tuple(other if t.effect == other.effect else t for t in whole.bench.terms)
            tried = _whole(bench.of_kinds(terms), library)
            if tried.gain_over(whole).sum() > 0:
                whole = tried
    return whole


def _whole(bench: Bench, library: Library) -> Whole:
    """Fit all: by least squares first, then with the loss of the score."""
    allowed = bench.evidence.angles.allowed_square
    every = np.ones((len(bench.joints), len(bench.terms)), dtype=bool)
    begin = start_on(bench, library)
    problem = bench.problem(every, allowed)
    wide = wide_allowance(problem, bench.residual(begin, every))
    theta = minimise(replace(problem, allowed_square=wide), begin, SOME_STEPS, covariance=False).theta
    spread = as_wide_as(bench, bench.square(bench.residual(theta, every)))
    theta = minimise(bench.problem(every, spread), theta, SOME_STEPS, covariance=False).theta
    return Whole(bench, theta, bench.square(bench.residual(theta, every)))


@dataclass(frozen=True, eq=False)
class Whole:
    """All everyday effects together, as fitted.

    Attributes:
        theta: (U, p) parameters of each joint, effect by effect.
        left_square: (B,) mean squares that they leave of the angles.
    """

    bench: Bench
    theta: Floats
    left_square: Floats

    def leaves_less_than(self, other: Whole) -> bool:
        """Whether it leaves so much less than ``other`` that what it is fitted beside is needed: in mean square or in
        score, as of a further effect.
        """
        angles = self.bench.evidence.angles
        rows = (self.bench.size > 0) & self.bench.evidence.scoring.decides[: angles.blocks.count]
        allowed = angles.allowed_square[rows]
        mine, its = (np.maximum(whole.left_square[rows] - allowed, 0.0) for whole in (self, other))
        if mine.sum() < (1 - LITTLE) * its.sum():
            return True
        gain = self.gain_over(other)[rows][np.abs(mine - its) > LITTLE * allowed]
        return bool(gain.sum() > LEAST_GAIN * gain.size)

    def gain_over(self, other: Whole) -> Floats:
        """(B,) gain of each block's score on fitted runs over ``other``, where it decides; else zero."""
        angles = self.bench.evidence.angles
        rows = (self.bench.size > 0) & self.bench.evidence.scoring.decides[: angles.blocks.count]
        mine, its = (np.maximum(w.left_square - angles.allowed_square, 0.0) for w in (self, other))
        spread = as_wide_as(self.bench, other.left_square)
        return np.where(rows, 0.5 * (np.log1p(its / spread) - np.log1p(mine / spread)), 0.0)

    def reduced(self) -> Wear:
        """Take out of each joint what it can do without, the least of it first."""
        bench, theta = self.bench, self.theta.copy()
        every = np.ones((len(bench.joints), len(bench.terms)), dtype=bool)
        spread = as_wide_as(bench, self.left_square)

        def without(kept: Bools, start: Floats) -> tuple[Floats, Floats]:
            found = minimise(bench.problem(kept, spread), start, FEWEST_STEPS, covariance=False).theta
            return found, bench.held_square(found, kept, spread)

        whole = bench.held_square(theta, every, spread)
        kept = every.copy()
        order = np.argsort(_losses(bench, theta, spread), axis=1, kind="stable")
        for turn in range(len(bench.terms)):
            less = kept.copy()
            less[np.arange(len(bench.joints)), order[:, turn]] = False
            fitted, square = without(less, theta)
            for u, j in enumerate(bench.columns):
                # against the whole: small losses add up
                lost = gain_on_joint(bench, j, spread, whole, square)
                if lost.z <= CLEAR or lost.mean <= ALIKE:
                    kept[u], theta[u] = less[u], fitted[u]
        return Wear(bench.terms, bench.joints, theta, kept)


def _losses(bench: Bench, theta: Floats, spread_square: Floats) -> Floats:
    """(U, K) cost of doing without each effect on each joint, the others following as far as a straight line goes."""
    every = np.ones((len(bench.joints), len(bench.terms)), dtype=bool)
    problem = bench.problem(every, spread_square)
    _, residual, jacobian, weight = linearised(problem, theta)
    out = np.empty(every.shape)
    for k, part in enumerate(bench.parts):
        less = every.copy()
        less[:, k] = False
        gone = bench.residual(theta, less)
        others = np.delete(np.arange(theta.shape[1]), np.arange(part.start, part.stop))
        for u in range(len(bench.joints)):
            steep = jacobian[others, :, u]
            steep = steep[np.abs(steep).max(axis=1) > 0]
            curved = (steep * weight[:, u]) @ steep.T
            step = np.linalg.lstsq(curved, -(steep * weight[:, u]) @ gone[:, u], rcond=None)[0]
            left = gone[:, u] + step @ steep
            out[u, k] = float(weight[:, u] @ (np.square(left) - np.square(residual[:, u])))
    return out
