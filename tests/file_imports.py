"""What a file of Python imports, wherever in it: an import is a statement, and expressions need no look."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

# Where statements stand in a tree.
HOLDS_STATEMENTS = ast.stmt | ast.excepthandler | ast.match_case


def _imports(node: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child
        elif isinstance(child, HOLDS_STATEMENTS):
            yield from _imports(child)


@cache
def imports_of(path: Path) -> tuple[ast.Import | ast.ImportFrom, ...]:
    """All import statements of a file; the rest of its tree is let go."""
    return tuple(_imports(ast.parse(path.read_text(encoding="utf-8"))))
