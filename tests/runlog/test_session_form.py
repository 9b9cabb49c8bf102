"""Session folders: errors that name file, row and column; round trips; recordings of real servos."""

from __future__ import annotations

import gzip
import os
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from runlog_samples import REALDATA, ROBOT, ROWS, bench, session_folder

from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.runlog import LogWarning, Run, read_session, write_session
from snakebot.safe_yaml import dump_yaml, load_yaml


def test_a_minimal_session_reads(tmp_path: Path) -> None:
    session = read_session(session_folder(tmp_path / "s"))
    run = session.runs[0]
    assert session.robot.joints == 1
    assert run.name == "run.csv"
    np.testing.assert_array_equal(run.t_s, [0.0, 0.01])
    np.testing.assert_array_equal(run.command_rad, [[0.1], [0.3]])
    np.testing.assert_array_equal(run.measured_rad, [[0.2], [0.4]])
    assert run.applied_rad is None
    assert run.pose is None
    assert session.warnings == ()


def test_everything_the_form_knows(tmp_path: Path) -> None:
    text = """
robot:
  links: 3
  half_length_m: 0.08
  link_mass_kg: 1.43
  friction: {ct: 0.83, cn: 51.9, ct0: 0.49, cn0: 2.33}
  servo: {time_constant_s: 0.03, gear: brass}
  encoder_counts_per_rev: 8192
runs:
  - file: run.csv
    gait: {alpha_deg: 66, beta_deg: 80, omega_rad_s: 2}
    forward_speed_m_s: 0.131
    repeat_of: other.csv.gz
    hold_out: true
  - file: other.csv.gz
"""
    table = (
        "t_s,cmd_1_rad,cmd_2_rad,enc_1_rad,enc_2_rad,applied_1_rad,applied_2_rad,x_m,y_m,heading_rad,current_1_a,"
        "supply_v,temperature_2_c\n"
        "0,,nan,0.1,NaN,0.2,0.3,1,2,3,0.5,7.4,\n"
        "0.5,0.1,0.2,0.3,0.4,0.5,0.6,4,5,6,0.5,7.4,30\n"
    )
    folder = session_folder(tmp_path / "s", table, text)
    (folder / "other.csv.gz").write_bytes(gzip.compress(table.encode()))
    session = read_session(folder)
    run, other = session.runs
    assert run.gait == Gait.from_degrees(66, 80, 2)
    assert run.forward_speed_m_s == 0.131
    assert run.repeat_of == "other.csv.gz"
    assert run.hold_out
    assert not other.hold_out
    np.testing.assert_array_equal(run.command_rad, [[np.nan, np.nan], [0.1, 0.2]])
    np.testing.assert_array_equal(run.measured_rad, [[0.1, np.nan], [0.3, 0.4]])
    np.testing.assert_array_equal(run.applied_rad, [[0.2, 0.3], [0.5, 0.6]])
    np.testing.assert_array_equal(run.pose, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(run.extra["temperature_2_c"], [np.nan, 30])
    np.testing.assert_array_equal(other.command_rad, run.command_rad)
    assert session.warnings == ()


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (
            "t_s,cmd_1_rad,enc_1_rad\n0,0,0\n0.1,zero,0\n",
            "run.csv: row 3, column cmd_1_rad: not a number: 'zero'",
        ),
        (
            "t_s,cmd_1_rad,enc_1_rad\n0,0,0\n0.1,0,1_0\n",
            "run.csv: row 3, column enc_1_rad: not a number: '1_0'",
        ),
        (
            "t_s,cmd_1_rad,enc_1_rad\n0,\u0661,0\n",
            "run.csv: row 2, column cmd_1_rad: not a number: '\u0661'",
        ),
        (
            "t_s,cmd_1_rad,enc_1_rad\r0,0,0\r1,0,0\r",
            "run.csv: row 1: lines end in CR alone; save the table with",
        ),
        ("t_s,cmd_1_rad,enc_1_rad\r" + "0,0,0\r" * 20_000, "run.csv: row 1: lines end in CR alone"),
        ("t_s,cmd_1_rad,enc_1_rad\n0,0,inf\n", "run.csv: row 2, column enc_1_rad: not a number: 'inf'"),
        ("t_s,cmd_1_rad,enc_1_rad\n0,1e999,0\n", "run.csv: row 2, column cmd_1_rad: not a number: '1e999'"),
        (
            "t_s,cmd_1_rad,enc_1_rad\n0,0,0\n1,0,0\n0.5,0,0\n",
            "run.csv: row 4, column t_s: time does not rise: 0.5 after 1",
        ),
        ("t_s,cmd_1_rad,enc_1_rad\n0,0,0\n0,0,0\n", "run.csv: row 3, column t_s: time does not rise"),
        ("t_s,cmd_1_rad,enc_1_rad\n0,0,0\n,0,0\n", "run.csv: row 3, column t_s: empty"),
        ("t_s,cmd_1_rad,enc_1_rad\n0,0\n", "run.csv: row 2: 2 values for 3 columns"),
        ("t_s,cmd_1_rad,enc_1_rad\n\n0,0,0\n", "run.csv: row 2: 0 values for 3 columns"),
        ("t_s,enc_1_rad\n0,0\n", "run.csv: row 1: column cmd_1_rad is missing"),
        ("cmd_1_rad,enc_1_rad\n0,0\n", "run.csv: row 1: column t_s is missing"),
        (
            "t_s,cmd_1_rad,enc_1_rad,cmd_2_rad,enc_2_rad\n0,0,0,0,0\n",
            "run.csv: row 1: column cmd_2_rad: the robot has 1",
        ),
        (
            "t_s,cmd_1_rad,enc_1_rad,current_3_a\n0,0,0,0\n",
            "run.csv: row 1: column current_3_a: the robot has 1",
        ),
        ("t_s,cmd_1_rad,enc_1_rad,cmd_1_rad\n0,0,0,0\n", "run.csv: row 1: column cmd_1_rad stands twice"),
        ("t_s,cmd_1_rad,enc_1_rad,\n0,0,0,0\n", "run.csv: row 1: column 4 has no name"),
        (
            "t_s,cmd_1_rad,enc_1_rad,x_m,heading_rad\n0,0,0,0,0\n",
            "run.csv: row 1: a pose needs x_m and y_m",
        ),
        (
            "t_s,cmd_1_rad,enc_1_rad,supply_v\n0,0,0,low\n",
            "run.csv: row 2, column supply_v: not a number: 'low'",
        ),
        ("t_s,cmd_1_rad,enc_1_rad\n", "run.csv: no samples under the header"),
        ("", "run.csv: row 1: the header line is missing"),
        (b"t_s,cmd_1_rad,enc_1_rad\n0,0,0\n\xff\xfe,0,0\n", "run.csv: row 3: not UTF-8 text"),
        ('t_s,cmd_1_rad,enc_1_rad\n0,0,0\n"0.1,0,0\n', "run.csv: row 3: unexpected end of data"),
        (b"t_s,cmd_1_rad,enc_1_rad\n" + b"1" * 100_000, "run.csv: row 2: longer than 64 KiB"),
    ],
)
def test_errors_name_file_row_and_column(tmp_path: Path, table: str | bytes, said: str) -> None:
    with pytest.raises(BadInputError) as error:
        read_session(session_folder(tmp_path / "s", table))
    assert said in str(error.value)
    assert str(tmp_path / "s") in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "a session is a mapping"),
        ("[1, 2]", "a session is a mapping"),
        ("robot: {joints: 1}", "runs: needs a list"),
        ("robot: {joints: 1}\nruns: []", "runs: needs a list"),
        ("robot: {joints: 1}\nruns: [run.csv]", "runs[1]: a run is a mapping"),
        ("runs: [{file: run.csv}]", "robot: a robot description is a mapping"),
        ("robot: {joints: 0}\nruns: [{file: run.csv}]", "robot: line 1: joints"),
        (
            "robot: {joints: 1, wheels: 4}\nruns: [{file: run.csv}]",
            "robot: line 1: wheels is not known; a robot has",
        ),
        ("robot: {joints: 1}\nruns: [{}]", "file: needs the name of a table"),
        ("robot: {joints: 1}\nruns: [{file: 3}]", "file: needs the name of a table"),
        ("robot: {joints: 1}\nruns: [{file: run.xlsx}]", "not one of .csv"),
        ("robot: {joints: 1}\nruns: [{file: gone.csv}]", "gone.csv: no such file"),
        ("robot: {joints: 1}\nruns: [{file: ../run.csv}]", "leaves the session's folder"),
        ("robot: {joints: 1}\nruns: [{file: /etc/hosts.csv}]", "leaves the session's folder"),
        ("robot: {joints: 1}\nruns: [{file: link.csv}]", "leaves the session's folder"),
        ("robot: {joints: 1}\nruns: [{file: run.csv}, {file: run.csv}]", "run.csv stands twice"),
        (
            "robot: {joints: 1}\nruns: [{file: run.csv}, {file: ./run.csv}]",
            "run.csv and ./run.csv are one file",
        ),
        (
            "robot: {joints: 1}\nruns: [{file: run.csv}, {file: same.csv, repeat_of: run.csv}]",
            "run.csv and same.csv are one file",
        ),
        (
            "robot: {joints: 1}\nruns: [{file: run.csv, repeat_of: other.csv}]",
            "repeat_of 'other.csv' is no other run",
        ),
        (
            "robot: {joints: 1}\nruns: [{file: run.csv, repeat_of: run.csv}]",
            "repeat_of 'run.csv' is no other run",
        ),
        ("robot: {joints: 1}\nruns: [{file: run.csv, hold_out: 1}]", "hold_out: neither true nor false"),
        (
            "robot: {joints: 1}\nruns: [{file: run.csv, forward_speed_m_s: fast}]",
            "forward_speed_m_s: not a finite number",
        ),
        (
            "robot: {joints: 1}\nruns: [{file: run.csv, forward_speed_m_s: .nan}]",
            "forward_speed_m_s: not a finite number",
        ),
        (
            "robot: {joints: 1}\nruns: [{file: run.csv, gait: {alpha_deg: 3}}]",
            "gait: line 2: beta_deg is missing",
        ),
        ("robot: {joints: 1}\nruns: [{file: run.csv, gait: fast}]", "gait: needs alpha_deg"),
        (
            "robot: {joints: 1}\nruns: [{file: run.csv, gait: {alpha_deg: -3, beta_deg: 1, omega_rad_s: 1}}]",
            "session.yaml: runs[1]: gait: alpha is -3",
        ),
        (
            "robot: {joints: 1}\nruns: [{file: run.csv, gait: {alpha_deg: 3, beta_deg: 1, omega_rad_s: 1, omga: 2}}]",
            "gait: line 2: omga is not known; did you mean omega_rad_s?",
        ),
        ("robot: !!python/object/apply:os.system ['touch pwned']\nruns: []", "not YAML"),
        ("robot: {joints: 1", "not YAML"),
        ("a: &a [*a]", "not"),
        ("robot: " + "[" * 3000, "not"),
        (
            "runs: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n"
            + "".join(f"k{i}: &{chr(98 + i)} [{', '.join(['*' + chr(97 + i)] * 10)}]\n" for i in range(8)),
            "stand for more than 200000 values",
        ),
    ],
)
def test_errors_in_the_yaml_name_the_key(tmp_path: Path, text: str, said: str) -> None:
    folder = session_folder(tmp_path / "s", text=text)
    (tmp_path / "run.csv").write_text(ROWS)
    os.symlink(tmp_path / "run.csv", folder / "link.csv")
    os.symlink(folder / "run.csv", folder / "same.csv")
    with pytest.raises(BadInputError) as error:
        read_session(folder)
    assert said in str(error.value)
    assert "session.yaml" in str(error.value)
    assert "\n" not in str(error.value)
    assert not Path("pwned").exists()


