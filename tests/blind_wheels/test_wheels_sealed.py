"""The set of the robot on wheels gives nothing away but its signals, and asks nothing of the product."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from blind.cases import PER_SET as FIRST_PER_SET
from blind.cases import SETS as FIRST_SETS
from blind.seal import digest, unseal
from blind.session_files import STAMP_S
from blind_wheels.cases import DURATION_S, HEALTHY, PER_SET, ROUND, SETS, fault_of, make_case
from blind_wheels.faults import FAULTS
from blind_wheels.lab import Description
from blind_wheels.misfits import FIRST_SEED
from blind_wheels.robot import LINKS_FROM_TO


def is_python(path: Path) -> bool:
    return path.is_file() and (path.suffix == ".py" or path.read_bytes().startswith(b"#!/usr/bin/env python"))


def test_the_robot_on_wheels_imports_nothing_of_the_product(root: Path) -> None:
    files = [f for f in (root / "tools" / "blind_wheels").iterdir() if is_python(f)]
    assert {"make_wheels", "score_wheels", "misfit", "body.py", "drive.py"} <= {f.name for f in files}
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            assert not [n for n in names if n.split(".")[0] in ("snakebot", "firmware_protocol")], file


def test_nothing_of_the_product_is_loaded_behind_the_scenes(root: Path) -> None:
    code = (
        f"import sys; sys.path.insert(0, {str(root / 'tools')!r})\n"
        "import blind_wheels.cases, blind_wheels.scores, blind_wheels.misfits\n"
        "import blind.making, blind.session_files, blind.traces, blind.pictures\n"
        "print([m for m in sys.modules if m.split('.')[0] in ('snakebot', 'firmware_protocol')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_honest_answers_are_names_of_the_library() -> None:
    from snakebot.effects import effects

    for name, fault in FAULTS.items():
        assert fault.names <= set(effects()), name
        assert fault.names or fault.open, name
        assert {effects()[n].stage for n in fault.names} <= fault.stages, name
        assert fault.why
    assert len(FAULTS) == 11


def test_seeds_of_no_two_sets_meet() -> None:
    firsts = sorted([first for first, _ in (*SETS.values(), *FIRST_SETS.values())] + [FIRST_SEED])
    assert all(b - a >= max(PER_SET, FIRST_PER_SET) for a, b in pairwise(firsts))
    sizes = [size for _, drawn in SETS.values() for size in drawn]
    assert len(set(sizes)) == len(sizes)


def test_a_round_meets_every_fault_and_healthy_robots() -> None:
    met = [fault_of(n) for n in range(ROUND)]
    assert set(met) == {*FAULTS, None}
    assert met.count(None) == HEALTHY
    with pytest.raises(ValueError, match="--seed"):
        make_case("tune", -1, 0)


@pytest.fixture(scope="module")
def made(root: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    out = tmp_path_factory.mktemp("wheels") / "set"
    words = [sys.executable, str(root / "tools" / "blind_wheels" / "make_wheels"), "--seed", "7", "--set", "tune",
             "--cases", "14", "--only", "8", "11", "--jobs", "2", str(out)]  # fmt: skip
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    again = subprocess.run(words, capture_output=True, text=True)
    assert "nothing to do" in again.stdout
    return out, done.stdout


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_folders_are_alike_and_sessions(made: tuple[Path, str]) -> None:
    from snakebot.runlog import read_session

    folders = sorted((made[0] / "cases").iterdir())
    assert len(folders) == 2
    assert all(re.fullmatch("[0-9a-f]{12}", f.name) for f in folders)
    assert len({tuple(sorted(f.name for f in folder.iterdir())) for folder in folders}) == 1
    for folder in folders:
        assert {f.stat().st_mtime for f in (folder, *folder.iterdir())} == {STAMP_S}
        runs = sorted(folder.glob("run_*.csv"))
        assert len({run.stat().st_size for run in runs}) == 1
        told = yaml.safe_load((folder / "session.yaml").read_text())
        assert set(told) == {"robot", "runs"}
        assert set(told["robot"]) == {
            "links", "half_length_m", "link_mass_kg", "friction", "servo", "encoder_counts_per_rev",
        }  # fmt: skip
        assert set().union(*told["runs"]) <= {"file", "gait", "repeat_of"}
        session = read_session(folder)
        assert session.warnings == ()
        assert session.runs[-1].repeat_of == session.runs[0].name
        assert session.runs[0].t_s[-1] < DURATION_S


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_labels_are_under_seal_and_nowhere_else(made: tuple[Path, str]) -> None:
    out, said = made
    assert digest(out / "labels.sealed") in said
    labels = unseal(out / "labels.sealed", out.with_name("set.key"))
    assert set(labels["cases"]) == {f.name for f in (out / "cases").iterdir()}
    assert sorted(str(label["fault"]) for label in labels["cases"].values()) == ["None", "magnet_off_centre"]
    everything = b"".join(f.read_bytes() for f in out.rglob("*") if f.is_file())
    assert b"magnet" not in everything
    assert not list(out.parent.glob("*.jsonl"))


@pytest.mark.slow
def test_same_seed_same_signals() -> None:
    first, second = (make_case("tune", 5, 11) for _ in range(2))
    assert first.label == second.label
    assert first.about == second.about
    runs = zip(first.runs(), second.runs(), strict=True)
    assert all(np.array_equal(a.encoder_rad, b.encoder_rad) for a, b in runs)


def answer(verdict: str, *causes: tuple[str, float], stage: str = "servo") -> dict[str, Any]:
    return {
        "verdict": verdict,
        "where": {"stage": stage, "joints": [2]},
        "causes": [
            {"effect": e, "probability": p, "indistinguishable_from": [], "parameters": {}} for e, p in causes
        ],
    }


def label(fault: str | None, size: float = 5.0, **values: float) -> dict[str, Any]:
    return {"fault": fault, "size": size, "joints": [2] if fault else None, "values": values}


@pytest.mark.parametrize("links", range(LINKS_FROM_TO[0], LINKS_FROM_TO[1] + 1))
def test_a_description_is_read_as_it_was_meant(links: int) -> None:
    from snakebot.robot import robot_from_mapping

    about = Description(links, 0.06, 0.3, 0.2, 0.4, 0.1, 2.5, 0.03)
    robot = robot_from_mapping(yaml.safe_load("\n".join(about.lines))["robot"], "here")
    assert robot.joints == links - 1


def test_what_counts_is_what_the_table_says() -> None:
    from blind_wheels.scores import accused, figures, honest, named, told

    horn, tooth = label("loose_horn", width_deg=2.0), label("worn_tooth")
    assert named(horn, answer("explained", ("backlash", 0.9)))
    assert not honest(horn, answer("unexplained"))  # the library holds it
    assert honest(tooth, answer("unexplained"))
    assert not honest(tooth, answer("unexplained", stage="body"))
    assert accused(tooth, answer("partly", ("rate_limit", 0.6)))
    assert not accused(tooth, answer("partly", ("rate_limit", 0.4)))
    assert accused(label(None), answer("explained", ("servo_lag", 0.6)))
    assert told(label(None, 0.0), answer("no_gap", stage="none"))["worth"] == "right"
    sure = answer("explained", ("backlash", 0.9))
    sure["causes"][0]["parameters"] = {"width_deg": {"estimate": 2.1, "ci95": [1.9, 2.3]}}
    table = {
        f.key: f
        for f in figures([(horn, sure), (tooth, None), (label(None, 0.0), answer("no_gap", stage="none"))])
    }
    assert (table["honest"].value, table["honest"].cases) == (0.5, 2)
    assert table["coverage"].value == 1.0
    assert table["healthy"].value == 0.0
    assert table["brier"].value == pytest.approx(0.01)
