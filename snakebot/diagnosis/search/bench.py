"""Everyday effects joint by joint: joints do not disturb each other, so that one simulation serves all of them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.blocks import MeanDifference, mean_difference
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.fit_runs import StackedAngles
from snakebot.diagnosis.fit.hypothesis import Box, Hypothesis, Term
from snakebot.diagnosis.fit.least_squares import refit
from snakebot.diagnosis.fit.step import Problem
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.search.candidate import SIZE_BESIDE, Candidate, start_values
from snakebot.diagnosis.search.everyday import everyday_terms, is_one_of
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.sizes import LITTLE
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
            if not is_one_of(self.terms, term)
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


class Bench:
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

    def of_kinds(self, terms: tuple[Term, ...]) -> Bench:
        """The same effects with switches set otherwise."""
        out = copy(self)
        out.terms = terms
        return out

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

    def blocks_of(self, column: int) -> Bools:
        """(B,) the blocks of one joint (0-based) that are fitted."""
        return np.asarray((self.evidence.angles.blocks.joint == column) & (self.size > 0))

    def over(self, square: Floats, rows: Bools) -> float:
        """What mean squares (B,) are above the allowed ones, in all of some blocks (B,)."""
        return float(np.maximum(square[rows] - self.evidence.angles.allowed_square[rows], 0.0).sum())

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


@dataclass(frozen=True, eq=False)
class LaidOut:
    """What an explanation says of each joint, on a bench.

    Attributes:
        theta: (U, p) parameters of each joint; of an effect that it lacks, where a fit of it may begin.
        kept: (U, K) effects that it has.
    """

    bench: Bench
    theta: Floats
    kept: Bools


def laid_out(evidence: Evidence, library: Library, best: Trial, also: Collection[int]) -> LaidOut | None:
    """The everyday effects of which ``best`` says that joints have their own, joint by joint, beside all else that it
    says: of the joints that have one, and of ``also`` (1-based). None where all of these are there in another kind.
    """
    everyday = everyday_terms(library)
    parts = list(zip(best.hypothesis.terms, best.hypothesis.split(best.theta), strict=True))
    taken = {term.effect for term, _ in parts if not _is_of_joints(everyday, term)}
    of_joints = [(term, values) for term, values in parts if term.effect not in taken]
    terms = tuple(term for term in everyday if term.effect not in taken)
    joints = tuple(sorted({*also}.union(*(term.joints or () for term, _ in of_joints))))
    if not terms or not joints:
        return None
    rest = [spec for term, values in parts if term.effect in taken for spec in term.specs(values.tolist())]
    bench = Bench(evidence, terms, joints, rest)
    theta, kept = start_on(bench, library), np.zeros((len(joints), len(terms)), dtype=bool)
    for term, values in of_joints:
        k = next(i for i, other in enumerate(terms) if other.effect == term.effect)
        for joint, row in zip(term.joints or (), values.reshape(-1, len(terms[k].open)), strict=True):
            kept[joints.index(joint), k] = True
            theta[joints.index(joint), bench.parts[k]] = row
    return LaidOut(bench, theta, kept)


def _is_of_joints(everyday: Sequence[Term], term: Term) -> bool:
    """Whether a term is an everyday effect of which each joint has its own."""
    return is_one_of(everyday, term) and term.joints is not None and len(term.alike) == len(term.joints)


def start_on(bench: Bench, library: Library) -> Floats:
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


def gain_on_joint(
    bench: Bench, joint: int, spread_square: Floats, better: Floats, worse: Floats
) -> MeanDifference:
    """Mean gain on the deciding blocks of one joint (0-based) that change, against the spread that its fit reckons
    with: what no everyday effect is exact to decides nothing.
    """
    angles = bench.evidence.angles
    changed = np.abs(better - worse) > LITTLE * angles.allowed_square
    rows = changed & bench.blocks_of(joint)
    if not rows.any():
        return MeanDifference(0.0, 0.0)
    gain = 0.5 * (np.log1p(worse / spread_square) - np.log1p(better / spread_square))[rows]
    return mean_difference(gain, angles.blocks.run[rows])


def as_wide_as(bench: Bench, square: Floats) -> Floats:
    """(B,) spread at least as wide as what is left on a joint, in the middle of its blocks."""
    out = bench.evidence.angles.allowed_square.copy()
    for j in bench.columns:
        mine = bench.blocks_of(j)
        if mine.any():
            out[mine] = np.maximum(out[mine], float(np.median(square[mine])))
    return out