def test_unknown_columns_and_keys_are_kept_with_one_warning_each(tmp_path: Path) -> None:
    text = "robot: {joints: 1}\nlab: 7\nruns:\n  - {file: run.csv, author_targets: [kp, tau]}\n  - {file: b.csv}\n"
    table = "t_s,cmd_1_rad,enc_1_rad,load_1_raw,comment\n0,0,0,5,start\n1,0,0,6,\n"
    folder = session_folder(tmp_path / "s", table, text)
    (folder / "b.csv").write_text(table)
    with pytest.warns(LogWarning) as told:
        session = read_session(folder)
    assert len(told) == 2
    assert "unknown columns kept, not used: comment, load_1_raw" in str(told[0].message)
    assert "unknown keys kept, not used: author_targets, lab" in str(told[1].message)
    assert session.runs[0].metadata == {"author_targets": ["kp", "tau"]}
    np.testing.assert_array_equal(session.runs[0].extra["load_1_raw"], [5, 6])
    assert len(session.warnings) == 2


@pytest.mark.parametrize("form", ["csv", "csv.gz", "parquet"])
def test_a_session_comes_back_to_the_last_bit(tmp_path: Path, form: str) -> None:
    rng = np.random.default_rng(1)
    angles = rng.normal(size=(50, 3, 5))
    angles[rng.random(angles.shape) < 0.1] = np.nan
    first = Run(
        "first",
        np.cumsum(rng.random(50) + 0.001),
        angles[:, 0],
        angles[:, 1],
        applied_rad=angles[:, 2],
        pose=rng.normal(size=(50, 3)),
        gait=Gait.from_degrees(66, 80, 2, 1.5),
        forward_speed_m_s=0.131,
        hold_out=True,
        extra={"supply_v": rng.normal(size=50), "late": rng.random(50) < 0.5},
        metadata={"faults": ["free:3"], "board": {"serial": 7}},
    )
    second = Run("second", first.t_s, angles[:, 0], angles[:, 1], repeat_of="first")
    write_session(tmp_path / "s", ROBOT, [first, second], form)  # type: ignore[arg-type]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        session = read_session(tmp_path / "s")
    assert session.robot == ROBOT
    one, two = session.runs
    for name in ("t_s", "command_rad", "measured_rad", "applied_rad", "pose"):
        np.testing.assert_array_equal(getattr(one, name), getattr(first, name))
    for name, values in first.extra.items():
        np.testing.assert_array_equal(one.extra[name], values)
    assert one.gait is not None
    assert first.gait is not None
    np.testing.assert_allclose(one.gait.angles([0.3], 5), first.gait.angles([0.3], 5), rtol=1e-12)
    assert (one.forward_speed_m_s, one.hold_out, one.metadata) == (0.131, True, first.metadata)
    assert two.repeat_of == one.name == f"first.{form}"
    with pytest.raises(BadInputError, match="is not empty"):
        write_session(tmp_path / "s", ROBOT, [first])


