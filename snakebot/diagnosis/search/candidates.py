"""Which explanations are tried: for every effect the joints it helps on, and where a fit should start."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from itertools import product

import numpy as np

from snakebot.arrays import Floats, Ints
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.blocks import BlockMap, mean_difference
from snakebot.diagnosis.evidence.gap import beyond, gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import ALIKE, Scoring
from snakebot.diagnosis.fit.hypothesis import Fixed, Hypothesis, Term, fixed_by
from snakebot.diagnosis.fit.trial import Trial, each_joint
from snakebot.diagnosis.search.candidate import Candidate, added, scaled, start_values
from snakebot.diagnosis.search.ground_candidates import ground_candidates
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.sizes import BEYOND_CHANCE, CLEAR, HALF, LITTLE, MUCH, SOME
from snakebot.effects.effect import Effect
from snakebot.effects.observed import Observed
from snakebot.effects.registry import find_effect


def candidates(evidence: Evidence, library: Library, base: Trial, effect: Effect) -> list[Candidate]:
    """Ways to add ``effect`` to what ``base`` says."""
    if effect.stage == "body":
        return ground_candidates(evidence, library, base, effect)
    if effect.is_read_off:
        return _read_off(library, base, effect)
    if not effect.per_joint:
        if any(term.effect == effect.name for term in base.hypothesis.terms):
            return []
        term = Term(effect.name, None, fixed_by(library.known, effect.name))
        every = tuple(range(evidence.data.joints))
        starts = _spread(term, [start_values(term, s) for s in effect.starts(library.observed, every)])
        return [added(base, term, starts)]
    return _per_joint(evidence, library, base, effect)


def _spread(term: Term, starts: Sequence[Floats]) -> list[Floats]:
    """More starts about the given ones: a flat stretch on one side must not catch the search. But an effect of which
    several are followed brings as many as it needs.
    """
    if not term.open:
        return [np.zeros(0)] if starts else []
    if find_effect(term.effect).followed > 1:
        return list(starts)
    factors = (1.0, 1 / CLEAR, CLEAR)
    return [scaled(term, start, factor) for start, factor in product(starts, factors)]


def _per_joint(evidence: Evidence, library: Library, base: Trial, effect: Effect) -> list[Candidate]:
    joints = evidence.data.joints
    taken = {
        j
        for t in base.hypothesis.terms
        if t.effect == effect.name
        for j in (t.joints or range(1, joints + 1))
    }
    return [
        candidate
        for fixed in kinds(library, effect)
        for candidate in _of_kind(evidence, library, base, effect, fixed, taken)
    ]


def kinds(library: Library, effect: Effect) -> list[Fixed]:
    """Parameters that are not fitted: what the user knows, no fit could tell of or the data show, with each setting of
    the effect's switches.
    """
    known = tuple({**effect.held(library.observed), **dict(fixed_by(library.known, effect.name))}.items())
    switches = [
        p for p in effect.parameters if p.integer and p.upper - p.lower == 1 and p.name not in dict(known)
    ]
    return [
        (*known, *((p.name, value) for p, value in zip(switches, values, strict=True)))
        for values in product(*((p.lower, p.upper) for p in switches))
    ]


def elsewhere(evidence: Evidence, library: Library, base: Trial) -> Candidate | None:
    """The last effect of ``base`` on further joints too, each with a value of its own, where that closes their gap.

    None unless two joints differ in it already: a robot put together by hand, not one joint with a fault.
    """
    term = base.hypothesis.terms[-1]
    effect = find_effect(term.effect)
    taken = {j for t in base.hypothesis.terms if t.effect == term.effect for j in t.joints or ()}
    same = sum(t.effect == term.effect for t in base.hypothesis.terms)
    if term.joints is None or not term.open or same < 2:
        return None
    gap = gap_of(evidence.scoring, base.held_square)
    further = [int(j) for j in np.flatnonzero(gap.significant) if j + 1 not in taken]
    if not further:
        return None
    terms, starts = _one_each(library.observed, effect, term.fixed)
    if evidence.predictor.simulator.always_needs_body(terms[0].specs(starts[0][0])):
        return None
    runs, fit = each_joint(evidence.beside(base.specs), base, terms, starts)
    closed = [j for j in further if not _left_over(evidence.angles, runs, fit.residual, j)]
    if not closed:
        return None
    hypothesis = Hypothesis((*base.hypothesis.terms, *(terms[j] for j in closed)))
    return Candidate(hypothesis, [np.concatenate([base.theta, *(fit.theta[j] for j in closed)])])


def _left_over(angles: AngleEvidence, runs: Sequence[int], residual: Floats, joint: int) -> bool:
    """Whether (N, k) residuals of some runs, stacked, are beyond noise and tolerance on one joint."""
    names, square = _block_squares(angles.blocks, runs, residual, joint)
    return beyond(square, angles.allowed_square[names], angles.blocks.run[names])


def _one_each(observed: Observed, effect: Effect, fixed: Fixed) -> tuple[list[Term], list[Floats]]:
    """A term for each joint alone, and where to start them, each (k, p)."""
    terms = [Term(effect.name, (j + 1,), fixed) for j in range(observed.robot.joints)]
    rows = [
        _spread(t, [start_values(t, s) for s in effect.starts(observed, (j,))]) for j, t in enumerate(terms)
    ]
    starts = [np.stack([row[min(i, len(row) - 1)] for row in rows]) for i in range(max(map(len, rows)))]
    return terms, starts


def _of_kind(
    evidence: Evidence, library: Library, base: Trial, effect: Effect, fixed: Fixed, taken: Set[int]
) -> list[Candidate]:
    joints = evidence.data.joints
    terms, starts = _one_each(library.observed, effect, fixed)
    simulator, first = evidence.predictor.simulator, terms[0].specs(starts[0][0])
    if simulator.rough_needs_body(first):
        return _coupled(evidence.scoring, evidence.data.joints, library, base, effect, fixed, taken)
    runs, fit = each_joint(evidence, base, terms, starts)
    gains = [_joint_gain(evidence.angles, base, runs, fit.residual, j) for j in range(joints)]
    # Where a first look takes the torques of the measured motion, with the noise of its readings, what scatters is
    # mostly the look itself: there one standard error will do.
    clear_se = 1.0 if simulator.needs_body(first) else CLEAR
    helped = [j for j in helped_joints(evidence.scoring, base, gains, clear_se) if j + 1 not in taken]
    if not helped:
        return []
    subsets = [tuple(helped)]
    if len(helped) >= max(2, joints // 2) and len(helped) < joints and not taken:
        subsets.append(tuple(range(joints)))
    out = []
    for subset in subsets:
        term = Term(effect.name, _named(subset, joints), fixed)
        inside = fit.theta[list(helped)]
        begin = [np.median(inside, axis=0)]
        begin += _spread(term, [start_values(term, s) for s in effect.starts(library.observed, subset)])[:1]
        out.append(added(base, term, begin if term.open else [np.zeros(0)]))
        if len(subset) > 1 and term.open and _uneven(inside):
            best = int(np.argmax([gains[j].total for j in subset]))
            alone = Term(effect.name, (subset[best] + 1,), fixed)
            out.append(added(base, alone, [fit.theta[subset[best]]]))
    return out


def _named(subset: Sequence[int], count: int) -> tuple[int, ...] | None:
    """1-based joints; None for all of them."""
    return None if len(subset) == count else tuple(int(j) + 1 for j in subset)


def _coupled(
    scoring: Scoring,
    joints_of_robot: int,
    library: Library,
    base: Trial,
    effect: Effect,
    fixed: Fixed,
    taken: Set[int],
) -> list[Candidate]:
    """An effect that couples all joints, so that they cannot be tried at once: on those with a gap, together
    and alone.
    """
    gap = gap_of(scoring, base.held_square)
    joints = [int(j) for j in np.flatnonzero(gap.significant) if j + 1 not in taken]
    if not joints:
        return []
    subsets = [tuple(joints)]
    if joints_of_robot > len(joints) >= max(2, joints_of_robot // 2):
        subsets.append(tuple(range(joints_of_robot)))
    alone = joints if len(joints) <= SOME else [j for j in joints if gap.joint_shares[j] > HALF]
    subsets += [(j,) for j in alone] if len(joints) > 1 else []
    out = []
    for subset in subsets:
        term = Term(effect.name, _named(subset, joints_of_robot), fixed)
        begin = [start_values(term, s) for s in effect.starts(library.observed, subset)]
        out.append(added(base, term, begin if term.open else [np.zeros(0)]))
    return out


def _uneven(theta: Floats) -> bool:
    """Whether the joints want different values, so that one of them may be the only one with the effect."""
    spread = np.ptp(theta, axis=0)
    return bool(np.any(spread > MUCH * np.abs(np.median(theta, axis=0))))


@dataclass(frozen=True)
class JointGain:
    """What an effect gains on one joint: summed over all blocks, and its mean over those where it does something, with
    the number of standard errors. A limit that is reached in one run says nothing in the others.
    """

    total: float
    mean: float
    z: float


def _joint_gain(
    angles: AngleEvidence, base: Trial, runs: Sequence[int], residual: Floats, joint: int
) -> JointGain:
    """The gain on one joint of (N, k) residuals of some runs, stacked."""
    names, new = _block_squares(angles.blocks, runs, residual, joint)
    allowed = angles.allowed_square[names]
    old = base.fitted_square[names]
    gain = 0.5 * (np.log1p(old / allowed) - np.log1p(new / allowed))
    moved = np.abs(new - old) > LITTLE * allowed
    if moved.sum() < 2:
        return JointGain(0.0, 0.0, 0.0)
    difference = mean_difference(gain[moved], angles.blocks.run[names[moved]])
    return JointGain(float(gain.sum()), difference.mean, difference.z)


def _block_squares(
    blocks: BlockMap, runs: Sequence[int], residual: Floats, joint: int
) -> tuple[Ints, Floats]:
    """Numbers (b,) of one joint's blocks in some runs, and the mean squares (b,) there of (N, k) residuals."""
    block = np.concatenate([blocks.of_sample[i][:, joint] for i in runs])
    used = block >= 0
    names, index, counts = np.unique(block[used], return_inverse=True, return_counts=True)
    return names, np.bincount(index, weights=np.square(residual[used, joint])) / counts


def helped_joints(scoring: Scoring, base: Trial, gains: Sequence[JointGain], clear_se: float) -> list[int]:
    """0-based joints with a gap, on which the gain over ``base`` is clear by so many standard errors, or more in all
    than chance comes to: what a limit does in a few moments differs from one to the next by more than any noise. Less
    than ``acceptance.LEAST_GAIN`` will do: held-out gaits decide with that whether the effect is accepted.
    """
    gap = gap_of(scoring, base.held_square).significant
    least = MUCH * max((g.total for j, g in enumerate(gains) if gap[j]), default=0.0)
    beyond_chance = 0.5 * BEYOND_CHANCE**2  # log likelihood of so many standard deviations
    return [
        j
        for j, g in enumerate(gains)
        if gap[j] and (g.z > clear_se or g.total > beyond_chance) and g.mean > ALIKE and g.total > least
    ]


def _read_off(library: Library, base: Trial, effect: Effect) -> list[Candidate]:
    if base.hypothesis.terms:
        return []
    found = effect.read_off(library.observed)
    if found is None:
        return []
    return [added(base, Term(effect.name, found.joints, tuple(found.values.items())), [np.zeros(0)])]
