"""Numbers and lists as a person reads them: three digits, "1.8 to 2.3", "1, 2 and 4"."""

from __future__ import annotations

import math
from collections.abc import Sequence


def three(value: float) -> str:
    """``value`` to three significant digits, without an exponent where it can be helped: 2.00, 0.0131, 1250."""
    if not math.isfinite(value):
        return "unknown"
    if value == 0:
        return "0"
    rounded = float(f"{value:.2e}")
    exponent = math.floor(math.log10(abs(rounded)))
    if not -5 <= exponent <= 6:
        return f"{value:.2e}"
    return f"{rounded:.{max(2 - exponent, 0)}f}"


def span(low: float, high: float) -> str:
    """An interval, both ends with as many decimals as the larger one needs: "1.8 to 2.3"."""
    if not (math.isfinite(low) and math.isfinite(high)):
        return "unknown"
    width = high - low
    size = max(abs(low), abs(high))
    if size == 0:
        return "0"
    exponent = math.floor(math.log10(size))
    # two digits of the ends, or as many as tell their distance within a fifth, but no more than four
    needed = -math.floor(math.log10(width / 2)) if width > 0 else 0
    decimals = min(max(1 - exponent, needed), 3 - exponent)
    ends = [f"{value:.{max(decimals, 0)}f}" for value in (low, high)]
    return ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"


def listed(items: Sequence[object], word: str = "and") -> str:
    """ "1", "1 and 2", "1, 2 and 4"."""
    texts = [str(item) for item in items]
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} {word} {texts[-1]}" if texts else ""


def numbered(what: str, numbers: Sequence[int]) -> str:
    """ "joint 3", "joints 1, 2"."""
    return f"{what}{'' if len(numbers) == 1 else 's'} {', '.join(map(str, numbers))}"


def with_unit(text: str, unit: str) -> str:
    """A number and its unit; per cent and factors stand as they are said."""
    return f"{text} {unit}" if unit else text


def plain(text: object) -> str:
    """``text`` as one line that cannot steer a terminal, whoever wrote it: "?" for what cannot be printed."""
    return "".join(sign if sign.isprintable() else "?" for sign in str(text))


def shortened(text: str, most: int = 44) -> str:
    """``text`` with its middle left out where it is longer than ``most``: one long name hides no other column."""
    if len(text) <= most:
        return text
    tail = most // 2
    return f"{text[: most - tail - 3]}...{text[-tail:]}"
