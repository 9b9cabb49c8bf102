"""The linter and the type checker see every script, those without an extension, too."""

from __future__ import annotations

import subprocess
import tomllib
from pathlib import Path

import pytest


def test_scripts_without_an_extension_are_linted_and_typed(root: Path) -> None:
    listed = subprocess.run(
        ["git", "ls-files", "tools"], cwd=root, capture_output=True, text=True, check=False
    )
    if listed.returncode:
        pytest.skip("not a git repository")
    files = [root / name for name in listed.stdout.split() if not Path(name).suffix]
    scripts = {
        path.relative_to(root).as_posix()
        for path in files
        if path.is_file() and path.read_bytes().startswith(b"#!/usr/bin/env python")
    }
    tool = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    assert scripts
    assert scripts == set(tool["ruff"]["extend-include"])
    assert scripts == {name for name in tool["mypy"]["files"] if name.startswith("tools/")}
