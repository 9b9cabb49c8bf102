"""The search: try every effect, keep what gains on held-out gaits, add another where it earns its place, prune.

Greedy choice by training error over-fits; so an effect is added only when its held-out gain is more than two standard
errors and large enough to matter, and is taken out again when the explanation does as well without it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.blocks import Difference
from snakebot.diagnosis.candidates import CHANGED, Candidate, candidates, elsewhere, usable_effects
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.hypothesis import Hypothesis
from snakebot.diagnosis.side_by_side import side_by_side
from snakebot.diagnosis.trial import Trial, nominal_trial, run_trial
from snakebot.effects.effect import Effect
from snakebot.effects.registry import effects, find_effect

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

MOST_EFFECTS = 3
MOST_TERMS = 6  # an effect may be there several times, on joints that differ in it: one a joint, and one more
LEAST_LEFT = (
    0.03  # of the gap, that an effect may leave of the motions it was fitted to, if no other can test it
)
NO_TORQUE = 0.05  # of the usual load, below which a torque limit holds nothing
NO_LOSS = 0.01  # held-out score that a simpler explanation may lose and still go first
CLEAR_SE = 2.0
WORTH = (
    0.005  # share of the whole gap that an effect beside the first must close, and at which a rest is let be
)
MATTERS = 0.05  # held-out score on the blocks an effect touches: a tenth of their mean square
CLOSE_RACE = 0.25  # rivals within this share of the winner's gain are cross-validated ...
FEWEST_TRIALS, MOST_TRIALS = 3, 6  # ... within these bounds,
MOST_FURTHER = 3  # ... and these beside an effect that stands, where the best alone counts
MOST_RIVALS, MOST_HELD = 8, 3  # effects tried in another's place, and those of them that are cross-validated

Progress = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class Found:
    """What the search came to.

    Attributes:
        nominal: the robot without any effect.
        best: the explanation that stands; ``nominal`` if none does.
        singles: trials of single effects, best first: the ranking.
        rivals: per term of ``best``, trials in which another effect takes its place, best first.
        path: (hypothesis) trials in the order in which effects were added.
        without: ``best`` with each of its terms taken out, as far as that was tried.
        fits: every single effect as fitted to all free runs, held out or not.
        untested: ``best`` shows in too few motions for any to be left out of its fit.
        by_chance: the cause shows in the scatter, whether or not the mean is off.
    """

    nominal: Trial
    best: Trial
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
    singles, fits = _explore(context, nominal, library, lambda text, share: progress(text, 0.4 * share))
    tried = {nominal.hypothesis: fits}
    path = [nominal]
    best = nominal
    round_ = singles
    limit = 2 if quick else MOST_EFFECTS
    while round_ and len(best.hypothesis.names) < limit:
        earned = (t for t in round_ if accepted(context, t, best) and _worth(context, t, best, nominal))
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
        round_, tried[base] = _explore(context, best, library, _part(progress, str(base), count))
    pruned, without = prune(context, best)
    best = _plain(context, pruned, singles)
    untested = not best.hypothesis.terms
    if untested:
        best = _only_fitted(context, nominal, singles)
    rivals = []
    likely = _likely(context, fits)
    nearest: dict[
        str, list[Effect]
    ] = {}  # of an effect on one joint: all there is to try where it stands on another
    for index in range(len(best.hypothesis.terms)):
        effect = best.hypothesis.terms[index].effect
        progress(f"rivals of {effect}", 0.8 + 0.1 * index)
        rivals.append(_rivals(context, best, index, singles, tried, nearest.get(effect, likely)))
        nearest.setdefault(effect, _effects(rivals[-1]) or likely)
    return Found(
        nominal,
        best,
        singles=tuple(singles),
        rivals=tuple(rivals),
        path=tuple(path),
        without=without if best is pruned else (),
        fits=(nominal, *fits),
        untested=untested,
    )


def _part(progress: Progress, name: str, done: int) -> Progress:
    return lambda text, share: progress(f"with {name}: {text}", 0.4 + 0.2 * (done - 1 + share))


def touched(context: Context, trial: Trial, base: Trial) -> Bools:
    """(B,) deciding blocks on which a trial does other than its base, better or worse.

    A limit that is reached in one gait of five says nothing in the other four.
    """
    changed = np.abs(trial.held_square - base.held_square) > CHANGED * context.allowed_square
    return np.asarray(changed & context.selects)


def accepted(context: Context, trial: Trial, base: Trial) -> bool:
    """Whether what was added to ``base`` gains more than two standard errors, and enough to matter, where
    there is a gap.
    """
    rows = touched(context, trial, base)
    gap = gap_of(context, base)
    joints = [
        j
        for j in np.unique(context.block_joint[rows])
        if (gap.ground_significant if j < 0 else gap.significant[j])
    ]
    if not joints:
        return False
    gain = context.gain(trial.held_square, base.held_square, rows)
    return gain.z > CLEAR_SE and gain.mean > MATTERS


def _worth(context: Context, trial: Trial, base: Trial, nominal: Trial) -> bool:
    """Whether what was added closes enough of the whole gap, of the angles or over ground, to be named."""
    if not base.hypothesis.terms:
        return True
    side = np.asarray(
        context.block_joint < 0 if trial.hypothesis.terms[-1].stage == "body" else context.block_joint >= 0
    )
    fell = _excess(context, base, side) - _excess(context, trial, side)
    return fell > WORTH * _excess(context, nominal, side)


def closed_enough(context: Context, trial: Trial, nominal: Trial) -> bool:
    """Whether nothing worth a further effect is left above what noise and tolerance allow."""
    gap = gap_of(context, trial)
    angle, ground = (np.asarray(context.block_joint >= 0), np.asarray(context.block_joint < 0))
    return not any(
        there and _excess(context, trial, side) > WORTH * _excess(context, nominal, side)
        for there, side in ((gap.significant.any(), angle), (gap.ground_significant, ground))
    )


def _only_fitted(context: Context, nominal: Trial, singles: Sequence[Trial]) -> Trial:
    """Where nothing stands on motions left out, because only one shows it: the effect that accounts for it whole."""
    gap = gap_of(context, nominal)
    sides = [np.asarray(context.block_joint >= 0)] * bool(gap.significant.any())
    sides += [np.asarray(context.block_joint < 0)] * gap.ground_significant
    whole = [
        t
        for t in singles
        if all(
            _excess(context, replace(t, held_square=t.fitted_square), side)
            < LEAST_LEFT * _excess(context, nominal, side)
            for side in sides
        )
    ]
    return min(
        whole,
        key=lambda t: (t.theta.size, -t.fitted_score(context)),
        default=nominal,
    )


def _excess(context: Context, trial: Trial, side: Bools) -> float:
    """Mean square above the allowed one: of the angles in rad^2, of the ground against what each feature is allowed."""
    rows = side & context.selects
    allowed = context.allowed_square[rows]
    over = np.maximum(trial.held_square[rows] - allowed, 0.0)
    if not rows.any():
        return 0.0
    return float(np.mean(over / allowed if context.block_joint[rows][0] < 0 else over))


def _explore(
    context: Context, base: Trial, library: Sequence[Effect], progress: Progress
) -> tuple[list[Trial], list[Trial]]:
    """Trials of each effect on top of ``base``, best first by held-out score, and all fits, held out or not."""
    wanted = _called_for(context, base, library)
    if not wanted:
        return [], []

    def tell(count: int) -> None:
        progress(f"trying {wanted[count - 1].name}", 0.6 * count / len(wanted))

    made = side_by_side(partial(candidates, context, base), wanted, tell)
    fits = _first_looks(context, chain.from_iterable(made), base)
    reached = [
        float((context.score(t.fitted_square) - context.score(base.fitted_square))[context.selects].mean())
        for t in fits
    ]
    order = np.argsort(reached, kind="stable")[::-1]
    if order.size == 0:
        return [], []
    near = [i for i in order if reached[i] >= (1 - CLOSE_RACE) * reached[order[0]]]
    kept = list(dict.fromkeys([*order[:FEWEST_TRIALS], *near]))[
        : MOST_FURTHER if base.hypothesis.terms else MOST_TRIALS
    ]
    progress("holding out gaits", 0.8)
    trials = _held_out(context, [fits[i] for i in kept if reached[i] > 0])
    progress("", 1.0)
    return _ranked(context, trials), fits


def _called_for(context: Context, base: Trial, library: Sequence[Effect]) -> list[Effect]:
    """Effects for whose side, angles or ground, ``base`` leaves a gap."""
    gap = gap_of(context, base)
    return [e for e in library if (gap.ground_significant if e.stage == "body" else gap.significant.any())]


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


def _ranked(context: Context, trials: Sequence[Trial]) -> list[Trial]:
    """Best first by held-out score; but one that says less, at a loss within a standard error, goes first.

    Of exact ties the effect that comes first in the signal stands first.
    """
    place = {name: i for i, name in enumerate(effects())}
    ordered = sorted(
        trials,
        key=lambda t: (-round(t.score(context), 4), len(t.theta), [place[n] for n in t.hypothesis.names]),
    )
    if len(ordered) < 2:
        return ordered
    first = ordered[0]
    for other in ordered[1:]:
        lost = context.gain(first.held_square, other.held_square)
        if _said(other) < _said(first) and lost.mean < max(lost.se, NO_LOSS):
            first = other
    ordered.remove(first)
    return [first, *ordered]


def _said(trial: Trial) -> tuple[int, int]:
    """How much an explanation says: parameters, then joints that must be named."""
    return len(trial.theta), _named(trial.hypothesis)


def _named(hypothesis: Hypothesis) -> int:
    """How much must be said about joints: nothing where all are alike."""
    return sum(0 if t.joints is None else 1 for t in hypothesis.terms)


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
    fits = sorted(_first_looks(context, tried), key=lambda t: -t.fitted_score(context))
    trials = _held_out(context, fits[:2])
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


def _likely(context: Context, fits: Sequence[Trial]) -> list[Effect]:
    """The effects that alone came nearest, of the joints and of the body."""
    return _effects(sorted(fits, key=lambda t: -t.fitted_score(context)))[:MOST_RIVALS]


def _effects(trials: Iterable[Trial]) -> list[Effect]:
    """What was added last in each of some trials."""
    return [find_effect(n) for n in dict.fromkeys(t.hypothesis.terms[-1].effect for t in trials)]


def _rivals(
    context: Context,
    best: Trial,
    index: int,
    singles: Sequence[Trial],
    tried: Mapping[Hypothesis, Sequence[Trial]],
    likely: Sequence[Effect],
) -> tuple[Trial, ...]:
    """Trials with another effect in the place of term ``index``, best first.

    Args:
        tried: fits of every effect on top of some explanations; where the rest of ``best`` is one of them, they do.
        likely: effects that are fitted otherwise.
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

    def rival(name: str, stage: str) -> bool:
        return name not in best.hypothesis.names and (stage == "body") == (term.stage == "body")

    fits = [
        fit
        for fit in tried.get(rest, ())
        if rival(fit.hypothesis.terms[-1].effect, fit.hypothesis.terms[-1].stage)
    ]
    if rest not in tried:
        base = run_trial(context, rest, [best.hypothesis.rest(best.theta, index)], cross=False)
        wanted = [e for e in _called_for(context, base, likely) if rival(e.name, e.stage)]
        made = side_by_side(partial(candidates, context, base), wanted)
        fits += _first_looks(context, chain.from_iterable(made), base)
    fits.sort(key=lambda t: -t.fitted_score(context))
    return tuple(_ranked(context, _held_out(context, fits[:MOST_HELD])))


def _first_looks(context: Context, made: Iterable[Candidate], base: Trial | None = None) -> list[Trial]:
    """A rough fit of each candidate, nothing held out; what a ``base`` of many terms says is left as it is."""
    last = base is not None and len(base.hypothesis.terms) >= MOST_EFFECTS
    look = partial(run_trial, context, cross=False, rough=True, last=last)
    return side_by_side(lambda c: look(c.hypothesis, c.starts), made)


def _held_out(context: Context, fits: Sequence[Trial]) -> list[Trial]:
    """The same explanations, cross-validated from where these fits ended."""
    return side_by_side(lambda t: run_trial(context, t.hypothesis, [t.theta]), fits)


def lead(context: Context, trial: Trial, other: Trial) -> Difference:
    """How far a trial leads another, on the blocks where they differ."""
    rows = touched(context, trial, other)
    if not rows.any():
        return Difference(0.0, 0.0)
    return context.gain(trial.held_square, other.held_square, rows)
