"""One round of the search: every candidate is fitted roughly, the best of them are held out, and ranked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import NamedTuple

import numpy as np

from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import Scoring
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.diagnosis.fit.fit_runs import MANY_PARAMETERS
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.least_squares import FEWEST_STEPS
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.fit.trial import Trial, informative_runs, run_trial, run_trial_against
from snakebot.diagnosis.options import ProgressCallback
from snakebot.diagnosis.search.acceptance import costs_nothing, excess_as_fitted, gains, lead
from snakebot.diagnosis.search.candidate import Candidate, added, start_values
from snakebot.diagnosis.search.candidates import candidates, kinds
from snakebot.diagnosis.search.chance import too_random
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.search.outlook import promising
from snakebot.diagnosis.sizes import HALF, LITTLE, MUCH
from snakebot.effects import registry
from snakebot.effects.effect import Effect

# Of what a first look promises most of, effects or motions, how many are looked at closer; chosen.
LOOKED_AT = 6
# Fits that are cross-validated at least, and at most where only the best of them is needed.
HELD_OUT = int(HALF * LOOKED_AT)
FOLLOWED_UP = 2  # fits, the first of some, that are gone after where the best may not be first; chosen
# Different effects in an explanation, but for everyday ones; chosen. With more terms, or one more, it takes long: not
# all are fitted again, nor all rivals and orders of them tried.
MOST_EFFECTS = 3


class Round(NamedTuple):
    """What was tried on top of an explanation: ``trials``, held out, best first; and all ``fits``, held out or not."""

    evidence: Evidence
    trials: Sequence[Trial] = ()
    fits: Sequence[Trial] = ()

    def held(self, evidence: Evidence) -> dict[Hypothesis, Trial]:
        """Its trials by what they say, if they were made with this evidence."""
        return {t.hypothesis: t for t in self.trials} if evidence is self.evidence else {}


def explore(evidence: Evidence, library: Library, base: Trial, progress: ProgressCallback) -> Round:
    """Each effect on top of ``base``."""
    scoring, first = evidence.scoring, evidence.beside(base.specs)
    wanted = called_for(evidence, base, library.effects)
    if not wanted:
        return Round(evidence)

    def tell(count: int) -> None:
        progress(f"trying {wanted[count - 1].name}", 0.6 * count / len(wanted))

    made = in_parallel(partial(candidates, first, library, base), wanted, tell)
    looks = first_looks(first, list(chain.from_iterable(made)), base)
    fits = [fit for fit in looks if not too_random(evidence, fit)]
    closer = _second_looks(evidence, library, base, fits)
    taken_for = {look.hypothesis: fit.hypothesis for look, fit in closer}
    fits = [*(look for look, _ in closer), *(t for t in fits if t.hypothesis not in taken_for)]
    if not fits:
        return Round(evidence)
    # On top of many effects with which the body is simulated, each takes long.
    fewest = 1 if _says_much(base) and evidence.predictor.simulator.needs_body(base.specs) else HELD_OUT
    most = HELD_OUT if base.hypothesis.terms else LOOKED_AT
    chosen = [fit for side in _by_side(fits) for fit in _promise_most(scoring, side, base, fewest, most)]
    chosen += _leave_least(scoring, fits, chosen, base)
    progress("holding out gaits", 0.8)
    trials = ranked(scoring, held_out(evidence, chosen, base))
    if trials:
        trials = ranked(scoring, [*trials, *_widened(evidence, chosen, trials[0])])
    held = {t.hypothesis: t for t in trials}
    both_held = ((look, fit) for look, fit in taken_for.items() if look in held and fit in held)
    says_no_more = {look for look, fit in both_held if not gains(lead(scoring, held[look], held[fit]))}
    trials = [t for t in trials if t.hypothesis not in says_no_more]
    progress("", 1.0)
    return Round(evidence, trials, fits)


def _by_side(fits: Sequence[Trial]) -> tuple[list[Trial], list[Trial]]:
    """Those that add what shows in the angles, and those that add what shows over ground: of that a session may have a
    few numbers in all, which weigh nothing beside its angles.
    """
    over_ground = [fit for fit in fits if fit.hypothesis.terms[-1].stage == "body"]
    return [fit for fit in fits if fit not in over_ground], over_ground


def first_of_each(trials: Iterable[Trial]) -> list[Trial]:
    """The first of some trials of each explanation."""
    found: dict[Hypothesis, Trial] = {}
    for trial in trials:
        found.setdefault(trial.hypothesis, trial)
    return list(found.values())


def _promise_most(
    scoring: Scoring, fits: Sequence[Trial], base: Trial, fewest: int, most: int
) -> list[Trial]:
    """The fits that gain most, and those that gain nearly as much; of one explanation the best fit."""
    gained = {fit: scoring.gain(fit.fitted_square, base.fitted_square).mean for fit in fits}
    ascending = np.argsort([gained[fit] for fit in fits], kind="stable")
    order = first_of_each(fits[i] for i in ascending[::-1])
    near = [fit for fit in order if gained[fit] >= (1 - MUCH) * gained[order[0]]]
    kept = list(dict.fromkeys([*order[:fewest], *near]))[:most]
    return [fit for fit in kept if gained[fit] > 0]


def _leave_least(
    scoring: Scoring, fits: Sequence[Trial], chosen: Sequence[Trial], base: Trial
) -> list[Trial]:
    """Which of some fits take most of the gap away, where none ``chosen`` does nearly as well: the score, a sum of
    logarithms, would rather have a little of every joint's gap than most of one joint's that is far larger. None that
    gains no score at all, unless it leaves less than half of what ``base`` leaves.
    """
    left = {fit: excess_as_fitted(scoring, fit, scoring.of_angles) for fit in (base, *fits)}
    useful = (
        fit
        for fit in sorted(fits, key=left.__getitem__)
        if left[fit] < HALF * left[base] or scoring.gain(fit.fitted_square, base.fitted_square).mean > 0
    )
    first = first_of_each(useful)[:FOLLOWED_UP]
    enough = (1 + MUCH) * left[first[0]] if first else 0.0
    if any(left[fit] <= enough for fit in chosen):
        return []
    return [fit for fit in first if left[fit] <= enough]


def _widened(evidence: Evidence, fits: Sequence[Trial], first: Trial) -> list[Trial]:
    """What a rough fit took for the winner in more words, held out after all: a better fit may tell them apart."""
    winner = next(t for t in fits if t.hypothesis == first.hypothesis)
    wider = [t for t in fits if _says_no_more(evidence.angles, evidence.predictor.simulator, t, winner)]
    return _cross_validated(evidence, wider)


def called_for(evidence: Evidence, base: Trial, effects: Sequence[Effect]) -> list[Effect]:
    """Effects for whose side, angles or ground, ``base`` leaves a gap."""
    gap = gap_of(evidence.scoring, base.held_square)
    return [e for e in effects if (gap.ground_significant if e.stage == "body" else gap.significant.any())]


def _says_much(base: Trial) -> bool:
    """Whether an explanation has so many terms or parameters that to fit them all again takes long."""
    return len(base.hypothesis.terms) >= MOST_EFFECTS or base.theta.size >= MANY_PARAMETERS


def first_looks(evidence: Evidence, made: Sequence[Candidate], base: Trial | None = None) -> list[Trial]:
    """A rough fit of each candidate, nothing held out; on top of a ``base``, of those that promise something, and what
    a base of many terms or parameters says is left as it is, or one that needs the whole body.
    """
    many = base is not None and (_says_much(base) or evidence.predictor.simulator.has_frozen)
    last = True if many else None
    look = partial(run_trial, evidence, cross=False, rough=True, last=last)
    promised = made if base is None else promising(evidence, base, made)
    return in_parallel(lambda c: look(c.hypothesis, c.starts), promised)


def _second_looks(
    evidence: Evidence, library: Library, base: Trial, fits: Sequence[Trial]
) -> list[tuple[Trial, Trial]]:
    """Closer looks at what the likeliest fits may be taken for, each with that fit, where these say that a joint goes
    where the rest of the body takes it: a joint that is slow under load was looked at under the torques of the measured
    motion, and those are not the ones that it would have borne.
    """
    if not fits:
        return []
    scoring, simulator = evidence.scoring, evidence.predictor.simulator
    first = max(fits, key=lambda t: t.fitted_score(scoring))
    nearest = min(fits, key=lambda t: excess_as_fitted(scoring, t, scoring.of_angles))
    wanted: dict[Hypothesis, tuple[Candidate, Trial]] = {}
    for fit in (first, nearest):
        term, values = fit.hypothesis.terms[-1], fit.hypothesis.split(fit.theta)[-1]
        if not simulator.rough_needs_body(term.specs(values.tolist())):
            continue
        at = tuple(j - 1 for j in term.joints or range(1, evidence.data.joints + 1))
        for effect in library.effects:
            if not effect.per_joint or term.effect not in dict(effect.confused_with):
                continue
            other = replace(term, effect=effect.name, fixed=kinds(library, effect)[0])
            starts = [start_values(other, start) for start in effect.starts(library.observed, at)]
            specs = other.specs(starts[0].tolist())
            if simulator.always_needs_body(specs) and not simulator.rough_needs_body(specs):
                candidate = added(base, other, starts)
                wanted[candidate.hypothesis] = candidate, fit
    look = partial(
        run_trial,
        evidence,
        cross=False,
        last=bool(base.hypothesis.terms),
        most_steps=FEWEST_STEPS,
        fitted_runs=informative_runs(evidence),
    )
    return in_parallel(
        lambda pair: (look(pair[0].hypothesis, pair[0].starts), pair[1]), list(wanted.values())
    )


def held_out(
    evidence: Evidence, fits: Sequence[Trial], base: Trial | None = None, ahead: Trial | None = None
) -> list[Trial]:
    """The same explanations, cross-validated from where these fits ended; but not one that must simulate the whole body
    to say what a simpler one says, of these or ``base``. ``ahead``: see ``run_trial_against``.
    """
    simpler = fits if base is None else [base, *fits]
    angles, simulator = evidence.angles, evidence.predictor.simulator
    further = [t for t in fits if not any(_says_no_more(angles, simulator, t, other) for other in simpler)]
    return _cross_validated(evidence, further, ahead)


def _cross_validated(evidence: Evidence, fits: Sequence[Trial], ahead: Trial | None = None) -> list[Trial]:
    """The same explanations, from where these fits ended."""
    run = run_trial if ahead is None else partial(run_trial_against, ahead=ahead)
    return in_parallel(lambda t: run(evidence, hypothesis=t.hypothesis, starts=[t.theta]), fits)


def _says_no_more(angles: AngleEvidence, simulator: Simulator, fit: Trial, other: Trial) -> bool:
    """Whether a fit that must simulate the whole body predicts what one of fewer parameters predicts as well."""
    if fit.theta.size <= other.theta.size or not simulator.needs_body(fit.specs):
        return False
    apart = [mine - its for mine, its in zip(fit.readings, other.readings, strict=True)]
    square = angles.blocks.mean_square([np.nan_to_num(part) for part in apart])
    share = square / angles.allowed_square
    joint = angles.blocks.joint
    return all(float(share[joint == j].mean()) < LITTLE for j in np.unique(joint))


def ranked(scoring: Scoring, trials: Sequence[Trial]) -> list[Trial]:
    """Best first by held-out score; but one that says less, at a loss within a standard error, goes first.

    Of exact ties the effect that comes first in the signal is first.
    """
    place = {name: i for i, name in enumerate(registry.effects())}
    ordered = sorted(
        trials,
        key=lambda t: (-round(t.score(scoring), 4), len(t.theta), [place[n] for n in t.hypothesis.names]),
    )
    if len(ordered) < 2:
        return ordered
    first = ordered[0]
    for other in ordered[1:]:
        lost = scoring.gain(first.held_square, other.held_square)
        if _said(other) < _said(first) and costs_nothing(lost):
            first = other
    ordered.remove(first)
    return [first, *ordered]


def _said(trial: Trial) -> tuple[int, int]:
    """How much an explanation says: parameters, then joints that must be named."""
    return len(trial.theta), _named(trial.hypothesis)


def _named(hypothesis: Hypothesis) -> int:
    """How much must be said about joints: nothing where all are alike."""
    return sum(0 if t.joints is None else 1 for t in hypothesis.terms)
