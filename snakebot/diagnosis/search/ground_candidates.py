"""Ways to add an effect of the body to an explanation: all of them show over ground."""

from __future__ import annotations

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.ground_evidence import GroundEvidence
from snakebot.diagnosis.evidence.predictor import Predictor
from snakebot.diagnosis.fit.hypothesis import Term, fixed_by
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.search.candidate import Candidate, added, start_values
from snakebot.diagnosis.search.library import Library
from snakebot.effects.effect import Effect
from snakebot.errors import BadInputError


def ground_candidates(evidence: Evidence, library: Library, base: Trial, effect: Effect) -> list[Candidate]:
    """See ``candidates``."""
    if any(term.effect == effect.name for term in base.hypothesis.terms):
        return []
    known = fixed_by(library.known, effect.name)
    options: dict[Term, list[Floats]] = {}
    for start in effect.starts(library.observed, tuple(range(evidence.data.joints))):
        for held in effect.variants(start):
            picked = tuple((name, value) for name, value in held.items() if name not in dict(known))
            term = Term(effect.name, None, (*known, *picked))
            options.setdefault(term, []).append(start_values(term, start))
    found = [added(base, term, begin) for term, begin in options.items() if _fits(evidence.data, term)]
    assert evidence.ground is not None
    return _promising(evidence.ground, evidence.predictor, base, found) if len(found) > 3 else found


def _fits(data: Data, term: Term) -> bool:
    try:
        term.specs([p.typical for p in term.open])[0].checked(data.robot)
    except BadInputError:
        return False
    return True


def _promising(
    ground: GroundEvidence, predictor: Predictor, base: Trial, found: list[Candidate], keep: int = 2
) -> list[Candidate]:
    """The ``keep`` best of many alternatives (which link), by what a straight line from the start promises."""
    reference = predictor.ground_features(base.specs)
    residual = ground.features.value - reference
    weight = 1 / (ground.allowed_square + np.square(residual))
    rank = []
    for candidate in found:
        if len(candidate.hypothesis.terms[-1].open) != 1:
            rank.append(-np.inf)  # several parameters: no straight line, keep it
            continue
        moved = predictor.ground_features(candidate.hypothesis.specs(candidate.starts[0])) - reference
        usable = np.isfinite(moved) & np.isfinite(residual)
        slope = float(
            (moved * weight * residual)[usable].sum() / max((moved**2 * weight)[usable].sum(), 1e-300)
        )
        left = residual - slope * moved
        rank.append(float(np.log1p(np.square(left) / ground.allowed_square)[usable].mean()))
    order = np.argsort(rank, kind="stable")
    wide = sum(np.isneginf(rank))
    return [found[i] for i in order[: keep + wide]]
