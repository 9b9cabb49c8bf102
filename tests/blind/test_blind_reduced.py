"""A handful of sealed cases, made, answered and scored by the commands: the machinery works from end to end.

What the diagnosis scores is not asserted here: on so few cases that would be a guess. docs/blind-check.md has scores.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

NUMBERS = [0, 6, 20, 32, 47, 62]  # of 100: no gap, unknown, pair, left out, and single effects


def call(root: Path, script: str, *options: str) -> str:
    words = [sys.executable, str(root / "tools" / "blind" / script), *options]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_reduced_set(root: Path, tmp_path: Path) -> None:
    cases, answers = tmp_path / "set", tmp_path / "answers"
    numbers = [str(n) for n in NUMBERS]
    call(root, "make", "--only", *numbers, "--seed", "3", "--set", "tune", "--cases", "100", str(cases))
    call(root, "answer", str(cases), str(answers), "--quick", "--limit", "2")
    call(root, "answer", str(cases), str(answers), "--quick")  # goes on
    tried = [json.loads(line) for line in (answers / "answers.jsonl").read_text().splitlines()]
    assert len(tried) == len({t["token"] for t in tried}) == len(set(NUMBERS))
    assert [t for t in tried if t["status"] != 0] == []
    said = call(root, "score", str(answers), str(cases / "labels.sealed"))
    assert "95 % interval" in said
    scores = json.loads((answers / "scores.json").read_text())
    found: dict[str, Any] = {figure["key"]: figure for figure in scores["figures"]}
    for picture in ("confusion.png", "reliability.png", "power.png"):
        assert (answers / picture).stat().st_size > 5000
    for key in ("named", "stage", "joints", "false_alarms", "closure", "brier"):
        assert key in found
