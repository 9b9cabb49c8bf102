"""Tables of any form become sessions: what is found out is told, what cannot be found out is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from foreign_samples import wave
from hypothesis import given, settings
from hypothesis import strategies as st
from log_commands import Capture, snakebot

from snakebot.cli.main import cli
from snakebot.errors import BadInputError
from snakebot.runlog import read_session
from snakebot.runlog.foreign.column_names import find_columns, find_pose
from snakebot.runlog.foreign.csv_form import find_form

T_S, COMMAND, MEASURED = wave(120)


def _table(
    path: Path,
    names: Sequence[str],
    between: str = ",",
    decimal: str = ".",
    above: str = "",
    time: float = 1.0,
) -> Path:
    rows = np.column_stack([T_S * time, COMMAND, MEASURED])
    lines = [between.join(f"{value:.6f}".replace(".", decimal) for value in row) for row in rows]
    head = between.join(names) + "\n" if names else ""
    path.write_text(above + head + "\n".join(lines) + "\n", encoding="utf-8")
    return path


def _goal(form: str) -> list[str]:
    return [form.format(joint) for joint in (1, 2, 3)]


@pytest.mark.parametrize(
    ("between", "decimal"), [(",", "."), (";", ","), (";", "."), ("\t", ","), ("  ", "."), ("|", ",")]
)
def test_any_delimiter_and_decimal_sign(between: str, decimal: str, tmp_path: Path, capsys: Capture) -> None:
    source = _table(tmp_path / "lab.csv", ["t", *_goal("goal{}"), *_goal("pos{}")], between, decimal)
    said = snakebot(capsys, "session", "import", source, "-o", tmp_path / "out", "--units", "deg")
    assert f"decimal {'comma' if decimal == ',' else 'point'}" in said.splitlines()[0]
    run = read_session(tmp_path / "out").runs[0]
    assert np.allclose(run.t_s, T_S, atol=1e-9)
    assert np.allclose(run.command_rad, np.radians(COMMAND), atol=1e-7)
    assert np.allclose(run.measured_rad, np.radians(MEASURED), atol=1e-7)


@pytest.mark.parametrize(
    ("names", "time"),
    [
        (["Zeit [ms]", *_goal("Soll {} [°]"), *_goal("Ist {} [°]")], 1e3),
        (["timestamp", *_goal("joint{}.target_deg"), *_goal("joint{}.actual_deg")], 1e6),
        (["time_s", *_goal("goal_position_{} (deg)"), *_goal("present_position_{} (deg)")], 1.0),
        (["Time", *_goal("cmdDeg{}"), *_goal("encDeg{}")], 1e9),
    ],
)
def test_names_and_units_of_other_labs(
    names: list[str], time: float, tmp_path: Path, capsys: Capture
) -> None:
    source = _table(tmp_path / "lab.txt", names, ";", ",", time=time)
    snakebot(capsys, "session", "import", source, "-o", tmp_path / "out")
    run = read_session(tmp_path / "out").runs[0]
    assert np.allclose(run.t_s, T_S, atol=1e-6)
    assert np.allclose(run.command_rad, np.radians(COMMAND), atol=1e-7)
    assert np.allclose(run.measured_rad, np.radians(MEASURED), atol=1e-7)


def test_lines_above_the_header_comments_and_no_header_at_all(tmp_path: Path, capsys: Capture) -> None:
    names = ["t", *_goal("goal{}_deg"), *_goal("pos{}_deg")]
    above = _table(tmp_path / "above.csv", names, ";", above="Logger 3\nRate;50\n\n")
    numpy = _table(tmp_path / "numpy.csv", ["# t", *names[1:]], " ")
    bare = _table(tmp_path / "bare.csv", [])
    snakebot(capsys, "session", "import", above, numpy, "-o", tmp_path / "out")
    mapped = ["--map", "t_s=c1", "--map", "cmd_1_rad=c2:deg", "--map", "enc_1_rad=-c5:deg"]
    snakebot(capsys, "session", "import", bare, "-o", tmp_path / "bare_out", *mapped)
    first, second = read_session(tmp_path / "out").runs
    assert np.array_equal(first.measured_rad, second.measured_rad)
    assert np.allclose(first.measured_rad, np.radians(MEASURED), atol=1e-7)
    run = read_session(tmp_path / "bare_out").runs[0]
    assert len(run) == len(T_S)
    assert np.allclose(run.measured_rad, -np.radians(MEASURED[:, :1]), atol=1e-7)


def test_counts_with_centre_and_direction_and_rows_without_a_time(tmp_path: Path, capsys: Capture) -> None:
    counts = np.round(2048 + np.array([1, -1]) * 10 * np.sin(T_S)[:, None] * 30)
    lines = ["goal_a,goal_b,pos_a,pos_b", *(f"{a:.0f},{b:.0f},{a:.0f},{b:.0f}" for a, b in counts)]
    source = tmp_path / "bus.csv"
    source.write_text("\n".join(lines))
    options = ["--units", "counts", "--centre", "2048", "--direction", "1,-1", "--rate", "50"]
    command = ["session", "import", source, "-o", tmp_path / "out", *options]
    assert "--counts-per-rev" in snakebot(capsys, *command, status=2)
    snakebot(capsys, *command, "--counts-per-rev", "4096", "--json")
    session = read_session(tmp_path / "out")
    assert session.robot.encoder_counts_per_rev == 4096
    wanted = (counts - 2048) * [1, -1] * 2 * np.pi / 4096
    assert np.allclose(session.runs[0].command_rad, wanted, atol=1e-12)
    assert np.allclose(session.runs[0].t_s, T_S)


def test_each_fault_is_one_line_and_nothing_is_written(tmp_path: Path, capsys: Capture) -> None:
    def told(source: Path, *options: str) -> str:
        line = snakebot(capsys, "session", "import", source, "-o", tmp_path / "out", *options, status=2)
        assert not (tmp_path / "out").exists()
        return line

    plain = _table(tmp_path / "plain.csv", ["t", *_goal("goal{}"), *_goal("pos{}")])
    assert "column goal1: its name does not say the unit of its angles; give --units" in told(plain)
    assert "--centre: 2 values for 3 joints" in told(plain, "--units", "deg", "--centre", "1,2")
    assert "--direction 2: 1 or -1" in told(plain, "--units", "deg", "--direction", "2")
    assert "--range is for --units percent" in told(plain, "--units", "deg", "--range", "1:2")
    assert "--rate nan" in told(plain, "--rate", "nan")
    assert "the robot has 5" in told(plain, "--units", "deg", "--robot", "penn_state")
    line = told(plain, "--units", "deg", "--joints", "a")
    assert "plain.csv: --joints is for LeRobot datasets and ROS 2 bags; of tables, --map says" in line
    assert "--episodes is for LeRobot datasets" in told(plain, "--units", "deg", "--episodes", "0-1")
    assert "--command is for ROS 2 bags" in told(plain, "--units", "deg", "--command", "/goal")
    names = _table(tmp_path / "names.csv", ["t", "a", "b", "c", "d", "e", "f"])
    assert "say it with --map 'cmd_*_rad=COMMAND*:deg'" in told(names)
    one = _table(tmp_path / "one.csv", ["t", *_goal("goal{}"), "pos1", "pos2", "f"])
    assert "goal3 without its counterpart" in told(one)
    (tmp_path / "words.csv").write_text("a;b\nx;y\n")
    assert "found no table of numbers" in told(tmp_path / "words.csv")
    text = plain.read_text().splitlines()
    (tmp_path / "broken.csv").write_text("\n".join([*text[:50], "1,2", *text[50:]]))
    assert "broken.csv: row 51: 2 values for 7 columns" in told(tmp_path / "broken.csv", "--units", "deg")
    assert "no such file" in told(tmp_path / "nowhere.csv")
    assert "is a session already" in told(_session(tmp_path, capsys))
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "x").touch()
    line = snakebot(capsys, "session", "import", plain, "-o", tmp_path / "taken", status=2)
    assert "exists already" in line


def _session(folder: Path, capsys: Capture) -> Path:
    source = _table(folder / "deg.csv", ["t", *_goal("goal{}_deg"), *_goal("pos{}_deg")])
    snakebot(capsys, "session", "import", source, source, "-o", folder / "made")
    return folder / "made"


def test_files_given_twice_are_named_apart_and_are_repeats(tmp_path: Path, capsys: Capture) -> None:
    session = read_session(_session(tmp_path, capsys))
    assert [run.name for run in session.runs] == ["deg.csv", "deg-2.csv"]
    assert session.runs[1].repeat_of == "deg.csv"


def test_a_recording_given_where_a_session_is_wanted_names_the_command(
    tmp_path: Path, capsys: Capture
) -> None:
    source = _table(tmp_path / "run1.csv", ["t", *_goal("goal{}"), *_goal("pos{}")], ";", ",")
    for command in (["diagnose"], ["analyze"], ["session", "check"], ["session", "make", tmp_path / "x"]):
        line = snakebot(capsys, *command, source, status=2)
        assert f"snakebot session import {source} -o SESSION" in line, command
        assert f"snakebot session import {source} -o SESSION" in snakebot(
            capsys, *command, tmp_path, status=2
        )
    for command in (
        ["predict", source],
        ["predict", "--robot", source, "--alpha", "5", "--beta", "80", "--omega", "1"],
    ):
        assert f"snakebot diagnose {source} --apply robot.yaml" in snakebot(capsys, *command, status=2)
    assert "snakebot log import makes one of a table" in snakebot(capsys, "log", "info", source, status=2)
    (tmp_path / "session.yaml").write_text("robot: {joints: 3}\nruns: [{file: run1.csv}]\n")
    assert "apart by semicolons or tabs? snakebot session import" in snakebot(
        capsys, "diagnose", tmp_path, status=2
    )


@pytest.mark.slow
def test_a_strangers_semicolons_and_decimal_commas_reach_a_verdict(tmp_path: Path, capsys: Capture) -> None:
    t_s, command, measured = wave(1500, lag_s=0.12)
    for name, scale in (("a.csv", 1.0), ("b.csv", 0.6), ("c.csv", 0.35)):
        rows = np.column_stack([t_s, scale * command, scale * measured])
        lines = [";".join(f"{value:.4f}".replace(".", ",") for value in row) for row in rows]
        (tmp_path / name).write_text(
            "\n".join([";".join(["Zeit", *_goal("Soll{}"), *_goal("Ist{}")]), *lines])
        )
    sources = [tmp_path / name for name in ("a.csv", "b.csv", "c.csv")]
    snakebot(capsys, "session", "import", *sources, "-o", tmp_path / "lab", "--units", "deg")
    said = snakebot(capsys, "diagnose", tmp_path / "lab")
    assert "command_delay" in said


def test_a_terminal_is_asked_what_nothing_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = _table(tmp_path / "lab.csv", ["t", *_goal("u{}"), *_goal("y{}")], ";", ",")
    monkeypatch.setattr("snakebot.cli.session_import.asks", lambda: True)
    arguments = ["session", "import", str(source), "-o", str(tmp_path / "out")]
    shown = CliRunner().invoke(cli, arguments, input="deg\nu*\ny*\nt:s\ny\n")
    assert shown.exit_code == 0, shown.output
    assert "the first, in degrees" in shown.output
    assert np.allclose(read_session(tmp_path / "out").runs[0].command_rad, np.radians(COMMAND), atol=1e-7)
    again = CliRunner().invoke(cli, [*arguments[:-1], str(tmp_path / "no")], input="deg\nu*\ny*\nt:s\nn\n")
    assert again.exit_code != 0
    assert not (tmp_path / "no").exists()


@settings(max_examples=200, deadline=None, database=None)
@given(st.lists(st.text(max_size=30), min_size=1, max_size=12))
def test_names_of_columns_are_understood_or_refused(names: list[str]) -> None:
    try:
        found = find_columns(names, "x")
    except BadInputError:
        return
    assert len(found.command) == len(found.measured) == len(found.joints) > 0
    assert set(found.command + found.measured) <= set(names)


def test_an_exported_log_is_understood_by_its_names() -> None:
    found = find_columns(
        ["t_s", "setpoint_1_rad", "cmd_1_rad", "applied_1_rad", "enc_1_rad", "board_time_us"], "x"
    )
    assert (found.command, found.measured) == (("cmd_1_rad",), ("enc_1_rad",))
    assert find_columns(["setpoint_1_rad", "enc_1_rad"], "x").command == ("setpoint_1_rad",)


def test_what_is_said_of_a_form_is_not_found_out(tmp_path: Path) -> None:
    source = tmp_path / "x.csv"
    source.write_text("a,b;c\n1,2;3\n4,5;6\n")
    assert find_form(source).header == ("a,b", "c")
    assert find_form(source, delimiter=",", decimal=".").header == ("a", "b;c")


@pytest.mark.parametrize(
    ("names", "taken", "unclear"),
    [
        (["x", "y"], {}, ("x", "y")),
        (["X [mm]", "Y [mm]"], {"x_m": ("X [mm]", 1e-3), "y_m": ("Y [mm]", 1e-3)}, ()),
        (["x_m", "y (cm)", "yaw"], {"x_m": ("x_m", 1.0), "y_m": ("y (cm)", 1e-2)}, ("yaw",)),
        (["x", "goal1"], {}, ()),  # one alone is no pose
        (["x_m", "y_deg"], {}, ()),
    ],
)
def test_a_pose_is_taken_where_names_say_its_unit(
    names: list[str], taken: dict[str, tuple[str, float]], unclear: tuple[str, ...]
) -> None:
    assert find_pose(names) == (taken, unclear)


def test_a_pose_without_a_unit_is_told_with_what_takes_it(tmp_path: Path, capsys: Capture) -> None:
    source = tmp_path / "lab.csv"
    rows = np.column_stack([T_S, COMMAND, MEASURED, T_S, 2 * T_S])
    head = ",".join(["t", *_goal("goal{}"), *_goal("pos{}"), "x", "y"])
    np.savetxt(source, rows, fmt="%.6f", delimiter=",", header=head, comments="")
    words = ("session", "import", source, "--units", "deg", "-o")
    said = snakebot(capsys, *words, tmp_path / "out").splitlines()[0]
    assert "x, y not used" in said
    assert "--map x_m=x:m --map y_m=y:m" in said
    more = ("--map", "x_m=x:cm", "--map", "y_m=y:cm")
    assert "not used" not in snakebot(capsys, *words, tmp_path / "posed", *more)
    pose = read_session(tmp_path / "posed").runs[0].pose
    assert pose is not None
    assert np.allclose(pose[:, 1], 0.02 * T_S, atol=1e-6)
