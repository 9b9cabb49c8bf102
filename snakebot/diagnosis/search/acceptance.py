"""When an explanation is accepted: its gain is clear, large enough, and closes enough of the gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.blocks import MeanDifference
from snakebot.diagnosis.evidence.gap import Gap, gap_of
from snakebot.diagnosis.evidence.score import ALIKE, Scoring
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.sizes import CLEAR, HALF, LITTLE, NEXT_TO_NOTHING, NO_PERCENT
from snakebot.effects.registry import find_effect

MOST_LEFT = LITTLE  # share of the gap that what explains it may leave over beyond noise and tolerance
# Held-out score, half of a logarithm, that an effect must gain on the blocks that it changes: a tenth of their mean
# square.
LEAST_GAIN = HALF * LITTLE


def touched(scoring: Scoring, trial: Trial, base: Trial) -> Bools:
    """(B,) deciding blocks on which a trial does other than its base, better or worse, by more than little beside what
    is allowed.

    A limit that is reached in one gait of five says nothing in the other four.
    """
    changed = np.abs(trial.held_square - base.held_square) > LITTLE * scoring.allowed_square
    return np.asarray(changed & scoring.decides)


def lead(scoring: Scoring, trial: Trial, other: Trial) -> MeanDifference:
    """How far a trial leads another, on the blocks where they differ."""
    rows = touched(scoring, trial, other)
    if not rows.any():
        return MeanDifference(0.0, 0.0)
    return scoring.gain(trial.held_square, other.held_square, rows)


def accepted(scoring: Scoring, trial: Trial, base: Trial) -> bool:
    """Whether what was added to ``base`` gains more than two standard errors, and enough to matter, where there is a
    gap: by its score; or, where that does not fall, by the mean square that it takes away, of the first effect half of
    all. The score need not be clear of what a further one takes away where all that was added are everyday effects,
    every real joint has a little of them, and more than next to nothing of the gap is left.
    """
    rows = touched(scoring, trial, base)
    gap = gap_of(scoring, base.held_square)
    joints = [
        j for j in np.unique(scoring.joint[rows]) if (gap.ground_significant if j < 0 else gap.significant[j])
    ]
    if not joints:
        return False
    gain = scoring.gain(trial.held_square, base.held_square, rows)
    if gain.mean <= 0 or gains(gain):
        return gains(gain)
    sides = [scoring.of_ground if j < 0 else scoring.of_angles for j in (min(joints), max(joints))]
    clear, further = gain.z > CLEAR, bool(base.hypothesis.terms)
    least = LITTLE if further else HALF
    if any(_falls(scoring, trial, base, side, rows, least=least, clear=clear) for side in sides):
        return True
    added = [term for term in trial.hypothesis.terms if term not in base.hypothesis.terms]
    but_one = [but_the_best(trial.held_square, base.held_square, side) for side in sides]
    return (
        further
        and all(find_effect(term.effect).everyday for term in added)
        and any(
            _leaves_something(scoring, base, side)
            and _falls(scoring, trial, base, rest, rows, least=least, clear=True)
            for side, rest in zip(sides, but_one, strict=True)
        )
    )


def _leaves_something(scoring: Scoring, trial: Trial, side: Bools) -> bool:
    """Whether more than next to nothing of the gap is left on a side, as far as that is known."""
    if scoring.nominal_square is None:
        return True
    nominal = replace(trial, held_square=scoring.nominal_square)
    return _leaves_share(scoring, trial, nominal, NEXT_TO_NOTHING, side)


def but_the_best(square: Floats, before: Floats, rows: Bools) -> Bools:
    """(B,) ``rows`` without the block in which a mean square falls most: a single moment is no cause."""
    fell = np.where(rows, before - square, -np.inf)
    return np.asarray(rows & (np.arange(rows.size) != np.argmax(fell)))


def _falls(
    scoring: Scoring, trial: Trial, base: Trial, side: Bools, rows: Bools, *, least: float, clear: bool
) -> bool:
    """Whether a trial leaves clearly less above the allowed mean square than its base, by a share of it, ``least``;
    ``clear``: its score says so, which hardly changes with what only the quickest motions show.

    Else the score must on those of the ``rows`` (B,) alone where the two differ by more than the mean of what there is
    to take away: a fault that shows for a few moments takes nearly all of it, and the score over all hardly sees that.
    """
    there = excess(scoring, base, side)
    if excess(scoring, trial, side) >= (1 - least) * there:
        return False
    change = np.abs(trial.held_square - base.held_square)
    much = rows & side & (change > there * np.where(scoring.of_ground, scoring.allowed_square, 1.0))
    return clear or (bool(much.any()) and scoring.gain(trial.held_square, base.held_square, much).z > CLEAR)


def gains(gain: MeanDifference) -> bool:
    """Whether a gain is a clear one, and large enough to matter."""
    return gain.z > CLEAR and gain.mean > LEAST_GAIN


def as_good(scoring: Scoring, plainer: Trial, best: Trial) -> bool:
    """Whether what is said more plainly loses no score, in all and on each joint: what one of them clearly loses is
    little beside what the others scatter.
    """
    lost = scoring.gain(best.held_square, plainer.held_square)
    places = np.unique(scoring.joint[scoring.decides])
    on_each = (
        scoring.gain(best.held_square, plainer.held_square, scoring.decides & (scoring.joint == place))
        for place in places
    )
    return costs_nothing(lost) and not any(gains(loss) for loss in on_each)


def closes_nearly_as_much(scoring: Scoring, plainer: Trial, best: Trial, nominal: Trial) -> bool:
    """Whether what is said more plainly loses no score, or leaves little more of the whole gap."""
    return as_good(scoring, plainer, best) or all(
        excess(scoring, plainer, side) - excess(scoring, best, side)
        <= LITTLE * excess(scoring, nominal, side)
        for side in (scoring.of_angles, scoring.of_ground)
    )


def costs_nothing(loss: MeanDifference) -> bool:
    """Whether a loss is within a standard error, or next to nothing."""
    return loss.mean < max(loss.se, ALIKE)


def may_be_named(scoring: Scoring, trial: Trial, base: Trial, nominal: Trial) -> bool:
    """Whether what was added to ``base`` is accepted, and closes enough of the whole gap to be named."""
    return accepted(scoring, trial, base) and _closes_more(scoring, trial, base, nominal)


def _closes_more(scoring: Scoring, trial: Trial, base: Trial, nominal: Trial) -> bool:
    """Whether what was added closes enough of the whole gap, of the angles or over ground, to be named."""
    if not base.hypothesis.terms:
        return True
    side = scoring.of_ground if trial.hypothesis.terms[-1].stage == "body" else scoring.of_angles
    fell = excess(scoring, base, side) - excess(scoring, trial, side)
    return fell > NO_PERCENT * excess(scoring, nominal, side)


def closes_half(scoring: Scoring, trial: Trial, nominal: Trial) -> bool:
    """Whether at most half of the gap is left of the angles and over ground, wherever there is one."""
    gap = gap_of(scoring, nominal.held_square)
    return bool(trial.hypothesis.terms) and not _leaves_more(scoring, trial, nominal, HALF, gap)


def closed_enough(scoring: Scoring, trial: Trial, nominal: Trial, *, worn: bool = False) -> bool:
    """Whether too little for a further effect is left above what noise and tolerance allow.

    Of a ``worn`` robot with everyday effects on its joints more may be left: each of them is off a little from what it
    is taken for, and what is found beside them there is mostly not so.
    """
    most = MOST_LEFT if worn else NO_PERCENT
    return not _leaves_more(scoring, trial, nominal, most, gap_of(scoring, trial.held_square))


def leaves_next_to_nothing(scoring: Scoring, trial: Trial, nominal: Trial) -> bool:
    """Whether next to nothing of the gap is left: too little to look for a little of everything on every joint."""
    return not _leaves_more(scoring, trial, nominal, NEXT_TO_NOTHING, gap_of(scoring, trial.held_square))


def _leaves_more(scoring: Scoring, trial: Trial, nominal: Trial, share: float, gap: Gap) -> bool:
    """Whether more than a share of what ``nominal`` leaves is left, of the angles or over ground, where ``gap`` is."""
    return any(
        there and _leaves_share(scoring, trial, nominal, share, side)
        for there, side in (
            (gap.significant.any(), scoring.of_angles),
            (gap.ground_significant, scoring.of_ground),
        )
    )


def _leaves_share(scoring: Scoring, trial: Trial, nominal: Trial, share: float, side: Bools) -> bool:
    """Whether more than a share of what ``nominal`` leaves on a side is left."""
    return excess(scoring, trial, side) > share * excess(scoring, nominal, side)


def excess_as_fitted(scoring: Scoring, trial: Trial, side: Bools) -> float:
    """``excess`` of the fit, nothing held out."""
    return excess(scoring, replace(trial, held_square=trial.fitted_square), side)


def excess(scoring: Scoring, trial: Trial, side: Bools) -> float:
    """``excess_in`` the blocks of one side that decide."""
    return excess_in(scoring, trial, side & scoring.decides)


def excess_in(scoring: Scoring, trial: Trial, rows: Bools) -> float:
    """Mean square above the allowed one in blocks of one side: of the angles in rad^2, of the ground against what each
    feature is allowed.
    """
    allowed = scoring.allowed_square[rows]
    over = np.maximum(trial.held_square[rows] - allowed, 0.0)
    if not rows.any():
        return 0.0
    return float(np.mean(over / allowed if scoring.joint[rows][0] < 0 else over))
