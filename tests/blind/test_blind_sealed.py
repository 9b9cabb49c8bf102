"""Nothing but the signals may give a label away, and nobody reads the labels by accident."""

import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from blind.cases import DURATION_S, RATE_HZ, SETS, make_case, plan, shares_of
from blind.seal import SealError, digest, unseal
from blind.session_files import STAMP_S, write_session

pytestmark = pytest.mark.timeout(900)  # a busy machine


def make(root: Path, out: Path, *options: str) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, str(root / "tools" / "blind" / "make"), *options, str(out)]
    return subprocess.run(words, capture_output=True, text=True)


@pytest.fixture(scope="module")
def made(root: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    out = tmp_path_factory.mktemp("blind") / "set"
    options = ("--seed", "7", "--set", "tune", "--cases", "40", "--jobs", "1")
    done = make(root, out, "--only", "0", "13", "25", *options)
    assert done.returncode == 0, done.stderr
    again = make(root, out, *options)
    assert "nothing to do" in again.stdout
    return out, done.stdout


def test_folders_are_alike_in_all_but_the_numbers(made: tuple[Path, str]) -> None:
    folders = sorted((made[0] / "cases").iterdir())
    assert len(folders) == 3
    assert all(re.fullmatch("[0-9a-f]{12}", f.name) for f in folders)
    seen = {
        tuple(
            (f.name, f.stat().st_size, f.stat().st_mtime, f.stat().st_mode) for f in sorted(folder.iterdir())
        )
        for folder in folders
    }
    assert len(seen) == 1
    assert {f.stat().st_mtime for f in folders} == {STAMP_S}
    text = {re.sub(r"\d{3}\.\d{6}|\d\.\d{6}", "#", (f / "session.yaml").read_text()) for f in folders}
    assert len(text) == 1


def test_folders_are_sessions(made: tuple[Path, str]) -> None:
    from snakebot.runlog import read_session

    for folder in (made[0] / "cases").iterdir():
        session = read_session(folder)
        assert session.warnings == ()
        assert len(session.runs) == 6
        assert session.runs[-1].repeat_of == session.runs[0].name
        assert session.runs[0].t_s.size == DURATION_S * RATE_HZ


def test_the_seal_needs_its_key_and_shows_tampering(made: tuple[Path, str], tmp_path: Path) -> None:
    out, said = made
    sealed, key = out / "labels.sealed", out.with_name("set.key")
    assert digest(sealed) in said
    assert digest(sealed) in (out / "seal.txt").read_text()
    labels = unseal(sealed, key)
    assert set(labels["cases"]) == {f.name for f in (out / "cases").iterdir()}
    assert [label["stratum"] for label in labels["cases"].values()].count("no_gap") == 1
    assert not list(out.rglob("*.key"))
    assert not list(out.parent.glob("*.jsonl"))
    assert key.stat().st_mode & 0o077 == 0
    everything = b"".join(f.read_bytes() for f in out.rglob("*") if f.is_file() and f.name != "plan.json")
    for effect in (e for label in labels["cases"].values() for e in label["effects"]):
        assert effect["name"].encode() not in everything
    broken = tmp_path / "broken"
    text = bytearray(sealed.read_bytes())
    text[1000] ^= 1
    broken.write_bytes(bytes(text))
    with pytest.raises(SealError, match="does not open it"):
        unseal(broken, key)


def test_same_seed_same_signals() -> None:
    first, second = (make_case("tune", 5, 0, 40) for _ in range(2))
    assert first.label == second.label
    runs = zip(first.runs(), second.runs(), strict=True)
    assert all(np.array_equal(a.encoder_rad, b.encoder_rad) for a, b in runs)


def test_sets_share_neither_seeds_nor_sizes() -> None:
    firsts = sorted(first for first, _ in SETS.values())
    assert all(b - a >= 1_000_000 for a, b in pairwise(firsts))
    assert SETS["score"][1] == (1.5, 3.0, 10.0)
    spans = [(0.97 * s, 1.03 * s) for _, sizes in SETS.values() for s in sizes]
    spans.sort()
    assert all(a[1] < b[0] for a, b in pairwise(spans))


def test_every_effect_and_stratum_is_met_in_a_full_set() -> None:
    from blind.faults import KNOWN, UNKNOWN

    planned = [plan(n, 300, np.random.default_rng(n), shares_of("score")) for n in range(300)]
    assert {name for stratum, names in planned for name in names if stratum == "single"} == set(KNOWN)
    assert {name for stratum, names in planned for name in names if stratum == "unknown"} == set(UNKNOWN)
    assert {name for stratum, names in planned for name in names if stratum == "left_out"} == set(KNOWN)
    assert all(len(set(names)) == 2 for stratum, names in planned if stratum == "pair")


def test_bad_options_are_told_in_a_line(root: Path, tmp_path: Path) -> None:
    for options in (("--seed", "-1"), ("--seed", "1", "--cases", "0"), ("--seed", "1", "--set", "nonsense")):
        done = make(root, tmp_path / "x", *options)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "x").exists()


def outward(folder: Path) -> list[float]:
    """Everything about a folder but its signals, as numbers."""
    token = [int(c, 16) for c in folder.name]
    files = sorted(folder.iterdir())
    stats = [v for f in files for v in (f.stat().st_size, f.stat().st_mtime, len(f.name))]
    text = (folder / "session.yaml").read_text()
    return [*token, *stats, *(float(n) for n in re.findall(r"\d+\.\d+", text))]


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_classifier_without_the_signals_does_no_better_than_chance(tmp_path: Path) -> None:
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.model_selection import StratifiedKFold, permutation_test_score

    rows: list[list[float]] = []
    kinds: list[str] = []
    tokens = np.random.default_rng(0).permutation(4000)
    for number in range(60):
        case = make_case("tune", 11, number, 60)
        folder = tmp_path / f"{tokens[number]:012x}"
        write_session(folder, case)
        rows.append(outward(folder))
        kinds.append(case.label.effects[0].stage if case.label.effects else "none")
    counts: dict[str, int] = {k: kinds.count(k) for k in kinds}
    keep = [i for i, k in enumerate(kinds) if counts[k] >= 5]
    x, y = np.array(rows)[keep], np.array(kinds)[keep]
    score, chance, p = permutation_test_score(
        RandomForestClassifier(60, random_state=0), x, y, cv=StratifiedKFold(5), n_permutations=60, random_state=0,
        scoring="balanced_accuracy",
    )  # fmt: skip
    assert p > 0.02, f"balanced accuracy {score:.2f} against {np.mean(chance):.2f} by chance"
    # the same classifier does see a leak where there is one
    leaky = np.column_stack([x, [sorted(set(kinds)).index(k) for k in y]])
    found: Any = permutation_test_score(
        RandomForestClassifier(60, random_state=0), leaky, y, cv=StratifiedKFold(5), n_permutations=20,
        random_state=0, scoring="balanced_accuracy",
    )  # fmt: skip
    assert found[2] < 0.06
