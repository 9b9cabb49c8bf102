"""docs/blind-check.md names scripts and options that are there; ``test_blind_reduced`` runs the same commands."""

import re
import subprocess
import sys
from pathlib import Path


def test_commands_of_the_page_exist(root: Path) -> None:
    text = (root / "docs" / "blind-check.md").read_text(encoding="utf-8")
    commands = [line.split("#")[0].split() for line in text.splitlines() if line.startswith("    ")]
    assert {words[0] for words in commands} >= {
        "make",
        "tools/blind/make",
        "tools/blind/answer",
        "tools/blind/experiment",
        "tools/blind/baseline",
        "tools/blind/fit_all",
        "tools/blind/score",
    }
    helps: dict[str, str] = {}
    for script, *words in commands:
        if script == "make":
            plan = subprocess.run(["make", "-n", *words], cwd=root, capture_output=True, text=True)
            assert plan.returncode == 0
            assert "tools/blind/score" in plan.stdout
            continue
        if script not in helps:
            done = subprocess.run(
                [sys.executable, str(root / script), "--help"], capture_output=True, text=True, check=True
            )
            helps[script] = done.stdout
        for word in words:
            if word.startswith("--"):
                assert re.search(rf"{word}\b", helps[script]), f"{script} {word}"


def test_sizes_and_shares_are_those_of_the_code(root: Path) -> None:
    from blind.cases import DURATION_S, GAITS, RATE_HZ, SETS, STRATA, STRATA_TO_SCORE
    from blind.robot import MOST_OFF
    from blind.scores import PLAIN

    text = (root / "docs" / "blind-check.md").read_text(encoding="utf-8")
    assert (GAITS, DURATION_S, RATE_HZ) == (5, 10.0, 100.0)
    assert "five gaits of 10 s at 100 Hz" in text
    assert SETS["score"][1] == (1.5, 3.0, 10.0)
    assert "1.5, 3 or 10" in text
    assert STRATA_TO_SCORE == {"no_gap": 0.34, "unknown": 0.1, "pair": 0.1, "left_out": 0.1}
    assert STRATA == {**STRATA_TO_SCORE, "no_gap": 0.3}
    assert f"{PLAIN} floors" in text
    for key, most in MOST_OFF.items():
        assert {"mass": "mass by up to 3 %", "friction": "coefficient by up to 5 %", "lag": "by up to 5 %"}[
            key
        ] in text
        assert most == {"mass": 0.03, "friction": 0.05, "lag": 0.05}[key]
