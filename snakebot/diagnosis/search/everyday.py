"""Everyday effects: those that every real joint has a little of, as terms of an explanation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.search.candidates import kinds
from snakebot.diagnosis.search.library import Library
from snakebot.effects.registry import find_effect


def is_worn(library: Library, hypothesis: Hypothesis) -> bool:
    """Whether an explanation says nothing but everyday effects, or nothing at all."""
    return not all_but(everyday_terms(library), hypothesis)


def everyday_terms(library: Library) -> tuple[Term, ...]:
    """The effects that every real joint has a little of, of the kind that these joints show, of none in particular."""
    return tuple(
        Term(effect.name, None, library.everyday_kinds.get(effect.name, found[0]))
        for effect in library.effects
        if effect.everyday and (found := kinds(library, effect))
    )


def other_kinds(evidence: Evidence, library: Library, term: Term) -> list[Term]:
    """The same everyday effect with its switches set otherwise, as far as the torques of the measured motion say what
    it does: those that servos feel are known of a body and of an arm alone.
    """
    simulator = evidence.predictor.simulator

    def is_known(other: Term) -> bool:
        specs = other.specs([p.typical for p in other.open])
        if simulator.rough_needs_body(specs):
            return False
        return simulator.measured_load(0) is not None or not simulator.stages(specs).feels_load

    others = [replace(term, fixed=fixed) for fixed in kinds(library, find_effect(term.effect))]
    return [other for other in others if other != term and is_known(other)]


def all_but(everyday: Sequence[Term], hypothesis: Hypothesis) -> tuple[Term, ...]:
    """The terms of an explanation that are none of the everyday effects."""
    return tuple(term for term in hypothesis.terms if not is_one_of(everyday, term))


def takes_a_place(everyday: Sequence[Term], hypothesis: Hypothesis) -> bool:
    """Whether an explanation has an everyday effect, of another kind than every joint has a little of."""
    names = {term.effect for term in everyday}
    return any(term.effect in names for term in all_but(everyday, hypothesis))


def is_one_of(everyday: Sequence[Term], term: Term) -> bool:
    """Whether an explanation's term is an everyday effect, of whatever joints; of the kind that these joints show."""
    return any(term.effect == other.effect and term.fixed == other.fixed for other in everyday)
