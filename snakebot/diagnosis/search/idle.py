"""Joints on which an effect came to nothing: what one needed beside one explanation it may not need beside the last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.diagnosis.search.acceptance import costs_nothing
from snakebot.diagnosis.sizes import NO_PERCENT
from snakebot.effects.parameter import Parameter


def without_idle(evidence: Evidence, best: Trial) -> Trial:
    """``best`` without the joints on which an effect that they have their own of does nothing; ``best`` itself where
    there are none, or motions left out of the fit speak for them.
    """
    terms: list[Term] = []
    theta = [np.zeros(0)]
    for term, values in zip(best.hypothesis.terms, best.hypothesis.split(best.theta), strict=True):
        if not term.own or not term.open:
            terms.append(term)
            theta.append(values)
            continue
        rows = values.reshape(len(term.alike), -1)
        acts = _acts(term.open_of_one, rows)
        if acts.any():
            assert term.joints is not None
            joints = tuple(np.array(term.joints)[acts].tolist())
            terms.append(replace(term, joints=joints, own=len(joints) > 1))
            theta.append(rows[acts].ravel())
    hypothesis = Hypothesis(tuple(terms))
    if hypothesis == best.hypothesis or not terms:
        return best
    less = run_trial(evidence, hypothesis, [np.concatenate(theta)])
    return less if costs_nothing(evidence.scoring.gain(best.held_square, less.held_square)) else best


def _acts(parameters: Sequence[Parameter], rows: Floats) -> Bools:
    """(joints,) whether any of the parameters ``rows`` (joints, p) is more than 0 % of its usual size off neutral."""
    neutral = np.array([p.neutral for p in parameters])
    usual = np.array([abs(p.typical - p.neutral) or p.spread for p in parameters])
    return np.asarray((np.abs(rows - neutral) > NO_PERCENT * usual).any(axis=1))
