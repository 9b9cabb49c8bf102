"""What was left out of the search, and would look the same or be the same."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from snakebot.diagnosis.options import Options
from snakebot.diagnosis.result import Cause
from snakebot.diagnosis.search.plainly import comes_to
from snakebot.diagnosis.sizes import UNLIKELY
from snakebot.diagnosis.verdict.probability import at_most
from snakebot.effects.effect import Usual
from snakebot.effects.registry import look_alikes
from snakebot.effects.spec import parse_effect


def told_of_left_out(
    named: Iterable[str], causes: Sequence[Cause], usual: Usual, unnamed: Sequence[str], options: Options
) -> list[str]:
    """A warning for each effect that may not be named and leaves nearly the same mark as a ``named`` one, and for each
    cause that is just another word for one. Of two effects only the latter is said, where both hold: it says more.

    ``unnamed``: effects that may be there, but may not be named.
    """
    words = dict.fromkeys((cause.effect, another_word(cause, usual, options)) for cause in causes)
    alike = [
        f"{other} was left out, and leaves nearly the same mark as {name}; {tells}. A part of the probability is that "
        f"of {other}; if you know that it is not there, say --absent {other}"
        for name in named
        for other, tells in look_alikes(name).items()
        if other in unnamed and (name, other) not in words
    ]
    return alike + [
        f"{name} is, with these values, just {plain}, which was left out: allow that, or leave {name} out, too"
        for name, plain in words
        if plain is not None
    ]


def another_word(cause: Cause, usual: Usual, options: Options) -> str | None:
    """The plainer effect that a cause, with its values, is just another word for, if that one was left out; None if
    there is none. Whoever knows that the plainer one is not there knows that this one is not there either.
    """
    plainer = comes_to(parse_effect(cause.specification), usual)
    return plainer[0] if plainer is not None and plainer[0] in options.left_out else None


def doubted_for_left_out(cause: Cause, usual: Usual, unnamed: Sequence[str], options: Options) -> Cause:
    """The cause as likely as what was left out leaves it.

    Another word for what was left out is no likelier than what asks for more than it can be. Else effects that may be
    there, but may not be named (``unnamed``), have their part: each that leaves nearly the same mark is as likely as
    each of those named.
    """
    if another_word(cause, usual, options) is not None:
        return at_most(cause, UNLIKELY)
    named = {cause.effect, *cause.indistinguishable_from}
    others = {other for name in named for other in look_alikes(name) if other in unnamed} - named
    if not others:
        return cause
    share = len(named) / (len(named) + len(others))
    told = {
        "probability": round(cause.probability * share, 3),
        "evidence": {**cause.evidence, "share_of_named": share},
    }
    return cause.model_copy(update=told)
