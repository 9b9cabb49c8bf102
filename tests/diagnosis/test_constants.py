"""Every number at the top of a module of the diagnosis says what it means and where it comes from; there are few."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "snakebot" / "diagnosis"
SOURCE = re.compile(r"\b(chosen|measured|by definition)\b", re.IGNORECASE)
MOST_NUMBERS = 50  # in all modules; the count may only fall


def numbers_in(node: ast.AST) -> int:
    """How many numbers stand in an expression, other than as an index: those of a table count one by one."""
    if isinstance(node, ast.Constant):
        return int(type(node.value) in (int, float))
    parts = [node.value] if isinstance(node, ast.Subscript) else ast.iter_child_nodes(node)
    return sum(numbers_in(part) for part in parts)


def constants(path: Path) -> list[tuple[str, str, int]]:
    """Names in capitals that a module gives numbers to, the comment above or behind each, and how many numbers."""
    text = path.read_text(encoding="utf-8")
    lines, found = text.splitlines(), []
    for node in ast.parse(text).body:
        if not isinstance(node, (ast.Assign, ast.AnnAssign)) or node.value is None:
            continue
        name = ast.unparse(node.targets[0] if isinstance(node, ast.Assign) else node.target)
        if not re.fullmatch(r"\(?[A-Z_0-9, ]+\)?", name) or not numbers_in(node.value):
            continue
        first = node.lineno - 1
        while first > 0 and lines[first - 1].startswith("#"):
            first -= 1
        said = [line.partition("#")[2].strip() for line in lines[first : node.end_lineno]]
        found.append((name, " ".join(word for word in said if word), numbers_in(node.value)))
    return found


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda p: str(p.relative_to(PACKAGE)))
def test_a_constant_says_what_it_means_and_where_it_comes_from(path: Path) -> None:
    for name, comment, _ in constants(path):
        assert len(comment.split()) >= 4, f"{name}: no meaning: {comment!r}"
        assert SOURCE.search(comment), (
            f"{name}: not said whether chosen, measured or by definition: {comment!r}"
        )


def test_a_name_has_one_meaning() -> None:
    """No two modules give numbers to the same name: who reads one need not wonder whether it is the other."""
    where: dict[str, list[str]] = {}
    for path in PACKAGE.rglob("*.py"):
        for names, _, _ in constants(path):
            for name in names.strip("()").split(", "):
                where.setdefault(name, []).append(str(path.relative_to(PACKAGE)))
    assert {name: files for name, files in where.items() if len(files) > 1} == {}


def test_numbers_become_fewer() -> None:
    """Whoever needs a number looks first whether another one means the same; where some are gone, the limit follows."""
    count = sum(numbers for path in PACKAGE.rglob("*.py") for _, _, numbers in constants(path))
    assert count <= MOST_NUMBERS, f"{count} numbers: merge some, or let them follow from others"