def test_a_session_with_a_wrong_joint_count_is_not_written(tmp_path: Path) -> None:
    run = Run("a", np.array([0.0]), np.zeros((1, 2)), np.zeros((1, 2)))
    with pytest.raises(BadInputError, match="2 joints, the robot 1"):
        write_session(tmp_path / "s", bench(1), [run])
    assert not (tmp_path / "s").exists()


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(max_size=200) | st.binary(max_size=200))
def test_any_yaml_is_plain_data_or_one_line(data: str | bytes) -> None:
    try:
        load_yaml(data, "here.yaml")
    except BadInputError as error:
        said = str(error)
        assert said.startswith("here.yaml: ")
        assert "\n" not in said


@pytest.mark.parametrize("text", ["1e-3", "+2E5", "-1e+2", "7e0"])
def test_a_number_with_an_exponent_is_a_number_and_text_like_one_stays_text(text: str) -> None:
    assert load_yaml(f"a: {text}", "here") == {"a": float(text)}
    assert load_yaml(f"a: '{text}'", "here") == {"a": text}
    assert load_yaml(dump_yaml({"a": text, "b": 1e-7}), "here") == {"a": text, "b": 1e-7}


FOLDERS = sorted(path.parent for path in REALDATA.glob("*/*/session.yaml"))


@pytest.mark.skipif(not FOLDERS, reason="the recordings of real servos are not here (../shared/realdata)")
def test_all_recordings_of_real_servos_read() -> None:
    expected = {"without_weight": 32, "with_weight": 100, "kp_100": 4, "kp_200": 4, "kp_400": 4, "kp_800": 4}
    assert {folder.name for folder in FOLDERS} == set(expected)
    for folder in FOLDERS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LogWarning)
            session = read_session(folder)
        assert len(session.runs) == expected[folder.name]
        assert session.robot.joints == 1
        for run in session.runs:
            file = folder / run.name
            lines = file.read_text().splitlines()
            assert len(run) == len(lines) - 1
            last = lines[-1].split(",")
            np.testing.assert_array_equal(
                [run.t_s[-1], run.command_rad[-1, 0], run.measured_rad[-1, 0]],
                [float(cell) if cell else np.nan for cell in last[:3]],
            )
        if folder.parent.name == "xl330_pendulum":
            drop = session["lift_and_drop.csv"]
            assert 0.7 < np.isnan(drop.command_rad).mean() < 0.8  # torque off for three quarters of it
            assert drop.extra["supply_v"].max() < 9
