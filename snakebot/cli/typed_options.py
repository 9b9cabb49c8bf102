"""Options of a command as one frozen dataclass, so that mypy sees each that is read."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

Option = Callable[[Callable[..., None]], Callable[..., None]]


def collected(kind: type[Any]) -> Option:
    """Hand a command those of its options that are fields of the dataclass ``kind`` as one, ``options``."""
    own = [field.name for field in fields(kind)]

    def decorated(command: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(command)
        def collecting(**given: Any) -> None:
            options = kind(**{name: given.pop(name) for name in own})
            command(options=options, **given)

        return collecting

    return decorated


def given(command: Callable[..., None], options: Sequence[Option]) -> Callable[..., None]:
    """Give a command these options, in this order in its help."""
    for option in reversed(options):
        command = option(command)
    return command
