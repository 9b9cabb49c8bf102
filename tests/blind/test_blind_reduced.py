"""Thirty sealed cases, made, answered, experimented on and scored by the commands of docs/blind-check.md.

The limits are far below what was measured when they were set, so that chance does not break them, and far above what a
diagnosis scores that has lost a stage, an effect of the ground, or its noise floor. The sizes (3.6 to 8 floors) and
seeds are those of a set of its own, used for nothing else.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

CASES = 30
LEAST = {"named": 0.6, "stage": 0.6, "joints": 0.5, "closure": 0.8}
MOST = {"false_alarms": 0.35, "wrongly": 0.35, "brier": 0.4}


def call(root: Path, script: str, *options: str) -> str:
    words = [sys.executable, str(root / "tools" / "blind" / script), *options]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_reduced_set(root: Path, tmp_path: Path) -> None:
    cases, answers = tmp_path / "set", tmp_path / "answers"
    made = call(root, "make", "--seed", "1", "--set", "reduced", "--cases", str(CASES), str(cases))
    assert "SHA-256 of the seal" in made
    call(root, "answer", str(cases), str(answers), "--limit", "2")
    call(root, "answer", str(cases), str(answers))  # goes on
    tried = [json.loads(line) for line in (answers / "answers.jsonl").read_text().splitlines()]
    assert len(tried) == len({t["token"] for t in tried}) == CASES
    assert [t for t in tried if t["status"] != 0] == []
    call(root, "experiment", str(cases), str(answers), "--limit", "1", "--rounds", "1", "--control", "0")
    said = call(
        root,
        "score",
        str(answers),
        str(cases / "labels.sealed"),
        "--oracle",
        str(cases),
        "--oracle-cases",
        "2",
    )
    assert "95 % interval" in said
    scores = json.loads((answers / "scores.json").read_text())
    found: dict[str, Any] = {figure["key"]: figure["value"] for figure in scores["figures"]}
    for picture in ("confusion.png", "reliability.png", "power.png"):
        assert (answers / picture).stat().st_size > 5000
    assert {key: found[key] for key in LEAST if found[key] < LEAST[key]} == {}, said
    assert {key: found[key] for key in MOST if found[key] > MOST[key]} == {}, said
