"""Worn joints: all everyday effects are fitted at once, then those that a joint does not need are taken out.

Effects that only help together (an offset and a play) are not found one by one. But joints do not disturb each other,
so that all everyday effects of all joints can be fitted at once: one simulation serves every joint. What a joint
needs on runs left out of the fit stays, and becomes one explanation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.blocks import MeanDifference, mean_difference
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import ALIKE, Scoring
from snakebot.diagnosis.fit.fit_runs import StackedAngles
from snakebot.diagnosis.fit.fold_fits import NEAR_STEPS
from snakebot.diagnosis.fit.hypothesis import Box, Hypothesis, Term
from snakebot.diagnosis.fit.least_squares import FEWEST_STEPS, linearised, minimise, refit, wide_allowance
from snakebot.diagnosis.fit.step import Problem
from snakebot.diagnosis.fit.trial import COSTLY_STEPS, Trial, run_trial_against
from snakebot.diagnosis.result import CLEAR_SE, LITTLE
from snakebot.diagnosis.search.acceptance import (
    LEAST_GAIN,
    excess,
    excess_as_fitted,
    may_be_named,
)
from snakebot.diagnosis.search.candidate import SIZE_BESIDE, Candidate, start_values
from snakebot.diagnosis.search.candidates import kinds
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.search.rounds import FOLLOWED_UP, NEARLY, ranked
from snakebot.effects.registry import find_effect
from snakebot.effects.spec import EffectSpec


@dataclass(frozen=True, eq=False)
class Wear:
    """Everyday effects on the joints that have a gap.

    Attributes:
        terms: (K,) the effects, of no joint in particular.
        joints: (U,) 1-based.
        theta: (U, p) parameters of each joint, effect by effect.
        kept: (U, K) effects that a joint cannot do without.
    """

    terms: tuple[Term, ...]
    joints: tuple[int, ...]
    theta: Floats
    kept: Bools

    def added_to(self, base: Hypothesis, theta: Floats) -> Candidate | None:
        """``base`` at ``theta`` with the effects that joints cannot do without; None where there are none.

        Everyday effects that ``base`` names itself are taken over by these.
        """
        parts = [
            (term, values)
            for term, values in zip(base.terms, base.split(theta), strict=True)
            if not _is_one_of(self.terms, term)
        ]
        at = 0
        for k, term in enumerate(self.terms):
            own = slice(at, at + len(term.open))
            at = own.stop
            rows = np.flatnonzero(self.kept[:, k])
            if rows.size:
                joints = tuple(self.joints[u] for u in rows)
                parts.append(
                    (replace(term, joints=joints, own=len(joints) > 1), self.theta[rows, own].ravel())
                )
        if not self.kept.any():
            return None
        return Candidate(Hypothesis(tuple(t for t, _ in parts)), [np.concatenate([v for _, v in parts])])


def with_wear(
    evidence: Evidence, library: Library, nominal: Trial, first: Trial, fits: Sequence[Trial]
) -> tuple[Evidence, Trial | None]:
    """The evidence with the misfit that all everyday effects together leave; and the everyday effects that the joints
    need, alone or beside a fault, if they explain clearly more than ``first`` does. A fault must gain over them alone,
    but for one that takes the place of one of them: that explains no less.

    ``fits``: of single effects, and of two, those that may be the faults among them, as fitted.
    """
    whole = worn(evidence, library, nominal)
    if whole is None:
        return evidence, None
    evidence = evidence.with_misfit(whole.left_square)
    alone = _accepted(evidence, nominal, first, whole.reduced().added_to(nominal.hypothesis, nominal.theta))
    found, everyday = [alone], _everyday_terms(library)
    for fault in _faults(evidence.scoring, library, nominal, first, fits):
        with_fault = worn(evidence, library, fault)
        if with_fault is None:
            continue
        instead = _takes_a_place(everyday, fault.hypothesis)
        if instead or with_fault.leaves_less_than(whole):
            candidate = with_fault.reduced().added_to(fault.hypothesis, fault.theta)
            found.append(_accepted(evidence, nominal, first if instead else alone or first, candidate))
    ordered = ranked(evidence.scoring, [trial for trial in found if trial is not None])
    return evidence, next(iter(ordered), None)


def _faults(
    scoring: Scoring, library: Library, nominal: Trial, first: Trial, fits: Sequence[Trial]
) -> list[Trial]:
    """What everyday effects are tried beside: ``first``, unless it is one of them, and what takes most of the gap away,
    with the next of those that do nearly as well: which of them it is may show when the everyday effects are there.

    The score hardly changes with a fault of a few moments before the everyday effects are in the prediction.
    """
    everyday = _everyday_terms(library)
    gap_square = excess(scoring, nominal, scoring.of_angles)
    fault, left = _all_but(everyday, first.hypothesis), {}
    nearest: dict[str, Trial] = {}
    for trial in fits:
        if _all_but(everyday, trial.hypothesis) == trial.hypothesis.terms:
            left[trial] = excess_as_fitted(scoring, trial, scoring.of_angles)
    for trial in sorted(left, key=left.__getitem__):
        nearest.setdefault(trial.hypothesis.terms[-1].effect, trial)

    def does_well(trial: Trial) -> bool:
        peers = (left[t] for t in left if len(t.hypothesis.terms) == len(trial.hypothesis.terms))
        return left[trial] < min((1 - LITTLE) * gap_square, (1 + NEARLY) * min(peers))

    others = [t for t in nearest.values() if t.hypothesis.terms != fault and does_well(t)][:FOLLOWED_UP]
    return [first, *others] if fault else others


def is_worn(library: Library, hypothesis: Hypothesis) -> bool:
    """Whether an explanation says nothing but everyday effects, or nothing at all."""
    return not _all_but(_everyday_terms(library), hypothesis)


def _everyday_terms(library: Library) -> tuple[Term, ...]:
    """The effects that every real joint has a little of, as the library holds them, of no joint in particular."""
    return tuple(
        Term(effect.name, None, kinds(library, effect)[0])
        for effect in library.effects
        if effect.everyday and kinds(library, effect)
    )


def _all_but(everyday: Sequence[Term], hypothesis: Hypothesis) -> tuple[Term, ...]:
    """The terms of an explanation that are none of the everyday effects."""
    return tuple(term for term in hypothesis.terms if not _is_one_of(everyday, term))


def _takes_a_place(everyday: Sequence[Term], hypothesis: Hypothesis) -> bool:
    """Whether an explanation has an everyday effect, of another kind than every joint has a little of."""
    names = {term.effect for term in everyday}
    return any(term.effect in names for term in _all_but(everyday, hypothesis))


def _is_one_of(everyday: Sequence[Term], term: Term) -> bool:
    """Whether an explanation's term is an everyday effect, of whatever joints. Play that the load takes up is not: it
    is another play than the one that every joint has a little of, and it needs the whole body.
    """
    return any(term.effect == other.effect and term.fixed == other.fixed for other in everyday)


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
    everyday = _everyday_terms(library)
    taken = {term.effect for term in _all_but(everyday, base.hypothesis)}
    terms = tuple(term for term in everyday if term.effect not in taken)
    if not joints or not terms:
        return None
    rest = [
        spec
        for term, values in zip(base.hypothesis.terms, base.hypothesis.split(base.theta), strict=True)
        if not _is_one_of(terms, term)
        for spec in term.specs(values.tolist())
    ]
    return _whole(_Bench(evidence, terms, joints, rest), library)


class _Bench:
    """The joints with a gap, one unit each, under the runs that may be fitted. Where the whole body must be simulated
    for what else there is, what that changes is taken to be the same with the everyday effects as without.
    """

    def __init__(
        self, evidence: Evidence, terms: tuple[Term, ...], joints: tuple[int, ...], rest: Sequence[EffectSpec]
    ) -> None:
        self.evidence, self.terms, self.joints, self.rest = evidence, terms, joints, tuple(rest)
        self.columns = [j - 1 for j in joints]
        self.runs = evidence.split.free
        angles = evidence.angles
        self.stacked = StackedAngles.of(angles, self.columns, self.runs, None)
        ends = np.cumsum([len(t.open) for t in terms])
        self.parts = [slice(int(e) - len(t.open), int(e)) for e, t in zip(ends, terms, strict=True)]
        self.box = Box.of([p for t in terms for p in t.open])
        self.block = self.stacked.block
        self.used = self.block >= 0
        self.size = np.bincount(self.block[self.used], minlength=angles.blocks.count)
        self.beside: Floats | float = 0.0
        if evidence.predictor.simulator.needs_body(self.rest):
            self.beside, self.rest = self._change_by(self.rest), ()

    def _change_by(self, specs: Sequence[EffectSpec]) -> Floats:
        """(N, U) what some effects change, all runs below each other."""
        simulator = self.evidence.predictor.simulator
        with_them, without = (
            self.stacked.residual([p.reading_rad for p in simulator.predict(some, self.runs)])
            for some in (specs, ())
        )
        return without - with_them

    def specs(self, theta: Floats, kept: Bools) -> list[EffectSpec]:
        out = list(self.rest)
        for joint, row, there in zip(self.joints, theta, kept, strict=True):
            for term, part, mine in zip(self.terms, self.parts, there, strict=True):
                if mine:
                    out += replace(term, joints=(joint,)).specs(row[part].tolist())
        return out

    def residual(self, theta: Floats, kept: Bools) -> Floats:
        """(N, U) of all runs that may be fitted."""
        simulator = self.evidence.predictor.simulator
        made = simulator.predict(self.specs(theta, kept), self.runs, rough=True, columns=self.columns)
        return self.stacked.residual([p.reading_rad for p in made]) - self.beside

    def square(self, residual: Floats) -> Floats:
        """(B,) mean squares of the blocks."""
        total = np.bincount(
            self.block[self.used], weights=np.square(residual[self.used]), minlength=self.size.size
        )
        return total / np.maximum(self.size, 1)

    def problem(self, kept: Bools, spread_square: Floats) -> Problem:
        unit = np.arange(len(self.joints))
        return Problem(partial(self.residual, kept=kept), unit, self.block, spread_square, *self.box)

    def held_square(self, theta: Floats, kept: Bools, spread_square: Floats) -> Floats:
        """(B,) mean squares of each fold's runs, predicted from what its other runs say; of all, if there is one."""
        folds = self.evidence.split.folds
        problem = self.problem(kept, spread_square)
        if not folds:
            return self.square(problem.residual(theta))
        run_of = self.evidence.angles.blocks.run
        uses = [self.used & np.isin(run_of[np.maximum(self.block, 0)], fold.fit) for fold in folds]
        held = np.zeros(self.size.size)
        for fold, near in zip(folds, refit(problem, theta, uses), strict=True):
            mine = np.isin(run_of, fold.score)
            held[mine] = self.square(problem.residual(near.theta))[mine]
        return held


