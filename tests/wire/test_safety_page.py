"""docs/safety.md names tests and tools that exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from tool_calls import called

ROOT = Path(__file__).parents[2]


TEXT = (ROOT / "docs" / "safety.md").read_text(encoding="utf-8")
TESTS = {path.name: path for path in (ROOT / "tests").rglob("test_*.py")}


def guarantees() -> list[list[str]]:
    """The rows of the table of guarantees, as cells."""
    table = TEXT.partition("## Guaranteed")[2].partition("\n## ")[0]
    rows = [line.strip("|").split(" | ") for line in table.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in row] for row in rows[1:]]


def test_every_guarantee_has_a_mechanism_and_a_test_that_exists() -> None:
    rows = guarantees()
    assert len(rows) >= 12
    for row in rows:
        assert len(row) == 4, row
        whatever, holds, mechanism, shown = row
        assert all((whatever, holds, mechanism)), row
        named = re.findall(r"`(test_\w+\.py)`", shown)
        assert named, f"no test shows: {holds}"
        for name in named:
            assert name in TESTS, name
            assert re.search(
                r"^def test_|^    def test_", TESTS[name].read_text(encoding="utf-8"), re.MULTILINE
            )


def commands() -> list[str]:
    return sorted(set(re.findall(r"`(tools/\w+(?:\.py)?(?: [^`]*)?)`", TEXT)))


def test_the_page_names_tools() -> None:
    assert len(commands()) >= 5


@pytest.mark.parametrize("command", commands())
def test_every_tool_on_the_page_exists_and_knows_its_options(command: str) -> None:
    tool, *words = command.split()
    assert (ROOT / tool).exists()
    if not words:
        return
    done = called(ROOT / tool, *([words[0]] if words[0].isalpha() else []), "--help")
    assert done.returncode == 0, done.stderr
    told = done.stdout
    if tool.endswith("bad_wire_run.py"):  # it hands on what is the proxy's
        proxy = called(ROOT / "tools" / "bad_wire.py", "proxy", "--help")
        assert proxy.returncode == 0, proxy.stderr
        told += proxy.stdout
    for word in words:
        assert not word.startswith("--") or word in told, word


def test_every_test_file_that_is_named_with_its_path_exists() -> None:
    paths = re.findall(r"tests/[\w/]+\.py", TEXT)
    assert paths
    assert all((ROOT / path).exists() for path in paths)
