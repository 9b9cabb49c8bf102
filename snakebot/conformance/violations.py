"""How a case ends other than well, and the one way to say so."""

from __future__ import annotations


class ViolationError(AssertionError):
    """The board has broken a rule: the text says what was expected and what was seen."""


class NotApplicableError(Exception):
    """This board, or this bench, cannot be asked that."""


class HostStalledError(Exception):
    """This computer was too late for the case to mean anything."""


def expect(condition: object, what: str) -> None:
    """Raise a violation that says ``what``."""
    if not condition:
        raise ViolationError(what)
