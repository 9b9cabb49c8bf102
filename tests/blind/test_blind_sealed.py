"""Nothing but the signals may give a label away, and nobody reads the labels by accident."""

import re
import subprocess
import sys
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from blind import cases as blind_cases
from blind.cases import (
    PROBE_S,
    RATES_HZ,
    SETS,
    Case,
    Label,
    Stage,
    make_case,
    plan,
    probes,
    rms,
    shares_of,
    ticks,
)
from blind.faults import go_together
from blind.motions import Motion
from blind.records import DURATIONS_S, MOTIONS_FROM_TO, Records, records_of
from blind.robot import Build, Parameters
from blind.seal import SealError, digest, unseal
from blind.session_files import STAMP_S, write_session
from samples import THOROUGH
from tool_calls import called

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


@pytest.mark.slow
def test_folders_are_alike_in_all_but_the_numbers(made: tuple[Path, str]) -> None:
    folders = sorted((made[0] / "cases").iterdir())
    assert len(folders) == 3
    assert all(re.fullmatch("[0-9a-f]{12}", f.name) for f in folders)
    for folder in folders:
        *names, about = sorted(f.name for f in folder.iterdir())
        assert [*names, about] == [*(f"run_{i + 1:02d}.csv" for i in range(len(names))), "session.yaml"]
        for file in folder.iterdir():
            assert (file.stat().st_mtime, file.stat().st_mode) == (
                STAMP_S,
                (folders[0] / "session.yaml").stat().st_mode,
            )
        runs = sorted(folder.glob("run_*.csv"))
        assert len({run.stat().st_size for run in runs}) == 1  # every number is as wide as every other
        head, first = runs[0].read_text().splitlines()[:2]
        assert runs[0].stat().st_size == len(head) + 1 + (len(runs[0].read_text().splitlines()) - 1) * (
            len(first) + 1
        )
    assert {f.stat().st_mtime for f in folders} == {STAMP_S}
    for folder in folders:  # of each run, its name and its gait; of the robot, what the lab believes
        told = yaml.safe_load((folder / "session.yaml").read_text())
        assert set(told) == {"robot", "runs"}
        assert set().union(*told["runs"]) <= {"file", "gait", "repeat_of", "forward_speed_m_s"}


@pytest.mark.slow
def test_folders_are_sessions(made: tuple[Path, str]) -> None:
    from snakebot.runlog import read_session

    numbers = unseal(made[0] / "labels.sealed", made[0].with_name("set.key"))["numbers"]
    for folder in (made[0] / "cases").iterdir():
        session, records = read_session(folder), records_of(SETS["tune"][0] + 7, numbers[folder.name])
        assert session.warnings == ()
        assert len(session.runs) == records.motions + 1
        assert session.runs[-1].repeat_of == session.runs[0].name
        assert session.runs[0].t_s.size in {records.duration_s * rate for rate in RATES_HZ}
        for run in session.runs:
            assert (run.pose is not None) == (run.forward_speed_m_s is None) == records.pose


@pytest.mark.slow
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


@pytest.mark.slow
def test_same_seed_same_signals() -> None:
    first, second = (make_case("tune", 5, 0, 40) for _ in range(2))
    assert first.label == second.label
    runs = zip(first.runs(), second.runs(), strict=True)
    assert all(np.array_equal(a.encoder_rad, b.encoder_rad) for a, b in runs)


def test_half_of_the_labs_record_as_the_first_did_and_the_others_as_they_like() -> None:
    drawn = [records_of(SETS["score"][0], number) for number in range(400)]
    assert 0.4 < sum(r == Records() for r in drawn) / len(drawn) < 0.6
    assert {r.motions for r in drawn} == set(range(MOTIONS_FROM_TO[0], MOTIONS_FROM_TO[1] + 1))
    assert {min(DURATIONS_S), max(DURATIONS_S)} < {r.duration_s for r in drawn}
    assert 0.05 < sum(not r.pose for r in drawn) / len(drawn) < 0.15


@pytest.mark.parametrize("pose", [True, False])
def test_a_treadmill_tells_one_speed_in_place_of_a_pose(tmp_path: Path, pose: bool) -> None:
    from snakebot.runlog import read_session

    rng = np.random.default_rng(0)
    build = Build()
    records = Records(motions=1, duration_s=4.0, pose=pose)
    label = Label("no_gap", 0.0, [], 0.0, 0.0)
    motions = [Motion("gait", 0.7, 1.4, 4.0)]
    case = Case(label, None, motions, build, Parameters.of(build), rng, records=records)
    write_session(tmp_path / "s", case)
    for run in read_session(tmp_path / "s").runs:
        assert (run.pose is not None) == pose
        if pose:
            assert run.pose is not None
            assert np.hypot(*run.pose[-1, :2]) > 0.05
        else:
            assert run.forward_speed_m_s is not None
            assert abs(run.forward_speed_m_s) > 0.02


