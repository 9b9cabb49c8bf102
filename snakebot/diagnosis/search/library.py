"""The effects that a diagnosis may name, and what the data look like to them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from snakebot.diagnosis.evidence.data import Data, link_is_clean
from snakebot.diagnosis.fit.hypothesis import Fixed, Term
from snakebot.effects.effect import Effect
from snakebot.effects.observed import Observed
from snakebot.effects.registry import effects


@dataclass(frozen=True, eq=False)
class Library:
    """The effects that may be named.

    Attributes:
        effects: in the order of the signal.
        observed: what the data look like, for starts.
        known: parameters that the user has measured; keys ``parameter`` or ``effect.parameter``.
        unnamed: names of effects that may be there, but may not be named.
        everyday_kinds: by the name of an everyday effect, how its switches are set on this robot, as joints showed.
    """

    effects: tuple[Effect, ...]
    observed: Observed
    known: Mapping[str, float]
    unnamed: tuple[str, ...] = ()
    everyday_kinds: Mapping[str, Fixed] = field(default_factory=dict)

    def without_everyday(self) -> Library:
        """The effects that not every real joint has a little of."""
        return replace(self, effects=tuple(e for e in self.effects if not e.everyday))

    def of_kinds(self, terms: Iterable[Term]) -> Library:
        """With the everyday effects of the kinds that ``terms`` have."""
        return replace(self, everyday_kinds={**self.everyday_kinds, **{t.effect: t.fixed for t in terms}})


def usable_effects(
    data: Data,
    *,
    over_ground: bool,
    known: Mapping[str, float] | None = None,
    only: Sequence[str] = (),
    exclude: Sequence[str] = (),
    absent: Sequence[str] = (),
) -> Library:
    """Effects that this robot can show and that the user has not ruled out.

    Args:
        over_ground: whether the motion over ground was measured, in which alone effects of the body show.
        known, only, exclude, absent: see ``diagnose``.
    """
    observed = Observed(data.robot, data.runs)
    out: list[Effect] = []
    unnamed: list[str] = []
    clean = link_is_clean(data)
    for effect in effects().values():
        if effect.stage == "link" and clean and effect.name not in only:
            continue
        asked = effect.name in exclude or not only or effect.name in only
        if not asked or effect.name in absent or "mean" not in effect.shows_in:
            continue
        if not effect.applies_to(data.robot) or (effect.stage == "body" and not over_ground):
            continue
        if not effect.can_explain(observed):
            continue
        if effect.name in exclude:
            unnamed.append(effect.name)
        else:
            out.append(effect)
    return Library(tuple(out), observed, dict(known or {}), tuple(unnamed))
