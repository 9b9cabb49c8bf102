"""The search: try every effect, keep what gains on held-out gaits, add another where it earns its place, prune.

Greedy choice by training error over-fits; so an effect is added only when its held-out gain is more than two standard
errors and large enough to matter, and is taken out again when the explanation does as well without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from snakebot.diagnosis.candidates import Candidate, elsewhere, usable_effects
from snakebot.diagnosis.contest import NO_LOSS, Progress, explore, first_looks, held_out
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.hypothesis import Hypothesis
from snakebot.diagnosis.merit import accepted, closed_enough, excess, worth
from snakebot.diagnosis.rivals import rivals
from snakebot.diagnosis.side_by_side import side_by_side
from snakebot.diagnosis.trial import Trial, nominal_trial, run_trial

MOST_EFFECTS = 3
MOST_TERMS = 6  # an effect may be there several times, on joints that differ in it: one a joint, and one more
LEAST_LEFT = 0.03  # of the gap, left of motions it was fitted to, for an effect that no other motion can test
NO_TORQUE = 0.05  # of the usual load, below which a torque limit holds nothing


@dataclass(frozen=True, eq=False)
class Found:
    """What the search came to.

    Attributes:
        nominal: the robot without any effect.
        best: the explanation that stands; ``nominal`` if none does.
        predicted: the same on runs left out of its fit; another trial only where it is ``untested``.
        singles: trials of single effects, best first: the ranking.
        rivals: per term of ``best``, trials in which another effect takes its place, best first.
        path: (hypothesis) trials in the order in which effects were added.
        without: ``best`` with each of its terms taken out, as far as that was tried.
        fits: every single effect as fitted to all free runs, held out or not.
        untested: ``best`` shows in too few motions for any to be left out of its fit: it and ``singles`` are as fitted.
        by_chance: the cause shows in the scatter, whether or not the mean is off.
    """

    nominal: Trial
    best: Trial
    predicted: Trial
    singles: tuple[Trial, ...]
    rivals: tuple[tuple[Trial, ...], ...]
    path: tuple[Trial, ...]
    without: tuple[Trial, ...] = ()
    fits: tuple[Trial, ...] = ()
    untested: bool = False
    by_chance: bool = False


def search(
    context: Context,
    *,
    only: Sequence[str] = (),
    exclude: Sequence[str] = (),
    quick: bool = False,
    progress: Progress = lambda text, share: None,
) -> Found:
    """Find the explanation of a session's gap."""
    library = usable_effects(context, only, exclude)
    nominal = nominal_trial(context)
    gap = gap_of(context, nominal)
    ill = [j for j in range(context.data.joints) if gap.significant[j]] + [-1] * gap.ground_significant
    context.settle(~np.isin(context.block_joint, ill), nominal.held_square)
    singles, fits = explore(context, nominal, library, lambda text, share: progress(text, 0.4 * share))
    tried = {nominal.hypothesis: fits}
    path = [nominal]
    best = nominal
    round_ = singles
    limit = 2 if quick else MOST_EFFECTS
    while round_ and len(best.hypothesis.names) < limit:
        earned = (t for t in round_ if accepted(context, t, best) and worth(context, t, best, nominal))
        winner = next(earned, None)
        if winner is None:
            break
        best = winner
        path.append(best)
        if len(best.hypothesis.terms) >= 2:
            best = _elsewhere(context, _swap(context, best, singles))
            path[-1] = best
        if len(best.hypothesis.names) >= limit or len(best.hypothesis.terms) >= MOST_TERMS:
            break
        if closed_enough(context, best, nominal):
            break
        count = len(best.hypothesis.terms)
        base = best.hypothesis
        round_, tried[base] = explore(context, best, library, _part(progress, str(base), count))
    pruned, without = prune(context, best)
    best = _plain(context, pruned, singles)
    untested = not best.hypothesis.terms
    predicted = best
    if untested:
        predicted = _only_fitted(context, nominal, singles)
        if (
            predicted.hypothesis.terms
        ):  # nothing is held out now: what else was tried is compared by its fit as well
            singles = side_by_side(partial(as_fitted, context), singles)
            best = next(t for t in singles if t.hypothesis == predicted.hypothesis)
    return Found(
        nominal,
        best,
        predicted,
        singles=tuple(singles),
        rivals=rivals(context, best, singles, tried, fits, progress),
        path=tuple(path),
        without=without if best is pruned else (),
        fits=(nominal, *fits),
        untested=untested,
    )


