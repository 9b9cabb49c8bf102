"""Imports of the package run one way, in the order of the table in CONTRIBUTING.md."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from file_imports import HOLDS_STATEMENTS, imports_of

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "snakebot"
ROWS = re.findall(r"^\| (`.*`) \|", (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"), re.MULTILINE)
ORDER = [re.findall(r"`(?:snakebot/)?(\w+)(?:\.py)?`", row) for row in ROWS]
LINE_OF = {name: number for number, names in enumerate(ORDER) for name in names}
FOLDERS = sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))
# Folders of one line that nevertheless have an order between them.
WITHIN = {("gait", "robot"), ("physics", "robot"), ("board", "links"), ("analysis", "runlog")}
# Modules beside the folders that know none of them: errors, files, numbers, clocks.
SHARED = {path.stem for path in PACKAGE.glob("*.py")} - {"__init__", "__main__", "robot"}


@cache
def imported(path: Path) -> set[str]:
    """Folders and modules of the package, or of the protocol, that a file imports."""
    found = set()
    for node in imports_of(path):
        if isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: a relative import"
            module = node.module or ""
            names = [f"snakebot.{alias.name}" for alias in node.names] if module == "snakebot" else [module]
        else:
            names = [alias.name for alias in node.names]
        found |= {name.split(".")[1] for name in names if name.startswith("snakebot.")}
        found |= {name.split(".")[0] for name in names if name.startswith("firmware_protocol")}
    return found - {"__version__", "__file__"}


def test_every_folder_stands_in_the_table_once() -> None:
    told = [name for names in ORDER for name in names]
    assert set(FOLDERS) <= set(told)
    assert len(told) == len(set(told))


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_imports_only_what_stands_above_it(folder: str) -> None:
    for path in (PACKAGE / folder).rglob("*.py"):
        for other in imported(path) - {folder} - SHARED:
            above = LINE_OF[other] < LINE_OF[folder] or (folder, other) in WITHIN
            assert above, f"{path.relative_to(ROOT)} imports {other}"


def test_what_all_share_imports_no_folder() -> None:
    for name in SHARED:
        assert imported(PACKAGE / f"{name}.py") <= SHARED | {"robot"}, name


def test_no_wire_in_the_physics_no_link_in_the_diagnosis_no_gait_on_the_servo_bus() -> None:
    forbidden = {
        "physics": {"links", "board", "softboard", "servobus", "firmware_protocol", "control"},
        "diagnosis": {"links", "board", "softboard", "servobus", "firmware_protocol", "control"},
        "servobus": {"gait", "effects", "diagnosis"},
    }
    for folder, others in forbidden.items():
        for path in (PACKAGE / folder).rglob("*.py"):
            assert not imported(path) & others, path
    assert not any("cli" in imported(path) for path in PACKAGE.rglob("*.py") if "cli" not in path.parts[-2:-1]
                   and path.name != "__main__.py")  # fmt: skip


def is_left_out(test: ast.expr) -> bool:
    """Whether it is the condition of the type checker, or of the program itself."""
    if isinstance(test, ast.Compare) and isinstance(test.left, ast.Name) and test.left.id == "__name__":
        return ast.unparse(test) == "__name__ == '__main__'"
    return isinstance(test, ast.Name) and test.id == "TYPE_CHECKING"


def run_imports(node: ast.AST) -> Iterator[ast.ImportFrom | ast.Import]:
    """Imports of a file wherever they stand, but for those that only the type checker or the program itself runs."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and is_left_out(child.test):
            continue
        if isinstance(child, ast.ImportFrom | ast.Import):
            yield child
        if isinstance(child, HOLDS_STATEMENTS):
            yield from run_imports(child)


def test_files_import_each_other_in_no_circle() -> None:
    files = {".".join(path.relative_to(ROOT).with_suffix("").parts): path for path in PACKAGE.rglob("*.py")}
    files = {name.removesuffix(".__init__"): path for name, path in files.items()}
    graph: dict[str, set[str]] = {}
    for name, path in files.items():
        needs: set[str] = set()
        for node in run_imports(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                needs |= {alias.name for alias in node.names}
            else:
                each = {f"{node.module}.{alias.name}" for alias in node.names}
                needs |= {one if one in files else node.module or "" for one in each}
        graph[name] = needs & set(files) - {name}
    TopologicalSorter(graph).prepare()  # raises CycleError with the files of a circle
