"""Which explanations are worth a trial: for every effect the joints it helps on, and where a fit should start."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.blocks import mean_difference
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.data import link_is_clean
from snakebot.diagnosis.gap import beyond, gap_of
from snakebot.diagnosis.hypothesis import Hypothesis, Term, fixed_by
from snakebot.diagnosis.score import CHANGED
from snakebot.diagnosis.trial import Trial, each_joint
from snakebot.effects.effect import Effect
from snakebot.effects.registry import effects, find_effect

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Fixed = tuple[tuple[str, float | tuple[float, ...]], ...]

HELPS_SE = 2.5  # an effect helps on a joint when its gain there is this many standard errors
HELPS_SCORE = 0.03  # ... and at least this much (0.05: a tenth of the mean square)
HELPS_SHARE = 0.2  # ... and at least this share of what it does for the joint it helps most
MOST_ALONE = 3  # joints tried one by one where each trial is dear ...
MOST_OF_IT = 0.4  # ... or else those with this share of the gap
SPREAD_STARTS = (1.0, 0.4, 2.5)  # factors on a start, for positive parameters

# Effects that leave no mark on the mean of the readings; found by other means.
NOT_FITTED = frozenset({"encoder_noise"})


@dataclass(frozen=True, eq=False)
class Candidate:
    """A hypothesis and where to start it, each (p,)."""

    hypothesis: Hypothesis
    starts: list[Floats]


def usable_effects(context: Context, only: Sequence[str] = (), exclude: Sequence[str] = ()) -> list[Effect]:
    """Effects that this robot can show and that the user has not ruled out."""
    robot = context.data.robot
    out = []
    clean = link_is_clean(context.data)
    for effect in effects().values():
        if effect.stage == "link" and clean and effect.name not in only:
            continue
        if effect.name in exclude or (only and effect.name not in only) or effect.name in NOT_FITTED:
            continue
        if not effect.applies_to(robot) or (effect.stage == "body" and context.ground is None):
            continue
        if effect.name == "joint_free" and robot.body is None:
            continue  # nothing would say how it swings
        if effect.name == "wiring" and robot.joints == 1 and context.observed.correlation[0, 0] > 0:
            continue
        out.append(effect)
    return out


def candidates(context: Context, base: Trial, effect: Effect) -> list[Candidate]:
    """Ways to add ``effect`` to what ``base`` says."""
    if effect.stage == "body":
        return _body(context, base, effect)
    if effect.name == "wiring":
        return _wiring(context, base)
    if not effect.per_joint:
        if any(term.effect == effect.name for term in base.hypothesis.terms):
            return []
        term = Term(effect.name, None, fixed_by(context.known, effect.name))
        every = tuple(range(context.data.joints))
        starts = _spread(term, [_values(term, s) for s in effect.starts(context.observed, every)])
        return [_candidate(base, term, starts)]
    return _per_joint(context, base, effect)


def _candidate(base: Trial, term: Term, starts: Sequence[Floats]) -> Candidate:
    return Candidate(base.hypothesis.plus(term), [np.concatenate([base.theta, start]) for start in starts])


def _values(term: Term, start: object) -> Floats:
    assert isinstance(start, dict)
    return np.array([float(start.get(p.name, p.typical)) for p in term.open])


def _spread(term: Term, starts: Sequence[Floats]) -> list[Floats]:
    """More starts about the given ones: a flat stretch on one side must not catch the search."""
    out = []
    for start, factor in product(starts, SPREAD_STARTS):
        if not term.open:
            return [np.zeros(0)]
        moved = start.copy()
        if factor != 1.0:
            if term.open[0].name == "gain":  # about one, not about zero
                moved[0] = 1 + (moved[0] - 1) * factor
            else:
                moved[0] *= factor
        moved = np.array([p.clip(float(v)) for p, v in zip(term.open, moved, strict=True)])
        out.append(moved)
    return out


def _per_joint(context: Context, base: Trial, effect: Effect) -> list[Candidate]:
    joints = context.data.joints
    taken = {
        j
        for t in base.hypothesis.terms
        if t.effect == effect.name
        for j in (t.joints or range(1, joints + 1))
    }
    return [
        candidate
        for fixed in _kinds(context, effect)
        for candidate in _of_kind(context, base, effect, fixed, taken)
    ]


def _kinds(context: Context, effect: Effect) -> list[Fixed]:
    """Parameters that are not fitted: what the user knows, with each setting of the effect's switches."""
    known = fixed_by(context.known, effect.name)
    switches = [
        p for p in effect.parameters if p.integer and p.upper - p.lower == 1 and p.name not in dict(known)
    ]
    return [
        (*known, *((p.name, value) for p, value in zip(switches, values, strict=True)))
        for values in product(*((p.lower, p.upper) for p in switches))
    ]