def _part(progress: Progress, name: str, done: int) -> Progress:
    return lambda text, share: progress(f"with {name}: {text}", min(0.8, 0.4 + 0.2 * (done - 1 + share)))


def _swap(context: Context, best: Trial, singles: Sequence[Trial]) -> Trial:
    """The first effect was chosen alone, as a compromise: try the others in its place now that there is a second."""
    tried = []
    for index, term in enumerate(best.hypothesis.terms[:-1]):
        rest = best.hypothesis.without(index)
        kept = best.hypothesis.rest(best.theta, index)
        for single in singles[:6]:
            other = single.hypothesis.terms[0]
            if other.effect in best.hypothesis.names:
                continue
            if (term.stage == "body") != (other.stage == "body"):
                continue
            tried.append(Candidate(rest.plus(other), [np.concatenate([kept, single.theta])]))
    if not tried:
        return best
    fits = sorted(first_looks(context, tried), key=lambda t: -t.fitted_score(context))
    trials = held_out(context, fits[:2])
    return max([best, *trials], key=lambda t: t.score(context))


def _elsewhere(context: Context, best: Trial) -> Trial:
    """With the last effect on further joints too, where that is all that ails them.

    Joints that each differ in the same way need no search of the whole library each.
    """
    more = elsewhere(context, best)
    if more is None:
        return best
    wider = run_trial(context, more.hypothesis, more.starts)
    return wider if accepted(context, wider, best) else best


def prune(context: Context, best: Trial) -> tuple[Trial, tuple[Trial, ...]]:
    """Take out every effect without which the explanation does as well.

    Returns what stays, and that without each of its terms.
    """
    while len(best.hypothesis.terms) > 1:
        terms = range(len(best.hypothesis.terms))
        without = tuple(side_by_side(partial(without_term, context, best), terms))
        better = next((less for less in without if not accepted(context, best, less)), None)
        if better is None:
            return best, without
        best = better
    return best, ()


def without_term(context: Context, trial: Trial, index: int) -> Trial:
    """The trial of what is left when one term is taken out."""
    hypothesis = trial.hypothesis
    return run_trial(context, hypothesis.without(index), [hypothesis.rest(trial.theta, index)])


def as_fitted(context: Context, trial: Trial) -> Trial:
    """The same explanation with nothing held out."""
    return run_trial(context, trial.hypothesis, [trial.theta], cross=False)


def _only_fitted(context: Context, nominal: Trial, singles: Sequence[Trial]) -> Trial:
    """Where nothing stands on motions left out, because only one shows it: the effect that accounts for it whole."""
    gap = gap_of(context, nominal)
    sides = [np.asarray(context.block_joint >= 0)] * bool(gap.significant.any())
    sides += [np.asarray(context.block_joint < 0)] * gap.ground_significant
    whole = [
        t
        for t in singles
        if all(
            excess(context, replace(t, held_square=t.fitted_square), side)
            < LEAST_LEFT * excess(context, nominal, side)
            for side in sides
        )
    ]
    return min(
        whole,
        key=lambda t: (t.theta.size, -t.fitted_score(context)),
        default=nominal,
    )


def _plain(context: Context, best: Trial, singles: Sequence[Trial]) -> Trial:
    """The same said more plainly: of all joints where that does as well, and a servo without torque as a free joint."""
    for term in best.hypothesis.terms:
        if term.joints is None or len(term.joints) < 2 or not term.open:
            continue
        parts = zip(best.hypothesis.terms, best.hypothesis.split(best.theta), strict=True)
        kept = [(t, values) for t, values in parts if t == term or t.effect != term.effect]
        wide = Hypothesis(tuple(replace(t, joints=None) if t == term else t for t, _ in kept))
        wider = run_trial(context, wide, [np.concatenate([values for _, values in kept])])
        lost = context.gain(best.held_square, wider.held_square)
        if lost.mean < max(lost.se, NO_LOSS):
            best = wider
    if best.hypothesis.names == ("torque_limit",):
        free = next((t for t in singles if t.hypothesis.names == ("joint_free",)), None)
        loads = [load for load in map(context.simulator.load, context.free_runs) if load is not None]
        typical = float(np.sqrt(np.mean([np.mean(np.square(load)) for load in loads]))) if loads else 0.0
        if (
            free is not None
            and free.hypothesis.terms[0].joints == best.hypothesis.terms[0].joints
            and best.theta[0] < NO_TORQUE * typical
        ):
            return free
    return best
