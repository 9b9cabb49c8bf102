"""What somebody who misspelt a name may have meant."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import islice

_MOST_KEYS = 100  # unknown keys that a hint looks at; chosen, files come from strangers
_CLOSE, _CLOSE_WORD = 0.6, 0.8  # ratios of difflib: of a whole name, of its first word


def nearest(name: object, known: Iterable[str], close: float = _CLOSE) -> str | None:
    """The known name that is most like this one, if any is."""
    from difflib import get_close_matches  # only where something is wrong already

    names = list(known)
    word = str(name)[:100]
    found = get_close_matches(word, names, 1, close)
    if found:
        return found[0]
    firsts = {
        entry.partition("_")[0]: entry for entry in reversed(names)
    }  # omga: the unit is left out as well
    found = get_close_matches(word, firsts, 1, max(close, _CLOSE_WORD))
    return firsts[found[0]] if found else None


def misspelt(
    keys: Iterable[object], known: Sequence[str], wanted: Sequence[str], close: float = _CLOSE
) -> tuple[object, str] | None:
    """The first key that is not known and nearly one of those wanted, and that one.

    Only so many keys are looked at: a stranger's file may have hundreds of thousands.
    """
    for key in islice((key for key in keys if key not in known), _MOST_KEYS if wanted else 0):
        near = nearest(key, wanted, close)
        if near is not None:
            return key, near
    return None


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """To follow a message: ``; did you mean rate_limit?``, or nothing."""
    near = nearest(name, known)
    return "" if near is None else f"; did you mean {near}?"


def not_known(key: object, known: Iterable[str], owner: str, above: str = "") -> str:
    """Of a key in a file: that it is not known, with the nearest that is, or else with all that are."""
    names = list(known)
    return f"{above}{key} is not known" + (did_you_mean(key, names) or f"; {owner} has {', '.join(names)}")