def test_where_a_speed_alone_is_recorded_the_size_of_an_effect_is_in_it() -> None:
    build = Build()
    robot, motions = Parameters.of(build), [Motion("gait", 1.1, 1.4, 2.0), Motion("gait", 0.6, 1.4, 4.0)]
    path, speeds = (
        probes(robot, Stage(build, motions, pose), 0, noiseless=True)[1] for pose in (True, False)
    )
    assert path.shape == (2 * ticks(build, PROBE_S).size, 2)
    halves = path.reshape(2, -1, 2)[:, path.shape[0] // 4 :]
    way = np.linalg.norm(halves[:, -1] - halves[:, 0], axis=1)
    assert speeds[:, 0] == pytest.approx(way / (PROBE_S / 2), rel=0.05)  # it hardly goes sideways
    case = make_case("tune", 7, 314, 400)  # a slope, and a lab that has no more
    assert not case.records.pose
    (effect,) = case.label.effects
    assert case.sound is not None
    stage = Stage(case.build, case.motions, pose=False)
    (_, sound), (_, faulty) = (probes(p, stage, 0, noiseless=True) for p in (case.sound, case.parameters))
    assert rms(faulty - sound) / case.label.floor_m == pytest.approx(effect.size, rel=1e-3)


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
    pairs = [names for stratum, names in planned if stratum == "pair"]
    assert all(go_together(*names) for names in pairs)


def test_robots_of_a_set_of_triples_have_three_effects_that_go_together() -> None:
    for number in range(20):
        stratum, names = plan(number, 20, np.random.default_rng(number), shares_of("triple"))
        assert stratum == "triple"
        assert len(set(names)) == 3
        assert all(go_together(*two) for two in combinations(names, 2))


def test_effects_that_undo_each_other_are_not_put_into_one_robot() -> None:
    for first, second in (
        ("rate_limit", "voltage_sag"),
        ("servo_lag", "second_order"),
        ("servo_lag", "joint_friction"),
        ("ground_friction", "wheel_drag"),
    ):
        assert not go_together(first, second)
        assert not go_together(second, first)
    assert go_together("servo_lag", "rate_limit")
    assert go_together("servo_offset", "encoder_offset")
    assert go_together("payload", "slope")


def test_bad_options_are_told_in_a_line(root: Path, tmp_path: Path) -> None:
    for options in (("--seed", "-1"), ("--seed", "1", "--cases", "0"), ("--seed", "1", "--set", "nonsense")):
        done = called(root / "tools" / "blind" / "make", *options, str(tmp_path / "x"))
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "x").exists()


def outward(folder: Path) -> list[float]:
    """Everything about a folder but its signals, as numbers."""
    token = [int(c, 16) for c in folder.name]
    files = sorted(folder.iterdir())
    stats = [v for f in files for v in (f.stat().st_size, f.stat().st_mtime, len(f.name))]
    text = re.sub(r"forward_speed_m_s: .*", "", (folder / "session.yaml").read_text())  # a signal
    numbers = [float(n) for n in re.findall(r"\d+\.\d+", text)]
    room = np.zeros(60)  # not every motion is a gait, so that not all sessions tell as many numbers
    room[: len(numbers)] = numbers
    return [*token, *stats, len(numbers), *room]


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_classifier_without_the_signals_does_no_better_than_chance(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of forty cases; what stands beside signals does not go by how long these are, so that short ones do in CI."""
    from sklearn.model_selection import StratifiedKFold, permutation_test_score
    from sklearn.tree import DecisionTreeClassifier

    if not THOROUGH:
        monkeypatch.setattr(blind_cases, "PROBE_S", 0.5)
        monkeypatch.setattr(blind_cases, "records_of", lambda *of: Records(duration_s=1.5))
    rows: list[list[float]] = []
    kinds: list[str] = []
    tokens = np.random.default_rng(0).permutation(4000)
    for number in range(40):
        case = make_case("tune", 11, number, 40)
        folder = tmp_path / f"{tokens[number]:012x}"
        write_session(folder, case)
        rows.append(outward(folder))
        kinds.append(case.label.effects[0].stage if case.label.effects else "none")
    counts: dict[str, int] = {k: kinds.count(k) for k in kinds}
    keep = [i for i, k in enumerate(kinds) if counts[k] >= 5]
    x, y = np.array(rows)[keep], np.array(kinds)[keep]
    # One tree: with so few cases it sees a number that gives the label away more surely than a forest does.
    score, chance, p = permutation_test_score(
        DecisionTreeClassifier(random_state=0), x, y, cv=StratifiedKFold(5), n_permutations=60, random_state=0,
        scoring="balanced_accuracy",
    )  # fmt: skip
    assert p > 0.02, f"balanced accuracy {score:.2f} against {np.mean(chance):.2f} by chance"
    # the same classifier does see a leak where there is one
    leaky = np.column_stack([x, [sorted(set(kinds)).index(k) for k in y]])
    found: Any = permutation_test_score(
        DecisionTreeClassifier(random_state=0), leaky, y, cv=StratifiedKFold(5), n_permutations=20,
        random_state=0, scoring="balanced_accuracy",
    )  # fmt: skip
    assert found[2] < 0.06
