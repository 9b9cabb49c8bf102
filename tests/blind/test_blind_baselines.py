"""Baselines on made-up answers: what each picks, and who beats whom."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from blind.baselines import baseline_answers, compare, picked, table
from blind.cases import make_case
from blind.faults import FAULTS
from blind.robot import real_robot
from blind.session_files import write_session
from tool_calls import called

# n = 1000: each parameter must lower the cost by 1 (AIC) or 3.45 (BIC)
FITS = [
    {"effects": [], "joints": [], "parameters": 0, "cost": 103.0, "samples": 1000},
    {"effects": ["servo_lag"], "joints": [1], "parameters": 1, "cost": 100.5, "samples": 1000},
    {"effects": ["second_order"], "joints": [1], "parameters": 2, "cost": 100.0, "samples": 1000},
]


def answer(effect: str | None) -> Any:
    causes: list[dict[str, Any]] = [
        {"effect": effect, "probability": 0.9, "indistinguishable_from": [], "parameters": {}}
    ]
    return {
        "verdict": "explained" if effect else "no_gap",
        "causes": causes if effect else [],
        "details": {"fits": FITS},
    }


def label(name: str | None) -> Any:
    effects = [{"name": name, "stage": "servo", "joints": [1], "values": {}, "size": 3.0}] if name else []
    return {"stratum": "single" if name else "no_gap", "asked_size": 3.0, "effects": effects}


def test_criteria_differ_in_what_a_parameter_costs() -> None:
    assert picked(answer(None), "error") == ["second_order"]
    assert picked(answer(None), "aic") == ["servo_lag"]
    assert picked(answer(None), "bic") == []
    assert picked(None, "bic") is None
    assert picked({"causes": []}, "bic") is None  # an answer without fits


def test_paired_comparison_says_who_is_better_or_that_nobody_knows(tmp_path: Path) -> None:
    pairs = [(label("servo_lag"), answer("servo_lag"))] * 20
    tokens = [str(i) for i in range(20)]
    (tmp_path / "forest.json").write_text(json.dumps({t: ["servo_lag"] for t in tokens}))
    rows = compare(pairs, baseline_answers(tmp_path, tokens, pairs))
    named = {r.baseline: r for r in rows if r.metric.endswith("group counts")}
    assert named["error"].beaten is True
    assert named["aic"].beaten is None  # both always right: not shown to be beaten
    assert named["forest"].beaten is None
    text = "\n".join(table(rows))
    assert "NOT SHOWN TO BE BEATEN" in text
    assert (
        "every effect fitted at once  not run" in " ".join(text.replace("\n", " ").split())
        or "not run" in text
    )
    worse = compare([(label("servo_lag"), answer("deadband"))] * 20, {"aic": [["servo_lag"]] * 20})
    assert worse[0].beaten is False
    assert "BETTER THAN THE DIAGNOSIS" in "\n".join(table(worse))


def test_a_baseline_that_never_calls_no_gap_is_beaten_there() -> None:
    rows = compare([(label(None), answer(None))] * 10, {"error": [["second_order"]] * 10})
    quiet = next(r for r in rows if r.metric.startswith("no gap"))
    assert (quiet.value, quiet.diagnosis, quiet.beaten) == (0.0, 1.0, True)


@pytest.mark.slow
def test_fit_all_names_a_plain_effect(root: Path, tmp_path: Path) -> None:
    case = make_case("tune", 5, 6, 40)
    p = real_robot(np.random.default_rng(1), case.build)
    FAULTS["rate_limit"].apply(p, np.array([2]), 2.0, np.random.default_rng(0))
    (tmp_path / "set" / "cases").mkdir(parents=True)
    (tmp_path / "answers").mkdir()
    write_session(tmp_path / "set" / "cases" / "a", replace(case, parameters=p, exclude=None))
    words = [
        sys.executable,
        str(root / "tools/blind/fit_all"),
        str(tmp_path / "set"),
        str(tmp_path / "answers"),
    ]
    done = subprocess.run([*words, "--jobs", "1"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-1500:]
    assert json.loads((tmp_path / "answers" / "fit_all.json").read_text())["a"][0] == "rate_limit"


@pytest.mark.parametrize("script", ["fit_all", "baseline", "experiment", "answer", "score"])
def test_folders_that_are_not_there_are_told_in_a_line(root: Path, tmp_path: Path, script: str) -> None:
    gone = str(tmp_path / "gone")
    words = {"baseline": [gone, "--answer", gone, gone]}.get(script, [gone, gone])
    done = called(root / "tools/blind" / script, *words)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert gone in done.stderr


def test_the_forest_does_not_learn_from_the_set_for_scoring(root: Path, tmp_path: Path) -> None:
    from blind.seal import seal

    (tmp_path / "set" / "cases").mkdir(parents=True)
    (tmp_path / "answers").mkdir()
    seal({"made": {"set": "score"}, "cases": {}}, tmp_path / "set" / "labels.sealed", tmp_path / "set.key")
    made, answers = str(tmp_path / "set"), str(tmp_path / "answers")
    done = called(root / "tools/blind/baseline", made, "--answer", made, answers)
    assert done.returncode == 2
    assert "nobody learns from that" in done.stderr
