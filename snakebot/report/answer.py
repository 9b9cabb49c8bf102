"""The answer of a report, to be read without scrolling: a sentence, a drawing, one bar, how sure, what to do now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from snakebot.report.drawing import Drawing


@dataclass(frozen=True)
class ToDo:
    """Something to do: where, what, and perhaps the command that does it."""

    where: str
    text: str
    command: str = ""


@dataclass(frozen=True)
class Fall:
    """One error before and after, beside what noise alone makes; texts with their unit.

    Attributes:
        of: whose error.
        before, after, floor: in one unit; ``floor`` is None where it is not known.
        texts: of ``before``, ``after`` and ``floor``.
        after_name: what the second bar is.
        remark: what the fall comes to.
    """

    of: str
    before: float
    after: float
    floor: float | None
    texts: tuple[str, str, str]
    after_name: str = "with it"
    remark: str = ""

    def width(self, value: float) -> float:
        """Per cent of the longest."""
        most = max(self.before, self.after, self.floor or 0.0)
        return round(100 * value / most, 2) if most > 0 else 0.0


@dataclass(frozen=True)
class Answer:
    """``tone`` is ``good``, ``found`` or ``open``; ``sure`` is one word, ``why`` what it rests on."""

    verdict: str
    tone: str
    sentence: str
    sure: str
    why: str
    drawing: Drawing
    fall: Fall | None
    todo: Sequence[ToDo] = ()
    kind: str = field(default="answer", init=False)