def elsewhere(context: Context, base: Trial) -> Candidate | None:
    """The last effect of ``base`` on further joints too, each with a value of its own, where that closes their gap.

    None unless two joints differ in it already: a robot put together by hand, not one joint with a fault.
    """
    term = base.hypothesis.terms[-1]
    effect = find_effect(term.effect)
    taken = {j for t in base.hypothesis.terms if t.effect == term.effect for j in t.joints or ()}
    same = sum(t.effect == term.effect for t in base.hypothesis.terms)
    if term.joints is None or not term.open or same < 2:
        return None
    further = [int(j) for j in np.flatnonzero(gap_of(context, base).significant) if j + 1 not in taken]
    if not further:
        return None
    terms, starts = _one_each(context, effect, term.fixed)
    if context.simulator.dear([terms[0].spec(starts[0][0])]):
        return None
    runs, fit = each_joint(context, base, terms, starts)
    closed = [j for j in further if not _left_over(context, runs, fit.residual, j)]
    if not closed:
        return None
    hypothesis = Hypothesis((*base.hypothesis.terms, *(terms[j] for j in closed)))
    return Candidate(hypothesis, [np.concatenate([base.theta, *(fit.theta[j] for j in closed)])])


def _left_over(context: Context, runs: Sequence[int], residual: Floats, joint: int) -> bool:
    """Whether (N, k) residuals of some runs, stacked, are beyond noise and tolerance on one joint."""
    names, square = _block_squares(context, runs, residual, joint)
    return beyond(square, context.allowed_square[names], context.block_run[names])


def _one_each(context: Context, effect: Effect, fixed: Fixed) -> tuple[list[Term], list[Floats]]:
    """A term for each joint alone, and where to start them, each (k, p)."""
    terms = [Term(effect.name, (j + 1,), fixed) for j in range(context.data.joints)]
    rows = [
        _spread(t, [_values(t, s) for s in effect.starts(context.observed, (j,))])
        for j, t in enumerate(terms)
    ]
    starts = [np.stack([row[min(i, len(row) - 1)] for row in rows]) for i in range(max(map(len, rows)))]
    return terms, starts


def _of_kind(context: Context, base: Trial, effect: Effect, fixed: Fixed, taken: Set[int]) -> list[Candidate]:
    joints = context.data.joints
    terms, starts = _one_each(context, effect, fixed)
    if terms and context.simulator.dear([terms[0].spec(starts[0][0])]):
        return _dear(context, base, effect, fixed, taken)
    runs, fit = each_joint(context, base, terms, starts)
    gains = [_joint_gain(context, base, runs, fit.residual, j) for j in range(joints)]
    helped = [j for j in helped_joints(context, base, gains) if j + 1 not in taken]
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
        begin += _spread(term, [_values(term, s) for s in effect.starts(context.observed, subset)])[:1]
        out.append(_candidate(base, term, begin if term.open else [np.zeros(0)]))
        if len(subset) > 1 and term.open and _uneven(inside):
            best = int(np.argmax([gains[j].total for j in subset]))
            alone = Term(effect.name, (subset[best] + 1,), fixed)
            out.append(_candidate(base, alone, [fit.theta[subset[best]]]))
    return out


def _named(subset: Sequence[int], count: int) -> tuple[int, ...] | None:
    """1-based joints; None for all of them."""
    return None if len(subset) == count else tuple(int(j) + 1 for j in subset)


