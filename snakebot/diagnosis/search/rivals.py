"""Rivals of what the search found: another effect in the place of one of its terms, fitted and held out alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Joints, Term
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.fit.trial import Trial, run_trial, run_trial_against
from snakebot.diagnosis.options import ProgressCallback
from snakebot.diagnosis.search.candidate import Candidate, start_values
from snakebot.diagnosis.search.candidates import candidates, kinds
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.search.rounds import (
    HELD_OUT,
    LOOKED_AT,
    MOST_EFFECTS,
    Round,
    called_for,
    first_looks,
    first_of_each,
    held_out,
    ranked,
)
from snakebot.diagnosis.sizes import HALF
from snakebot.effects.effect import Effect
from snakebot.effects.registry import find_effect, look_alikes


def rivals(
    evidence: Evidence,
    library: Library,
    best: Trial,
    singles: Sequence[Trial],
    rounds: Mapping[Hypothesis, Round],
    fits: Sequence[Trial],
    without: Sequence[Trial],
    progress: ProgressCallback,
) -> tuple[tuple[Trial, ...], ...]:
    """Per term of ``best``, trials in which another effect takes its place, best first; of many terms no more are tried
    for each than are held out.

    Args:
        singles: trials of single effects; the rivals of an effect that is the only one.
        rounds: what was tried on top of some explanations; where the rest of ``best`` is one of them, that will do.
        fits: every single effect: those that came nearest are fitted otherwise.
        without: ``best`` without each of its terms; empty: as yet unknown.
    """
    likely = _added(sorted(fits, key=lambda t: -t.fitted_score(evidence.scoring)))[
        : LOOKED_AT if len(best.hypothesis.terms) <= MOST_EFFECTS else HELD_OUT
    ]
    nearest: dict[str, list[Effect]] = {}  # by effect, what else to try where it is on another joint
    out = []
    for index, term in enumerate(best.hypothesis.terms):
        progress(f"rivals of {term.effect}", 0.8 + 0.2 * index / len(best.hypothesis.terms))
        base = without[index] if without else None
        others = nearest.get(term.effect, likely)
        out.append(_of_term(evidence, library, best, index, singles, rounds, others, base))
        nearest.setdefault(term.effect, _added(out[-1]) or likely)
    return tuple(out)


def _of_term(
    evidence: Evidence,
    library: Library,
    best: Trial,
    index: int,
    singles: Sequence[Trial],
    rounds: Mapping[Hypothesis, Round],
    likely: Sequence[Effect],
    base: Trial | None,
) -> tuple[Trial, ...]:
    """Trials with another effect in the place of term ``index``, best first; ``likely`` ones, where none were tried.

    ``base``: what is left without the term, if it is known.
    """
    term = best.hypothesis.terms[index]
    if len(best.hypothesis.terms) == 1:
        return tuple(
            t
            for t in singles
            if t.hypothesis.names != best.hypothesis.names
            and (t.hypothesis.terms[0].stage == "body") == (term.stage == "body")
        )
    rest = best.hypothesis.without(index)
    if term.own:
        others = _in_place(evidence, library, best, index, base)
        trials = in_parallel(
            lambda c: run_trial_against(evidence, best, c.hypothesis, c.starts, last=True), others
        )
        return tuple(ranked(evidence.scoring, trials))

    def rival(name: str, stage: str) -> bool:
        return name not in best.hypothesis.names and (stage == "body") == (term.stage == "body")

    round_ = rounds.get(rest)
    fits = [
        fit
        for fit in (round_.fits if round_ else ())
        if rival(fit.hypothesis.terms[-1].effect, fit.hypothesis.terms[-1].stage)
    ]
    if round_ is None:
        if base is None:
            base = run_trial(evidence, rest, [best.hypothesis.rest(best.theta, index)], cross=False)
        near = evidence.beside(base.specs)
        wanted = [e for e in called_for(evidence, base, likely) if rival(e.name, e.stage)]
        made = in_parallel(partial(candidates, near, library, base), wanted)
        fits += first_looks(near, list(chain.from_iterable(made)), base)
    # a fit on top of the rest as it was without the term may not find back to where look-alikes are alike
    fits += first_looks(evidence, _in_place(evidence, library, best, index))
    fits.sort(key=lambda t: -t.fitted_score(evidence.scoring))
    known = round_.held(evidence) if round_ else {}
    first = first_of_each(fits)[:HELD_OUT]
    held = [known[fit.hypothesis] for fit in first if fit.hypothesis in known]
    held += held_out(evidence, [fit for fit in first if fit.hypothesis not in known], ahead=best)
    return tuple(ranked(evidence.scoring, held))


def _in_place(
    evidence: Evidence, library: Library, best: Trial, index: int, base: Trial | None = None
) -> list[Candidate]:
    """What is said to be taken for an effect, in its place: on the same joints, and on the one that it does most for,
    the rest as it is beside the effect. If the rest has such an effect already, that one is said of these joints, too;
    but not where most of them have it: they would do without anything in its place.

    ``base``: what is left without the effect, if it is known.
    """
    term = best.hypothesis.terms[index]
    confused = look_alikes(term.effect)
    every = tuple(range(1, evidence.data.joints + 1))
    places = [term.joints or every]
    if term.own and base is not None:
        places += [(joint,) for joint in places[0] if _does_most_for(joint, evidence, best, base)]
    out = []
    for effect in library.effects:
        if effect.name not in confused or not effect.per_joint or effect.is_read_off:
            continue
        for at in places:
            found = _on_joints(library, best, index, effect, at, every)
            if found is None:
                continue
            last = found.hypothesis.split(found.starts[0])[-1].tolist()
            if not evidence.predictor.simulator.needs_body(found.hypothesis.terms[-1].specs(last)):
                out.append(found)
    return out


def _does_most_for(joint: int, evidence: Evidence, best: Trial, base: Trial) -> bool:
    """Whether ``best`` does more beyond ``base`` for this joint (1-based) than for all others together."""
    more = np.maximum(base.held_square - best.held_square, 0.0)
    of_angles = evidence.scoring.of_angles
    mine = of_angles & (evidence.scoring.joint == joint - 1)
    return bool(more[mine].sum() > HALF * more[of_angles].sum())


def _on_joints(
    library: Library, best: Trial, index: int, effect: Effect, at: Joints, every: Joints
) -> Candidate | None:
    """``effect`` on the joints ``at`` in the place of term ``index``, which stays on its others; None where the rest
    has the effect on most of them. ``every``: all joints.
    """
    term, rest = best.hypothesis.terms[index], best.hypothesis.without(index)
    kept = best.hypothesis.rest(best.theta, index)
    stays = tuple(joint for joint in term.joints or every if joint not in at)
    if stays:
        rows = _by_joint(term, best.hypothesis.split(best.theta)[index], every)
        rest = rest.plus(replace(term, joints=stays, own=len(stays) > 1))
        kept = np.concatenate([kept, *(rows[joint] for joint in stays)])
    places = [k for k, other in enumerate(rest.terms) if other.effect == effect.name]
    if not places:
        other = replace(term, effect=effect.name, fixed=kinds(library, effect)[0])
        if stays:
            other = replace(other, joints=at, own=len(at) > 1)
        start = [_start(library, effect, other, joints or every) for joints in other.alike]
        return Candidate(rest.plus(other), [np.concatenate([kept, *start])])
    place = places[0]
    there = rest.terms[place]
    rows = _by_joint(there, rest.split(kept)[place], every)
    if len(places) > 1 or len(set(at) - set(rows)) < HALF * len(at):
        return None
    for joint in at:
        if joint not in rows:
            rows[joint] = _start(library, effect, replace(there, joints=(joint,), own=False), (joint,))
    joints = tuple(sorted(rows))
    wider = replace(there, joints=joints, own=len(joints) > 1)
    theta = [rest.rest(kept, place), *(rows[joint] for joint in joints)]
    return Candidate(rest.without(place).plus(wider), [np.concatenate(theta)])


def _by_joint(term: Term, values: Floats, every: Joints) -> dict[int, Floats]:
    """What a term's parameters are on each of its joints; ``every``: all joints."""
    rows = values.reshape(len(term.alike), -1)
    return {joint: row for joints, row in zip(term.alike, rows, strict=True) for joint in joints or every}


def _start(library: Library, effect: Effect, term: Term, joints: Joints) -> Floats:
    """(p,) where the effect's first start is, on some joints alone."""
    return start_values(term, effect.starts(library.observed, tuple(joint - 1 for joint in joints))[0])


def _added(trials: Iterable[Trial]) -> list[Effect]:
    """What was added last in each of some trials."""
    return [find_effect(n) for n in dict.fromkeys(t.hypothesis.terms[-1].effect for t in trials)]
