"""Calibrating: how well the present rule did, on sets of its own kind alone; kept where that is asked for."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from tool_calls import called

from snakebot.diagnosis.verdict.probability import CALIBRATION_FILE, CauseFeatures, calibration, probability

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

FEATURES = CauseFeatures(
    lead=0.4, rest=0.5, closed=0.97, share=1.0, motions=5, explained=True, own=False, worn=False, together=1
)


def cause(effect: str, told: float) -> dict[str, Any]:
    evidence = {name: float(getattr(FEATURES, name)) for name in vars(FEATURES)}
    return {"effect": effect, "indistinguishable_from": [], "probability": told, "evidence": evidence}


def made(root: Path, out: Path, kind: str) -> Path:
    done = called(
        root / "tools" / "blind" / "make",
        "--seed", "9", "--set", kind, "--cases", "10", "--only", "3", "9", "--jobs", "1", str(out),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return out


def answered(folder: Path, *causes: dict[str, Any]) -> Path:
    out = folder.with_name(f"{folder.name}.answers")
    out.mkdir()
    for case in os.listdir(folder / "cases"):
        (out / f"{case}.json").write_text(json.dumps({"causes": causes}))
    return out


def test_the_present_rule_is_told_and_kept(root: Path, tmp_path: Path) -> None:
    folder = made(root, tmp_path / "set", "calibrate")
    answers = answered(folder, cause("no_such_effect", 0.2), cause("no_other_effect", 0.1))
    before = CALIBRATION_FILE.read_bytes()
    done = called(root / "tools" / "blind" / "calibrate", "--keep", str(folder), str(answers))
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("2 answers, 4 causes, as answered: calibration error 0.150")
    assert done.stdout.rstrip().endswith("Brier score 0.025")
    assert CALIBRATION_FILE.read_bytes() == before


def test_worn_robots_and_robots_with_faults_are_told_apart(root: Path, tmp_path: Path) -> None:
    sets = []
    for kind, told in (("calibrate", 0.2), ("worn_calibrate", 0.1)):
        folder = made(root, tmp_path / kind, kind)
        sets += [str(folder), str(answered(folder, cause("no_such_effect", told)))]
    done = called(root / "tools" / "blind" / "calibrate", "--keep", *sets)
    assert done.returncode == 0, done.stderr
    lines = [line.split(":") for line in done.stdout.splitlines()]
    assert [line[0].strip() for line in lines] == [
        "4 answers, 4 causes, as answered", "calibrate, 2 causes", "worn_calibrate, 2 causes",
    ]  # fmt: skip
    assert [line[1].split(",")[0] for line in lines[1:]] == [
        " calibration error 0.200",
        " calibration error 0.100",
    ]


def test_a_rule_is_fitted_to_the_causes_that_it_gave_a_probability(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = made(root, tmp_path / "set", "calibrate")
    told = round(probability(FEATURES), 3)
    answers = answered(folder, cause("no_such_effect", told), cause("no_other_effect", told / 2))
    written: list[Any] = []
    monkeypatch.setattr("calibration.write", lambda *given: written.append(given))
    for carried_on in ((), ("--carry-on",)):
        done = called(root / "tools" / "blind" / "calibrate", *carried_on, str(folder), str(answers))
        assert done.returncode == 0, done.stderr
    (command, seeds, cases, evidence, right, present), (*_, carried) = written
    assert (present, carried) == (None, calibration())
    assert "tools/blind/calibrate IN1 OUT1" in command
    assert (seeds, cases, right) == ([200_000_009], 2, [False, False])  # one of each two was given less
    assert [found.closed for found in evidence] == [0.97, 0.97]


def test_other_sets_calibrate_nothing(root: Path, tmp_path: Path) -> None:
    folder = made(root, tmp_path / "set", "tune")
    tool = root / "tools" / "blind" / "calibrate"
    for words in ((str(folder), str(answered(folder))), (str(folder),)):
        done = called(tool, "--keep", *words)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