def _start(bench: _Bench, library: Library) -> Floats:
    """(U, p) where to begin: each effect at a share of the size that it would have alone."""
    rows = []
    for column in bench.columns:
        row: list[float] = []
        for term in bench.terms:
            effect = find_effect(term.effect)
            alone = start_values(term, effect.starts(library.observed, (column,))[0])
            row += [
                p.clip(p.neutral + SIZE_BESIDE * (float(v) - p.neutral))
                for p, v in zip(term.open, alone, strict=True)
            ]
        rows.append(row)
    return np.array(rows)


def _whole(bench: _Bench, library: Library) -> Whole:
    """Fit all: by least squares first, then with the loss of the score."""
    allowed = bench.evidence.angles.allowed_square
    every = np.ones((len(bench.joints), len(bench.terms)), dtype=bool)
    begin = _start(bench, library)
    problem = bench.problem(every, allowed)
    wide = wide_allowance(problem, bench.residual(begin, every))
    theta = minimise(replace(problem, allowed_square=wide), begin, COSTLY_STEPS, covariance=False).theta
    spread = _as_wide_as(bench, bench.square(bench.residual(theta, every)))
    theta = minimise(bench.problem(every, spread), theta, NEAR_STEPS, covariance=False).theta
    return Whole(bench, theta, bench.square(bench.residual(theta, every)))


