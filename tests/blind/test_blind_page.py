"""docs/blind-check*.md name scripts and options that are there; ``test_blind_reduced`` runs the same commands."""

import re
import subprocess
from pathlib import Path

import pytest
from tool_calls import called

FIRST = ("make", "answer", "experiment", "baseline", "fit_all", "score")


@pytest.mark.parametrize(
    ("page", "scripts"),
    [
        ("blind-check.md", [f"tools/blind/{name}" for name in FIRST]),
        (
            "blind-check-wheels.md",
            [f"tools/blind_wheels/{n}" for n in ("make_wheels", "score_wheels", "misfit")],
        ),
    ],
)
def test_commands_of_the_page_exist(root: Path, page: str, scripts: list[str]) -> None:
    text = (root / "docs" / page).read_text(encoding="utf-8")
    commands = [line.split("#")[0].split() for line in text.splitlines() if line.startswith("    ")]
    assert {words[0] for words in commands} >= {"make", *scripts}
    helps: dict[str, str] = {}
    for script, *words in commands:
        if script == "make":
            plan = subprocess.run(["make", "-n", *words], cwd=root, capture_output=True, text=True)
            assert plan.returncode == 0
            wheels = "blind-wheels" in words
            assert ("tools/blind_wheels/score_wheels" if wheels else "tools/blind/score") in plan.stdout
            continue
        if script not in helps:
            done = called(root / script, "--help")
            done.check_returncode()
            helps[script] = done.stdout
        for word in words:
            if word.startswith("--"):
                assert re.search(rf"{word}\b", helps[script]), f"{script} {word}"


def test_sizes_and_shares_are_those_of_the_code(root: Path) -> None:
    from blind.cases import (
        JOINTS_FROM_TO,
        LAGS_S,
        RATES_HZ,
        SETS,
        STRATA,
        STRATA_TO_SCORE,
    )
    from blind.records import AS_FIRST, DURATIONS_S, MOTIONS_FROM_TO, SPEED_ALONE, Records
    from blind.robot import TOLERANCE
    from blind.scores import PLAIN

    text = (root / "docs" / "blind-check.md").read_text(encoding="utf-8")
    assert (Records(), set(RATES_HZ)) == (Records(5, 10.0, pose=True), {50.0, 100.0, 200.0})
    assert "five motions of 10 s at 50, 100 or 200 Hz" in text
    assert (AS_FIRST, MOTIONS_FROM_TO, DURATIONS_S, SPEED_ALONE) == (0.5, (3, 8), (6.0, 20.0), 0.2)
    assert "3 to 8 motions of 6 to 20 s" in text
    assert JOINTS_FROM_TO == (3, 12)
    assert "3 to 12 joints" in text
    assert LAGS_S == (0.015, 0.08)
    assert "15 to 80 ms" in text
    assert SETS["score"][1] == (1.5, 3.0, 10.0)
    assert "1.5, 3 or 10" in text
    assert STRATA_TO_SCORE == {"no_gap": 0.34, "unknown": 0.1, "pair": 0.1, "left_out": 0.1}
    assert STRATA == {**STRATA_TO_SCORE, "no_gap": 0.3}
    assert f"{PLAIN} floors" in text
    words = {"mass": "mass 3 %", "friction": "coefficient 5 %", "lag": "lag 6 %", "wire": "the wire 1 ms"}
    assert TOLERANCE == {"mass": 0.03, "friction": 0.05, "lag": 0.06, "wire": 0.001}
    assert all(word in text for word in words.values())
