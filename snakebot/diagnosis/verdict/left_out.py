"""What was left out of the search, and would look the same or be the same."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from snakebot.diagnosis.options import Options
from snakebot.diagnosis.result import Cause
from snakebot.diagnosis.search.plainly import comes_to
from snakebot.diagnosis.verdict.at_end import MOST_AT_END
from snakebot.diagnosis.verdict.probability import at_most
from snakebot.effects.effect import Usual
from snakebot.effects.registry import find_effect
from snakebot.effects.spec import parse_effect


def told_of_left_out(
    named: Iterable[str], causes: Sequence[Cause], usual: Usual, options: Options
) -> list[str]:
    """A warning for each effect that may not be named and leaves nearly the same mark as a ``named`` one, and for each
    cause that is just another word for one. Of two effects only the latter is said, where both hold: it says more.

    The first changes no probability: whoever leaves an effect out may know that it is not there.
    """
    words = dict.fromkeys((cause.effect, another_word(cause, usual, options)) for cause in causes)
    alike = [
        f"{other} was left out, and leaves nearly the same mark as {name}; {tells}"
        for name in named
        for other, tells in find_effect(name).confused_with
        if other in options.exclude and (name, other) not in words
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
    return plainer[0] if plainer is not None and plainer[0] in options.exclude else None


def held_back_as_another_word(cause: Cause, usual: Usual, options: Options) -> Cause:
    """The cause; another word for what was left out is no likelier than what asks for more than it can be."""
    return cause if another_word(cause, usual, options) is None else at_most(cause, MOST_AT_END)
