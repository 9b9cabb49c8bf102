"""One way to add an effect to an explanation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.sizes import HALF
from snakebot.effects.effect import Start

SIZE_BESIDE = HALF  # of an effect beside others, share of its size where it is alone


@dataclass(frozen=True, eq=False)
class Candidate:
    """A hypothesis and where to start it, each (p,)."""

    hypothesis: Hypothesis
    starts: list[Floats]


def added(base: Trial, term: Term, starts: Sequence[Floats]) -> Candidate:
    """What ``base`` says and one more term, from each of ``starts`` of its parameters."""
    return Candidate(base.hypothesis.plus(term), [np.concatenate([base.theta, start]) for start in starts])


def start_values(term: Term, start: Start) -> Floats:
    """(p,) values of the open parameters of a term; what a start leaves out is as usual."""
    return np.array([_number(start.get(p.name, p.typical)) for p in term.open_of_one])


def scaled(term: Term, start: Floats, factor: float) -> Floats:
    """(p,) parameters of a term so many times as strong, by the first of them, within their bounds: at so much of its
    distance from neutral, or through so much where it has no neutral value, as what limits or holds a joint: the less
    of that, the stronger the effect.
    """
    first, value = term.open[0], float(start[0])
    fades = first.scale == "log" and first.neutral < first.lower
    moved = value / factor if fades else first.neutral + (value - first.neutral) * factor
    return np.array([p.clip(v) for p, v in zip(term.open, [moved, *start[1:].tolist()], strict=True)])


def _number(value: float | tuple[float, ...]) -> float:
    assert not isinstance(value, tuple)
    return float(value)