def _dear(context: Context, base: Trial, effect: Effect, fixed: Fixed, taken: Set[int]) -> list[Candidate]:
    """An effect that couples all joints, so that they cannot be tried at once: on those with a gap, together
    and alone.
    """
    gap = gap_of(context, base)
    joints = [int(j) for j in np.flatnonzero(gap.significant) if j + 1 not in taken]
    if not joints:
        return []
    subsets = [tuple(joints)]
    if context.data.joints > len(joints) >= max(2, context.data.joints // 2):
        subsets.append(tuple(range(context.data.joints)))
    alone = joints if len(joints) <= MOST_ALONE else [j for j in joints if gap.joint_shares[j] > MOST_OF_IT]
    subsets += [(j,) for j in alone] if len(joints) > 1 else []
    out = []
    for subset in subsets:
        term = Term(effect.name, _named(subset, context.data.joints), fixed)
        begin = [_values(term, s) for s in effect.starts(context.observed, subset)]
        out.append(_candidate(base, term, begin if term.open else [np.zeros(0)]))
    return out


def _uneven(theta: Floats) -> bool:
    """Whether the joints want different values, so that one of them may be the only one with the effect."""
    spread = np.ptp(theta, axis=0)
    return bool(np.any(spread > 0.3 * np.abs(np.median(theta, axis=0))))


@dataclass(frozen=True)
class JointGain:
    """What an effect gains on one joint: summed over all blocks, and its mean over those where it does something, with
    the number of standard errors. A limit that is reached in one run says nothing in the others.
    """

    total: float
    mean: float
    z: float


def _joint_gain(
    context: Context, base: Trial, runs: Sequence[int], residual: Floats, joint: int
) -> JointGain:
    """The gain on one joint of (N, k) residuals of some runs, stacked."""
    names, new = _block_squares(context, runs, residual, joint)
    allowed = context.scale.square[names]
    old = base.fitted_square[names]
    gain = 0.5 * (np.log1p(old / allowed) - np.log1p(new / allowed))
    moved = np.abs(new - old) > CHANGED * allowed
    if moved.sum() < 2:
        return JointGain(0.0, 0.0, 0.0)
    difference = mean_difference(gain[moved], context.angle_blocks.run[names[moved]])
    return JointGain(float(gain.sum()), difference.mean, difference.z)


def _block_squares(
    context: Context, runs: Sequence[int], residual: Floats, joint: int
) -> tuple[Ints, Floats]:
    """Numbers (b,) of one joint's blocks in some runs, and the mean squares (b,) there of (N, k) residuals."""
    block = np.concatenate([context.angle_blocks.of_sample[i][:, joint] for i in runs])
    used = block >= 0
    names, index, counts = np.unique(block[used], return_inverse=True, return_counts=True)
    return names, np.bincount(index, weights=np.square(residual[used, joint])) / counts


def helped_joints(context: Context, base: Trial, gains: Sequence[JointGain]) -> list[int]:
    """0-based joints with a gap, on which the gain over ``base`` is clear."""
    gap = gap_of(context, base).significant
    least = HELPS_SHARE * max((g.total for j, g in enumerate(gains) if gap[j]), default=0.0)
    return [
        j
        for j, g in enumerate(gains)
        if gap[j] and g.z > HELPS_SE and g.mean > HELPS_SCORE and g.total > least
    ]


def _wiring(context: Context, base: Trial) -> list[Candidate]:
    if base.hypothesis.terms:
        return []
    joints = context.data.joints
    (start,) = find_effect("wiring").starts(context.observed, tuple(range(joints)))
    order, signs = start["permutation"], start["signs"]
    assert isinstance(order, tuple)
    assert isinstance(signs, tuple)
    wrong = [j for j in range(joints) if int(order[j]) != j + 1 or signs[j] < 0]
    if not wrong:
        return []
    fixed: list[tuple[str, float | tuple[float, ...]]] = []
    if any(int(order[j]) != j + 1 for j in wrong):
        fixed.append(("permutation", tuple(order[j] for j in wrong)))
    fixed.append(("signs", tuple(signs[j] for j in wrong)))
    return [_candidate(base, Term("wiring", tuple(j + 1 for j in wrong), tuple(fixed)), [np.zeros(0)])]


def _body(context: Context, base: Trial, effect: Effect) -> list[Candidate]:
    if any(term.effect == effect.name for term in base.hypothesis.terms):
        return []
    known = fixed_by(context.known, effect.name)
    every = tuple(range(context.data.joints))
    starts = effect.starts(context.observed, every)
    options: dict[Term, list[Floats]] = {}
    if effect.name == "ground_friction":
        scales = [p.name for p in effect.parameters]
        for name in scales:  # one coefficient is off, or all may be
            term = Term(
                effect.name, None, (*known, *((s, 1.0) for s in scales if s != name and s not in dict(known)))
            )
            options[term] = [_values(term, start) for start in starts]
        term = Term(effect.name, None, known)
        options[term] = [_values(term, start) for start in starts]
    else:
        whole = {p.name for p in effect.parameters if p.integer}
        for start in starts:
            picked = tuple((k, v) for k, v in start.items() if k in whole and k not in dict(known))
            term = Term(effect.name, None, (*known, *picked))
            options.setdefault(term, []).append(_values(term, start))
    found = [_candidate(base, term, begin) for term, begin in options.items() if _fits(context, term)]
    return _promising(context, base, found) if len(found) > 3 else found


def _fits(context: Context, term: Term) -> bool:
    from snakebot.errors import BadInputError

    try:
        term.spec([p.typical for p in term.open]).checked(context.data.robot)
    except BadInputError:
        return False
    return True


def _promising(context: Context, base: Trial, found: list[Candidate], keep: int = 2) -> list[Candidate]:
    """The ``keep`` best of many alternatives (which link), by what a straight line from the start promises."""
    ground = context.ground
    assert ground is not None
    reference = context.ground_features(base.specs)
    residual = ground.value - reference
    weight = 1 / (context.ground_allowed_square + np.square(residual))
    rank = []
    for candidate in found:
        if len(candidate.hypothesis.terms[-1].open) != 1:
            rank.append(-np.inf)  # several parameters: no straight line, keep it
            continue
        moved = context.ground_features(candidate.hypothesis.specs(candidate.starts[0])) - reference
        usable = np.isfinite(moved) & np.isfinite(residual)
        slope = float(
            (moved * weight * residual)[usable].sum() / max((moved**2 * weight)[usable].sum(), 1e-300)
        )
        left = residual - slope * moved
        rank.append(float(np.log1p(np.square(left) / context.ground_allowed_square)[usable].mean()))
    order = np.argsort(rank, kind="stable")
    wide = sum(np.isneginf(rank))
    return [found[i] for i in order[: keep + wide]]
