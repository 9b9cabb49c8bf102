"""The wire is one: what delays the commands of joints by times of their own is told as one delay of all joints, where
that foretells as well.

A delay and a lag leave nearly the same mark. Where each joint has both, one makes up for the other, joint by joint; but
one wire takes the commands to all joints, so that only the lags are the joints' own.
"""

from __future__ import annotations

import numpy as np

from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.trial import Trial, run_trial_against, trial_at
from snakebot.diagnosis.search.acceptance import as_good
from snakebot.diagnosis.search.everyday import everyday_terms, is_one_of
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.search.regain import regained
from snakebot.diagnosis.search.wear import worn


def of_one_wire(evidence: Evidence, library: Library, best: Trial) -> Trial:
    """``best`` with one value for all joints of an everyday effect before the servos, and of the others what joints
    need beside that; ``best`` itself where that foretells worse, or where no joint has such an effect of its own.
    """
    everyday = everyday_terms(library)
    parts = list(zip(best.hypothesis.terms, best.hypothesis.split(best.theta), strict=True))
    of_joints = [t for t, _ in parts if t.stage == "link" and t.joints is not None and is_one_of(everyday, t)]
    others = [(term, values) for term, values in parts if not is_one_of(everyday, term)]
    fault = Hypothesis(tuple(term for term, _ in others))
    theta = np.concatenate([np.zeros(0), *(values for _, values in others)])
    whole = worn(evidence, library, trial_at(evidence, fault, theta)) if of_joints else None
    for term in whole.bench.terms if whole is not None else ():
        if whole is None or not any(is_one_of((term,), mine) for mine in of_joints):
            continue
        common, value = whole.on_one_wire(library, term)
        candidate = common.reduced().added_to(fault.plus(term), np.concatenate([theta, value]))
        if candidate is None:
            continue
        trial = run_trial_against(evidence, best, candidate.hypothesis, candidate.starts)
        trial = regained(evidence, library, trial)
        if as_good(evidence.scoring, trial, best):
            return trial
    return best
