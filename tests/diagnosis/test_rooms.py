"""Data flow one way through the rooms of the diagnosis: a room imports only rooms before it."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from file_imports import imports_of

import snakebot.diagnosis

PACKAGE = Path(snakebot.diagnosis.__file__).parent
BEFORE = {
    "evidence": set(),
    "fit": {"evidence"},
    "search": {"evidence", "fit"},
    "verdict": {"evidence", "fit", "search"},
    "proposal": {"evidence", "fit", "search"},
    "show": set(),
}
COMMON = {"options", "result", "sizes"}  # what is asked, the types of the answer, and sizes that all go by


def imported(path: Path) -> set[str]:
    """Rooms, and modules beside them, that a file imports."""
    found = set()
    for node in imports_of(path):
        names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        found |= {name.split(".")[2] for name in names if name.startswith("snakebot.diagnosis.")}
    return found


def test_every_folder_is_a_room_that_says_what_comes_in_and_goes_out() -> None:
    rooms = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert rooms == set(BEFORE)
    for room in rooms:
        told = ast.get_docstring(ast.parse((PACKAGE / room / "__init__.py").read_text(encoding="utf-8")))
        assert told
        assert room == "show" or ("In: " in told and "Out: " in told), room


@pytest.mark.parametrize("room", BEFORE)
def test_a_room_imports_only_rooms_before_it(room: str) -> None:
    for path in (PACKAGE / room).glob("*.py"):
        assert imported(path) <= {room} | BEFORE[room] | COMMON, path


def test_what_all_rooms_share_imports_none_of_them() -> None:
    for name in COMMON:
        assert not imported(PACKAGE / f"{name}.py"), name


def test_files_of_a_room_do_not_import_each_other_in_a_circle() -> None:
    for room in BEFORE:
        files = {path.stem: path for path in (PACKAGE / room).glob("*.py") if path.stem != "__init__"}
        needs = {name: _beside(path, room) & set(files) for name, path in files.items()}
        while free := {name for name, others in needs.items() if not others}:
            needs = {name: others - free for name, others in needs.items() if name not in free}
        assert not needs, f"{room}: {sorted(needs)}"


def _beside(path: Path, room: str) -> set[str]:
    """Files of its own room that a file imports."""
    found = set()
    for node in imports_of(path):
        if isinstance(node, ast.ImportFrom) and node.module:
            inside = node.module.removeprefix(f"snakebot.diagnosis.{room}").split(".")
            if node.module == f"snakebot.diagnosis.{room}":
                found |= {alias.name for alias in node.names}
            elif node.module.startswith(f"snakebot.diagnosis.{room}."):
                found.add(inside[1])
    return found
