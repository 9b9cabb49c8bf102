"""CONTRIBUTING.md: its commands work, and what it names is there."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from snakebot.cli.main import cli

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
INDENTED = [line.split("#")[0].strip() for line in TEXT.splitlines() if line.startswith("    ")]
INLINE = re.findall(r"`((?:snakebot|python -m) [^`]+)`", TEXT)


def test_the_commands_are_those_that_one_needs() -> None:
    assert {"make run", "make test", "make lint", "make types", "make slow"} <= set(INDENTED)
    assert any("pytest" in command for command in INDENTED)
    assert len(INLINE) == 2


@pytest.mark.parametrize(
    "command",
    [pytest.param(c, marks=[pytest.mark.slow] if "pytest" in c else []) for c in INDENTED],
)
def test_a_command_is_understood(command: str) -> None:
    words = shlex.split(command)
    if words[0] == "make":
        words = ["make", "-n", *words[1:]]
    else:
        assert words[:3] == [".venv/bin/python", "-m", "pytest"]
        words = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider", *words[3:]]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-500:] + done.stderr
    assert "pytest" not in command or re.search(
        r"\d+(/\d+)? tests? collected|\d+/\d+ tests collected", done.stdout
    )


@pytest.mark.parametrize("command", INLINE)
def test_a_command_in_the_text_is_understood(command: str, tmp_path: Path) -> None:
    words = shlex.split(command)
    if words[0] == "snakebot":
        done = CliRunner().invoke(cli, [*words[1:], "--help"])
        assert done.exit_code == 0, done.output
        return
    assert words[-1] == "docs/effects"
    subprocess.run([sys.executable, *words[1:-1], str(tmp_path)], check=True, capture_output=True)


def test_what_the_page_names_is_there() -> None:
    named = re.findall(r"\]\(([^)#]+)\)", TEXT)
    named += re.findall(r"`((?:snakebot|firmware_protocol|tests|tools|\.ci)(?:/[\w./-]+)?)`", TEXT)
    assert len(named) > 30
    assert [name for name in named if not (ROOT / name).exists()] == []


ORDER = re.findall(r"`snakebot/(\w+)[^`]*`", TEXT.split("## Where what lives")[1].split("## Add")[0])


def test_the_table_names_every_folder_of_the_package() -> None:
    folders = {path.parent.name for path in (ROOT / "snakebot").glob("*/__init__.py")}
    assert folders <= set(ORDER), folders - set(ORDER)


def test_a_folder_imports_only_folders_that_stand_above_it_in_the_table() -> None:
    for place, name in enumerate(ORDER):
        path = ROOT / "snakebot" / name
        sources = list(path.rglob("*.py")) if path.is_dir() else [path.with_suffix(".py")]
        assert sources, name
        for source in sources:
            used = re.findall(
                r"^\s*(?:from|import) snakebot\.(\w+)", source.read_text(encoding="utf-8"), re.M
            )
            below = set(used) & set(ORDER[place + 1 :])
            assert not below, f"{source.relative_to(ROOT)} imports {below}"
