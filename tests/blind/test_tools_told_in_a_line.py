"""The tools of the blind check, given what they cannot use: one line that says what is wrong, and status 2."""

from __future__ import annotations

from pathlib import Path

import pytest
from tool_calls import called

MAKE = ("--seed", "100", "--cases", "1")


@pytest.fixture
def there(tmp_path: Path) -> Path:
    """A set that was begun and not finished, one whose plan was cut, a file in place of a folder, odd answers."""
    for name in ("begun", "cut"):
        (tmp_path / name / "cases").mkdir(parents=True)
    (tmp_path / "cut" / "plan.json").write_text("{")
    (tmp_path / "whole" / "cases").mkdir(parents=True)
    (tmp_path / "whole" / "plan.json").write_text("{}")
    (tmp_path / "file").write_text("nothing")
    (tmp_path / "odd.json").write_text("{}")
    return tmp_path


@pytest.mark.parametrize(
    ("tool", "words", "told"),
    [
        ("blind/make", [*MAKE, "--jobs", "0", "x"], "--jobs: 0: at least one"),
        ("blind/make", [*MAKE, "file"], "file: not a folder"),
        ("blind_wheels/make_wheels", [*MAKE, "--jobs", "0", "x"], "--jobs: 0: at least one"),
        ("blind/answer", ["begun", "x"], "begun: no plan.json"),
        ("blind/answer", ["cut", "x"], "cut: no plan.json"),
        ("blind/answer", ["whole", "file"], "file: not a folder"),
        ("blind/answer", ["whole", "x", "--jobs", "none"], "--jobs: none: not a whole number"),
        ("blind/answer", ["whole", "x", "--limit", "-1"], "--limit: -1: at least one"),
        ("blind/answer", ["whole", "x", "--timeout", "nan"], "--timeout: nan: not a time above zero"),
        ("oracle", ["whole", "x", "--timeout", "0"], "--timeout: 0: not a time above zero"),
        ("same_answers", ["HEAD", "--cases", "begun", "--out", "x"], "begun: no plan.json"),
        ("same_answers", ["HEAD", "--cases", "whole", "--limit", "0"], "--limit: 0: at least one"),
        ("blind/fit_all", ["whole", "begun"], "whole: no case in it"),
        ("blind/score", ["begun", "file"], ".key: not found"),
        ("invariants.py", ["nowhere.json"], "nowhere.json: cannot be read: No such file"),
        ("invariants.py", ["file"], "file: cannot be read"),
        ("invariants.py", ["odd.json"], "odd.json: not an answer of snakebot diagnose"),
        ("baseline_real", ["begun", "--answer", "odd.json"], "odd.json: has no closure.by_joint"),
        ("baseline_real", ["begun", "--answer", "file"], "file: cannot be read"),
    ],
)
def test_what_cannot_be_used_is_told_in_a_line(
    root: Path, there: Path, monkeypatch: pytest.MonkeyPatch, tool: str, words: list[str], told: str
) -> None:
    monkeypatch.chdir(there)
    done = called(root / "tools" / tool, *words)
    assert done.returncode == 2
    assert told in done.stderr.splitlines()[-1]
    assert not (there / "x").exists()
