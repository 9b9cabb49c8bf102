"""The same explanation said more plainly: of all joints where that does as well, and by plainer effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.trial import Trial, run_trial_against
from snakebot.diagnosis.search.acceptance import as_good, closes_nearly_as_much
from snakebot.diagnosis.search.candidate import start_values
from snakebot.diagnosis.search.candidates import kinds
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.search.rounds import MOST_EFFECTS
from snakebot.effects.effect import Start, Usual
from snakebot.effects.spec import EffectSpec


def said_plainly(evidence: Evidence, library: Library, nominal: Trial, best: Trial) -> Trial:
    """The same said more plainly: of all joints where that does as well, and by the plainer effect that it comes to."""
    best = _shared(evidence, best)
    for term in best.hypothesis.terms:
        if term.joints is None or len(term.joints) < 2 or not term.open or term.own:
            continue
        parts = zip(best.hypothesis.terms, best.hypothesis.split(best.theta), strict=True)
        kept = [(t, values) for t, values in parts if t == term or t.effect != term.effect]
        wide = Hypothesis(tuple(replace(t, joints=None) if t == term else t for t, _ in kept))
        wider = run_trial_against(evidence, best, wide, [np.concatenate([values for _, values in kept])])
        if as_good(evidence.scoring, wider, best):
            best = wider
    return by_plainer_effects(evidence, library, nominal, best)


def by_plainer_effects(evidence: Evidence, library: Library, nominal: Trial, best: Trial) -> Trial:
    """With the plainer effect in the place of one that comes to it, where that closes nearly as much of the gap: of a
    servo that holds next to nothing, one that is dead predicts a little worse, as it has no number to be fitted.
    """
    usable = {effect.name: effect for effect in library.effects}
    for term in best.hypothesis.terms:
        index = best.hypothesis.terms.index(term)
        found = comes_to(term.told(best.hypothesis.split(best.theta)[index].tolist()), evidence.usual)
        if found is None or found[0] not in usable or found[0] in best.hypothesis.names:
            continue
        name, start = found
        other = replace(term, effect=name, fixed=kinds(library, usable[name])[0])
        theta = np.concatenate([best.hypothesis.rest(best.theta, index), start_values(other, start)])
        plainer = run_trial_against(evidence, best, best.hypothesis.without(index).plus(other), [theta])
        if closes_nearly_as_much(evidence.scoring, plainer, best, nominal):
            best = plainer
    return best


def comes_to(spec: EffectSpec, usual: Usual) -> tuple[str, Start] | None:
    """The plainer effect that one with these values is just another word for, and where to start its fit; None if there
    is none, or each joint has values of its own.
    """
    values = {name: value for name, value in spec.values.items() if not isinstance(value, tuple)}
    return spec.effect.plainer(values, usual) if len(values) == len(spec.values) else None


def _shared(evidence: Evidence, best: Trial) -> Trial:
    """With one value for all joints of an effect, where values of their own gain nothing.

    Joints that differ in many effects are not alike in one of them: there nothing would be said more plainly.
    """
    if len(best.hypothesis.terms) > MOST_EFFECTS:
        return best
    for term in best.hypothesis.terms:
        if not term.own:
            continue
        parts = list(zip(best.hypothesis.terms, best.hypothesis.split(best.theta), strict=True))
        alike = [
            (replace(t, own=False), np.median(v.reshape(len(t.alike), -1), axis=0)) if t == term else (t, v)
            for t, v in parts
        ]
        plain = run_trial_against(
            evidence, best, Hypothesis(tuple(t for t, _ in alike)), [np.concatenate([v for _, v in alike])]
        )
        if as_good(evidence.scoring, plain, best):
            best = plain
    return best
