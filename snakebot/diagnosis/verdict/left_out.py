"""What was left out of the search, and would look the same."""

from __future__ import annotations

from collections.abc import Iterable

from snakebot.diagnosis.options import Options
from snakebot.effects.registry import find_effect


def left_out(named: Iterable[str], options: Options) -> list[str]:
    """A warning for each effect that may not be named and leaves nearly the same mark as a ``named`` one. It changes no
    probability: whoever leaves an effect out may know that it is not there.
    """
    return [
        f"{other} was left out, and leaves nearly the same mark as {name}; {tells}"
        for name in named
        for other, tells in find_effect(name).confused_with
        if other in options.exclude
    ]
