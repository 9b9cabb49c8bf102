"""The search: try every effect, keep what gains on held-out gaits, add another where it still gains, prune.

Greedy choice by training error over-fits; so an effect is added only when its held-out gain is more than two standard
errors and large enough to matter, and is taken out again when the explanation does as well without it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType

import numpy as np

from snakebot.diagnosis.evidence.gap import gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import Scoring
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.fit.trial import Trial, run_trial, run_trial_against
from snakebot.diagnosis.options import ProgressCallback
from snakebot.diagnosis.search.acceptance import (
    MOST_LEFT,
    accepted,
    closed_enough,
    closes_half,
    excess,
    excess_as_fitted,
    gains,
    lead,
    leaves_next_to_nothing,
    may_be_named,
)
from snakebot.diagnosis.search.candidate import Candidate
from snakebot.diagnosis.search.candidates import elsewhere
from snakebot.diagnosis.search.everyday import is_worn
from snakebot.diagnosis.search.idle import without_idle
from snakebot.diagnosis.search.library import Library
from snakebot.diagnosis.search.pairs import pairs
from snakebot.diagnosis.search.plainly import by_plainer_effects, said_plainly
from snakebot.diagnosis.search.regain import regained
from snakebot.diagnosis.search.rivals import rivals
from snakebot.diagnosis.search.rounds import (
    FOLLOWED_UP,
    LOOKED_AT,
    MOST_EFFECTS,
    Round,
    explore,
    first_looks,
    held_out,
    ranked,
)
from snakebot.diagnosis.search.wear import with_wear
from snakebot.diagnosis.sizes import HALF


@dataclass(frozen=True, eq=False)
class SearchResult:
    """What the search came to.

    Attributes:
        evidence: that it was found on: fits allow for the misfit that all everyday effects together leave;
            without folds where ``best`` is ``untested``.
        nominal: the robot without any effect.
        best: the explanation that was accepted; ``nominal`` if none was.
        singles: trials of single effects, best first: the ranking.
        rivals: per term of ``best``, trials in which another effect takes its place, best first.
        path: (hypothesis) trials in the order in which effects were added.
        without: ``best`` with each of its terms taken out, as far as that was tried.
        fits: every single effect as fitted to all free runs, held out or not.
        untested: ``best`` shows in too few motions for any to be left out of its fit: it and ``singles`` are as fitted.
        seen_in_scatter: the cause shows in the scatter, whether or not the mean is off.
    """

    evidence: Evidence
    nominal: Trial
    best: Trial
    singles: tuple[Trial, ...]
    rivals: tuple[tuple[Trial, ...], ...]
    path: tuple[Trial, ...]
    without: tuple[Trial, ...] = ()
    fits: tuple[Trial, ...] = ()
    untested: bool = False
    seen_in_scatter: bool = False

    def known(self, hypothesis: Hypothesis) -> Trial | None:
        """An explanation as it was tried on runs left out; None if it was not."""
        parts = (trial for trial in self.without if trial.is_held_out)
        return next((t for t in (*self.path, *self.singles, *parts) if t.hypothesis == hypothesis), None)


def search(
    evidence: Evidence,
    library: Library,
    nominal: Trial,
    *,
    quick: bool = False,
    progress: ProgressCallback = lambda text, share: None,
) -> SearchResult:
    """Find the explanation of the gap that ``nominal`` leaves; ``quick``: of two effects at most."""
    first = explore(evidence, library, nominal, lambda text, share: progress(text, 0.4 * share))
    singles, fits = first.trials, first.fits
    rounds, every_effect = {nominal.hypothesis: first}, library
    path, best, round_ = [nominal], nominal, singles
    limit, most_terms = 2 if quick else MOST_EFFECTS, 2 * MOST_EFFECTS  # each on two joints
    worn: Trial | None = None
    wear_is_open = True

    def has_room(trial: Trial) -> bool:
        return len(trial.hypothesis.names) < limit and len(trial.hypothesis.terms) < most_terms

    def further(trial: Trial) -> Sequence[Trial]:
        if trial.hypothesis not in rounds:
            little = closed_enough(evidence.scoring, trial, nominal, worn=worn is not None)
            part = _part(progress, str(trial.hypothesis), len(trial.hypothesis.terms))
            rounds[trial.hypothesis] = Round(evidence) if little else explore(evidence, library, trial, part)
        return rounds[trial.hypothesis].trials

    while True:
        winner = _winner(evidence.scoring, round_, best, nominal) if has_room(best) else None
        if wear_is_open and _may_be_worn(evidence, winner, best, nominal):
            wear_is_open = False
            so_far, two = winner or best, []
            if winner is not None and has_room(winner) and not is_worn(library, winner.hypothesis):
                # a fault on most joints may have another beside it, which everyday effects of every joint would hide
                two = _accepted(evidence.scoring, further(winner), winner, nominal)
                so_far = next(iter(two), winner)
            progress("two effects together", 0.4)
            together = _winner(evidence.scoring, pairs(evidence, nominal, fits, so_far), so_far, nominal)
            so_far = together or so_far
            progress("everyday effects on every joint", 0.4)
            evidence, every_effect, worn = with_wear(evidence, library, nominal, so_far, [*fits, *two])
            if worn is not None:
                # all of these were fitted to every joint with a gap
                library = every_effect.without_everyday()
                limit, most_terms = (
                    limit + len(worn.hypothesis.names),
                    most_terms + len(worn.hypothesis.terms),
                )
            if worn is not None or together is not None:
                best = worn or so_far
                path.append(best)
                round_ = further(best)
            continue
        if winner is None:
            break
        best = winner
        path.append(best)
        if len(best.hypothesis.terms) >= 2:
            if worn is None:
                best = _swap(evidence, best, singles)
            best = _elsewhere(evidence, library, best)
        best = by_plainer_effects(evidence, every_effect, nominal, best)
        path[-1] = best
        progress(f"so far: {best.hypothesis.in_words}", 0.4)
        round_ = further(best) if has_room(best) else []
    best, without = in_fewest_words(evidence, every_effect, nominal, without_idle(evidence, best))
    if worn is not None:
        progress("everyday effects on top of the rest", 0.8)
        more = without_idle(evidence, regained(evidence, every_effect, best))
        if more is not best:
            best, without = more, without_each(evidence, more)
    untested = False
    if not closes_half(evidence.scoring, best, nominal):
        found = only_fitted(evidence.scoring, nominal, singles)
        untested = bool(found.hypothesis.terms)
        if untested:
            # nothing is held out now: what else was tried is compared by its fit as well
            evidence, without = replace(evidence, split=replace(evidence.split, folds=())), ()
            singles = in_parallel(partial(as_fitted, evidence), singles)
            best = next(t for t in singles if t.hypothesis == found.hypothesis)
            path = [nominal, best]

    def rivals_of(best: Trial, without: Sequence[Trial]) -> tuple[tuple[Trial, ...], ...]:
        return rivals(evidence, every_effect, best, singles, rounds, fits, without, progress)

    others = rivals_of(best, without)
    while not untested and (better := _better(evidence, best, others)) is not None:
        plain, less = in_fewest_words(evidence, every_effect, nominal, better)
        if not gains(lead(evidence.scoring, plain, best)):
            break
        best, without = plain, less
        path.append(best)
        others = rivals_of(best, without)
    return SearchResult(
        evidence,
        nominal,
        best,
        singles=tuple(singles),
        rivals=others,
        path=tuple(path),
        without=without,
        fits=(nominal, *fits),
        untested=untested,
    )


def _winner(scoring: Scoring, tried: Sequence[Trial], base: Trial, nominal: Trial) -> Trial | None:
    """The best of some trials that is accepted on top of ``base``."""
    return next(iter(_accepted(scoring, tried, base, nominal)), None)


def _accepted(scoring: Scoring, tried: Sequence[Trial], base: Trial, nominal: Trial) -> list[Trial]:
    """Those of some trials that are accepted on top of ``base``."""
    return [trial for trial in tried if may_be_named(scoring, trial, base, nominal)]


def _may_be_worn(evidence: Evidence, winner: Trial | None, best: Trial, nominal: Trial) -> bool:
    """Whether to try all everyday effects on every joint: the search has ended with a gap left, or half of the
    joints have a gap that the winner does not close: wear is then likelier than faults. Where what is left is next to
    nothing, only at the end, and only if that costs no simulation of the whole body.
    """
    scoring, so_far = evidence.scoring, winner or best
    if closed_enough(scoring, so_far, nominal):
        return False
    if leaves_next_to_nothing(scoring, so_far, nominal):
        return winner is None and not evidence.predictor.simulator.needs_body(so_far.specs)
    return winner is None or gap_of(scoring, so_far.held_square).significant.mean() >= HALF


def _part(progress: ProgressCallback, name: str, done: int) -> ProgressCallback:
    return lambda text, share: progress(f"with {name}: {text}", min(0.8, 0.4 + 0.2 * (done - 1 + share)))


def _swap(evidence: Evidence, best: Trial, singles: Sequence[Trial]) -> Trial:
    """The first effect was chosen alone, as a compromise: try the others in its place now that there is a second."""
    tried = []
    for index, term in enumerate(best.hypothesis.terms[:-1]):
        rest = best.hypothesis.without(index)
        kept = best.hypothesis.rest(best.theta, index)
        for single in singles[:LOOKED_AT]:
            other = single.hypothesis.terms[0]
            if other.effect in best.hypothesis.names:
                continue
            if (term.stage == "body") != (other.stage == "body"):
                continue
            tried.append(Candidate(rest.plus(other), [np.concatenate([kept, single.theta])]))
    if not tried:
        return best
    fits = sorted(first_looks(evidence, tried), key=lambda t: -t.fitted_score(evidence.scoring))
    trials = held_out(evidence, fits[:FOLLOWED_UP], ahead=best)
    return ranked(evidence.scoring, [best, *trials])[0]


def _better(evidence: Evidence, best: Trial, rivals: Sequence[Sequence[Trial]]) -> Trial | None:
    """The best of some rivals that clearly does better than ``best``, fitted as that is; None where none does."""
    ahead = [r for of_term in rivals for r in of_term if gains(lead(evidence.scoring, r, best))]
    if not ahead:
        return None
    first = ranked(evidence.scoring, ahead)[0]
    better = run_trial(evidence, first.hypothesis, [first.theta])
    return better if gains(lead(evidence.scoring, better, best)) else None


def _elsewhere(evidence: Evidence, library: Library, best: Trial) -> Trial:
    """With the last effect on further joints too, where it closes their gap.

    Joints that each differ in the same way need no search of the whole library each.
    """
    more = elsewhere(evidence, library, best)
    if more is None:
        return best
    wider = run_trial(evidence, more.hypothesis, more.starts)
    return wider if accepted(evidence.scoring, wider, best) else best


def prune(evidence: Evidence, best: Trial) -> tuple[Trial, tuple[Trial, ...]]:
    """Take out every effect without which the explanation does as well, first those after which least is said.

    What is left is also compared with the whole explanation: small losses add up. Everyday effects that joints have
    values of their own of stay: joint by joint, it was tried to do without them.

    Returns what stays, and that without each of its terms.
    """
    whole, spared = best, True
    while spared and len(best.hypothesis.terms) > 1:
        shared = [i for i, term in enumerate(best.hypothesis.terms) if not term.own]
        less = in_parallel(partial(without_term, evidence, best), shared)
        spare = (t for t in less if not any(accepted(evidence.scoring, more, t) for more in (best, whole)))
        better = min(spare, key=lambda t: t.theta.size, default=None)
        spared = better is not None
        best = better or best
    if len(best.hypothesis.terms) < 2:
        return best, ()
    return best, without_each(evidence, best, dict(zip(shared, less, strict=True)))


def in_fewest_words(
    evidence: Evidence, library: Library, nominal: Trial, best: Trial
) -> tuple[Trial, tuple[Trial, ...]]:
    """``prune``, and every effect by its plainest name; ``library``: what may be named.

    What stood beside an effect may say nothing beside the plainer one; and what is left then may have a plainer name.
    """
    best, without = prune(evidence, best)
    for _ in range(2 * MOST_EFFECTS):
        plain = said_plainly(evidence, library, nominal, best)
        if plain is best:
            break
        best, without = prune(evidence, plain)
    return best, without


def without_term(evidence: Evidence, trial: Trial, index: int) -> Trial:
    """The trial of what is left when one term is taken out."""
    hypothesis = trial.hypothesis
    return run_trial_against(
        evidence, trial, hypothesis.without(index), [hypothesis.rest(trial.theta, index)]
    )


def without_each(
    evidence: Evidence, best: Trial, known: Mapping[int, Trial] = MappingProxyType({})
) -> tuple[Trial, ...]:
    """``best`` without each of its terms; ``known``: those that were tried already, by the term's place."""
    tried = dict(known)
    further = [i for i in range(len(best.hypothesis.terms)) if i not in tried]
    tried |= zip(further, in_parallel(partial(without_term, evidence, best), further), strict=True)
    return tuple(tried[i] for i in sorted(tried))


def as_fitted(evidence: Evidence, trial: Trial) -> Trial:
    """The same explanation with nothing held out."""
    return run_trial(evidence, trial.hypothesis, [trial.theta], cross=False, interval=True)


def only_fitted(scoring: Scoring, nominal: Trial, singles: Sequence[Trial]) -> Trial:
    """Where no effect is accepted on motions left out, for one motion alone shows it: the effect that closes the gap.

    Such an effect says nothing of the motion that shows it while that one is left out. What then predicts it worse than
    no effect at all is not untested but refuted.
    """
    gap = gap_of(scoring, nominal.held_square)
    sides = [scoring.of_angles] * bool(gap.significant.any()) + [scoring.of_ground] * gap.ground_significant

    def whole_and_harmless(trial: Trial) -> bool:
        gaps = [(excess(scoring, nominal, side), side) for side in sides]
        return all(
            excess_as_fitted(scoring, trial, side) < MOST_LEFT * there
            and excess(scoring, trial, side) < (1 + MOST_LEFT) * there
            for there, side in gaps
        )

    whole = [trial for trial in singles if whole_and_harmless(trial)]
    return min(
        whole,
        key=lambda t: (t.theta.size, -t.fitted_score(scoring)),
        default=nominal,
    )
