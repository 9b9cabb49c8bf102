"""Rivals of what the search found: another effect in the place of one of its terms, fitted and held out alike."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import chain

from snakebot.diagnosis.candidates import candidates
from snakebot.diagnosis.contest import Progress, called_for, first_looks, held_out, ranked
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.hypothesis import Hypothesis
from snakebot.diagnosis.side_by_side import side_by_side
from snakebot.diagnosis.trial import Trial, run_trial
from snakebot.effects.effect import Effect
from snakebot.effects.registry import find_effect

MOST_RIVALS, MOST_HELD = 8, 3  # effects tried in another's place, and those of them that are cross-validated


def rivals(
    context: Context,
    best: Trial,
    singles: Sequence[Trial],
    tried: Mapping[Hypothesis, Sequence[Trial]],
    fits: Sequence[Trial],
    progress: Progress,
) -> tuple[tuple[Trial, ...], ...]:
    """Per term of ``best``, trials in which another effect takes its place, best first.

    Args:
        singles: trials of single effects; the rivals of an effect that stands alone.
        tried: fits of every effect on top of some explanations; where the rest of ``best`` is one of them, they do.
        fits: every single effect: those that came nearest are fitted otherwise.
    """
    likely = _added(sorted(fits, key=lambda t: -t.fitted_score(context)))[:MOST_RIVALS]
    nearest: dict[str, list[Effect]] = {}  # by effect, what else to try where it stands on another joint
    out = []
    for index, term in enumerate(best.hypothesis.terms):
        progress(f"rivals of {term.effect}", 0.8 + 0.2 * index / len(best.hypothesis.terms))
        out.append(_of_term(context, best, index, singles, tried, nearest.get(term.effect, likely)))
        nearest.setdefault(term.effect, _added(out[-1]) or likely)
    return tuple(out)


def _of_term(
    context: Context,
    best: Trial,
    index: int,
    singles: Sequence[Trial],
    tried: Mapping[Hypothesis, Sequence[Trial]],
    likely: Sequence[Effect],
) -> tuple[Trial, ...]:
    """Trials with another effect in the place of term ``index``, best first; ``likely`` ones, where none were tried."""
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
        wanted = [e for e in called_for(context, base, likely) if rival(e.name, e.stage)]
        made = side_by_side(partial(candidates, context, base), wanted)
        fits += first_looks(context, chain.from_iterable(made), base)
    fits.sort(key=lambda t: -t.fitted_score(context))
    return tuple(ranked(context, held_out(context, fits[:MOST_HELD])))


def _added(trials: Iterable[Trial]) -> list[Effect]:
    """What was added last in each of some trials."""
    return [find_effect(n) for n in dict.fromkeys(t.hypothesis.terms[-1].effect for t in trials)]