@dataclass(frozen=True, eq=False)
class Whole:
    """All everyday effects together, as fitted.

    Attributes:
        theta: (U, p) parameters of each joint, effect by effect.
        left_square: (B,) mean squares that they leave of the angles.
    """

    bench: _Bench
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
        changed = np.abs(mine - its) > LITTLE * allowed
        spread = _as_wide_as(self.bench, other.left_square)[rows]
        gain = 0.5 * (np.log1p(its / spread) - np.log1p(mine / spread))[changed]
        return bool(gain.sum() > LEAST_GAIN * gain.size)

    def reduced(self) -> Wear:
        """Take out of each joint what it can do without, the least of it first."""
        bench, theta = self.bench, self.theta.copy()
        every = np.ones((len(bench.joints), len(bench.terms)), dtype=bool)
        spread = _as_wide_as(bench, self.left_square)

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
                lost = _gain(bench, j, spread, whole, square)
                if lost.z <= CLEAR_SE or lost.mean <= ALIKE:
                    kept[u], theta[u] = less[u], fitted[u]
        return Wear(bench.terms, bench.joints, theta, kept)


def _losses(bench: _Bench, theta: Floats, spread_square: Floats) -> Floats:
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


def _gain(bench: _Bench, joint: int, spread_square: Floats, better: Floats, worse: Floats) -> MeanDifference:
    """Mean gain on the deciding blocks of one joint (0-based) that change, against the spread that its fit reckons
    with: what no everyday effect is exact to decides nothing.
    """
    angles = bench.evidence.angles
    changed = np.abs(better - worse) > LITTLE * angles.allowed_square
    rows = changed & (bench.size > 0) & (angles.blocks.joint == joint)
    if not rows.any():
        return MeanDifference(0.0, 0.0)
    gain = 0.5 * (np.log1p(worse / spread_square) - np.log1p(better / spread_square))[rows]
    return mean_difference(gain, angles.blocks.run[rows])


def _as_wide_as(bench: _Bench, square: Floats) -> Floats:
    """(B,) spread at least as wide as what is left on a joint, in the middle of its blocks."""
    angles = bench.evidence.angles
    out = angles.allowed_square.copy()
    for j in bench.columns:
        mine = (angles.blocks.joint == j) & (bench.size > 0)
        if mine.any():
            out[mine] = np.maximum(out[mine], float(np.median(square[mine])))
    return out
