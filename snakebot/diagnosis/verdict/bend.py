"""Does what is left over bend with the angle, to the same side at both ends?

What sound servos and encoders are off by is odd in the angle: left and right are alike to a gain, a lag, to play and
to friction, and an offset is a constant. A code wheel or a magnet off its centre reads q + e sin(q + phase). Over part
of a turn that is an offset, a gain, and a curve that is even in q; a fit with offset and gain leaves the curve. So do
other laws that know an up and a down, such as an arm under gravity. Causes that are straight lines are likely wrong
then.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.polynomial.polynomial import polyfit, polyval

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.blocks import mean_difference
from snakebot.diagnosis.evidence.data import MIN_SAMPLES
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.trial import Trial, trial_at
from snakebot.diagnosis.result import Cause
from snakebot.diagnosis.sizes import BEYOND_CHANCE, NEXT_TO_NOTHING, UNLIKELY
from snakebot.diagnosis.verdict.joints import joints_of
from snakebot.in_words import numbered

# Rms of the curve over that of what an explanation changes, from which on it tells. Measured: 0 to 2 % in robots whose
# offset or gain is named rightly, 9 to 18 % in those with an eccentric code wheel (docs/diagnosis-method.md).
LEAST_BEND = NEXT_TO_NOTHING


def bends_beside(evidence: Evidence, nominal: Trial, best: Trial) -> dict[int, float]:
    """By their place, the terms of ``best`` that are straight lines of the angle beside a bend, and how large it is."""
    found = {}
    for at, (term, theta) in enumerate(
        zip(best.hypothesis.terms, best.hypothesis.split(best.theta), strict=True)
    ):
        if term.stage == "body":
            continue
        joints = joints_of(evidence.angles, term)
        bend = bend_of(evidence, nominal, best, joints)
        if bend is None:
            continue
        if is_straight(evidence, nominal, trial_at(evidence, Hypothesis((term,)), theta), joints):
            found[at] = bend
    return found


def bend_of(evidence: Evidence, nominal: Trial, best: Trial, joints: Sequence[int]) -> float | None:
    """Rms of the curve in what ``best`` leaves of some joints (1-based), over that of what it changes there; None where
    no curve is clear.

    It is fitted joint by joint to all motions but one, and tried on that one as far as the angles of the others go.
    """
    runs, blocks = evidence.data.runs, evidence.angles.blocks
    motions = evidence.data.motions
    if len(motions) < 2:
        return None
    gain, changed = np.zeros(blocks.count), np.zeros(blocks.count)
    for joint in (number - 1 for number in joints):
        for motion in motions:
            fitted = [i for i, run in enumerate(runs) if run.motion != motion]
            angle, left = (_used(evidence, values, fitted, joint) for values in (best.readings, best.left))
            if angle.size < MIN_SAMPLES or not np.ptp(angle) > 0:
                continue
            low, high = float(angle.min()), float(angle.max())
            size = max(abs(low), abs(high))
            line, curve = (polyfit(angle / size, left, degree) for degree in (1, 2))
            for i in (i for i, run in enumerate(runs) if run.motion == motion):
                q, rest = best.readings[i][:, joint], best.left[i][:, joint]
                inside = (low <= q) & (q <= high)
                of_line, of_curve = (np.square(rest - polyval(q / size, law)) for law in (line, curve))
                change = np.square(q - nominal.readings[i][:, joint])
                block = blocks.of_sample[i][:, joint]
                used = block >= 0
                for total, value in ((gain, np.where(inside, of_line - of_curve, 0.0)), (changed, change)):
                    total += np.bincount(block[used], weights=value[used], minlength=blocks.count)
    rows = np.isin(blocks.joint, [number - 1 for number in joints])
    if not rows.any() or changed[rows].sum() <= 0:
        return None
    cluster = blocks.run * evidence.data.joints + blocks.joint
    found = mean_difference((gain / blocks.samples)[rows], cluster[rows])
    share = float(np.sqrt(max(gain[rows].sum(), 0.0) / changed[rows].sum()))
    return share if found.z > BEYOND_CHANCE and share > LEAST_BEND else None


def is_straight(evidence: Evidence, nominal: Trial, alone: Trial, joints: Sequence[int]) -> bool:
    """Whether what one cause alone changes in the readings of its joints (1-based) is a straight line of the angle, but
    for next to nothing.
    """
    every = range(len(evidence.data.runs))
    left = whole = 0.0
    for joint in (number - 1 for number in joints):
        angle, before = (_used(evidence, t.readings, every, joint) for t in (alone, nominal))
        mark = angle - before
        if mark.size < MIN_SAMPLES:
            continue
        left += float(np.square(mark - polyval(angle, polyfit(angle, mark, 1))).sum())
        whole += float(np.square(mark).sum())
    return whole > 0 and left <= NEXT_TO_NOTHING * whole


def less_sure(cause: Cause, bend: float) -> Cause:
    """A straight cause, with no more probability than one beside such a bend may have."""
    return cause.model_copy(
        update={
            "probability": min(cause.probability, UNLIKELY),
            "evidence": {**cause.evidence, "bend": round(bend, 3)},
        }
    )


def bent(causes: Sequence[Cause]) -> str | None:
    """What a user should know of it, as a warning; None where nothing bends."""
    of = [cause for cause in causes if "bend" in cause.evidence]
    if not of:
        return None
    joints = sorted({joint for cause in of for joint in cause.joints})
    return (
        f"{numbered('joint', joints)}: what is left bends with the angle, to the same side at both ends "
        f"({max(cause.evidence['bend'] for cause in of):.0%} of what is closed), and "
        f"{' and '.join(dict.fromkeys(cause.effect for cause in of))} would be straight: look for a code wheel or a "
        "magnet off its centre, or a weight that is not described"
    )


def _used(evidence: Evidence, values: Sequence[Floats], runs: Sequence[int], joint: int) -> Floats:
    """What is compared of a joint, of some runs."""
    parts = [values[i][evidence.data.runs[i].use[:, joint], joint] for i in runs]
    return np.concatenate(parts) if parts else np.zeros(0)
