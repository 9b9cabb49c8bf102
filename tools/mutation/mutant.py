"""One fault in one file, and how it is named."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

Change = tuple[str, int, int, str]  # operator, first byte, byte behind the last, what stands there instead


@dataclass(frozen=True, slots=True)
class Mutant:
    """A file in which one place says something else.

    ``name`` is the same as long as the place and what stands around it in its line are: reasons refer to it.
    """

    part: str  # core or sim
    file: str  # relative to the project
    operator: str
    line: int
    before: str  # the lines of the place
    after: str
    text: bytes  # the whole file
    number: int  # among those that look alike

    @property
    def name(self) -> str:
        alike = f" #{self.number}" if self.number > 1 else ""
        return f"{self.file}: {self.before}  =>  {self.after}{alike}"


def _lines(text: bytes, first: int, last: int) -> str:
    begin = text.rfind(b"\n", 0, first) + 1
    end = text.find(b"\n", last)
    return " ".join(text[begin : end if end >= 0 else len(text)].decode().split())


def mutants(part: str, file: str, text: bytes, changes: Iterable[Change]) -> list[Mutant]:
    """The mutants of one file; changes that make the same file are one mutant."""
    found: list[Mutant] = []
    seen: set[bytes] = {text}
    alike: dict[tuple[str, str], int] = {}
    for operator, first, last, instead in changes:
        new = instead.encode()
        changed = text[:first] + new + text[last:]
        if changed in seen:
            continue
        seen.add(changed)
        before, after = _lines(text, first, last), _lines(changed, first, first + len(new))
        number = alike[before, after] = alike.get((before, after), 0) + 1
        line = text.count(b"\n", 0, first) + 1
        found.append(Mutant(part, file, operator, line, before, after, changed, number))
    return found


def other_numbers(value: float, *, whole: bool, negative: bool = True) -> list[float]:
    """In place of a number: the neighbours of a small one, a tenth more or less of a large one or a fraction."""
    if not whole:
        return [value * 1.1, value * 0.9] if value else [0.1]
    if abs(value) >= 1000:
        return [round(value * 1.1), round(value * 0.9)]
    return [value + 1] + ([value - 1] if value > 0 or negative else [])
