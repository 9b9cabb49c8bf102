"""``snakebot log`` and ``snakebot session`` as a user types them."""

from __future__ import annotations

import json
import math
import re
import shlex
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
import pytest
from log_commands import Capture, snakebot, wave_log
from runlog_samples import ROBOT, START_NS, flushed, make_ticks, write_everything

from snakebot.cli import log as log_module
from snakebot.cli import session as session_module
from snakebot.errors import BadInputError
from snakebot.gait import Gait
from snakebot.robot import load_robot
from snakebot.runlog import RunWriter, Tick, gait_to_mapping, open_run, read_log
from snakebot.runlog.column_map import Source, parse_map
from snakebot.runlog.listing import summarize


def test_list_and_info(tmp_path: Path, capsys: Capture) -> None:
    write_everything(tmp_path / "a.mcap")
    writer = RunWriter(tmp_path / "b", ROBOT)
    writer.tick(make_ticks(1)[0])
    flushed(writer)
    (tmp_path / "bad.mcap").write_bytes(b"nonsense")
    (tmp_path / "notes.txt").write_text("no log")
    out = snakebot(capsys, "log", "list", tmp_path)
    states = {line.split()[0]: line.split()[1] for line in out.splitlines()[1:]}
    assert states == {"a.mcap": "finished", "b.mcap.part": "writing", "bad.mcap": "damaged"}
    writer.close()
    logs = json.loads(snakebot(capsys, "log", "list", tmp_path, "--json"))["logs"]
    assert [log["state"] for log in logs] == ["finished", "finished", "damaged"]
    assert logs[0]["messages"]["/joints"] == 50
    about = json.loads(snakebot(capsys, "log", "info", tmp_path / "a.mcap", "--json"))
    assert about["ticks"] == 50
    assert about["metadata"]["port"] == "sim:"
    assert about["events"][0]["kind"] == "armed"
    text = snakebot(capsys, "log", "info", tmp_path / "a.mcap")
    assert "finished, 50 ticks" in text
    assert "snakebot.dbc" in text


def test_what_a_log_says_cannot_steer_the_terminal(tmp_path: Path, capsys: Capture) -> None:
    with RunWriter(tmp_path / "a", ROBOT, {"notes": "\x1b[2Jgone\x07", "robot": "\x1b]0;x"}) as writer:
        writer.tick(make_ticks(1)[0])
    assert "\x1b" not in snakebot(capsys, "log", "info", writer.path)
    assert "\x1b" not in snakebot(capsys, "log", "list", tmp_path)


def test_export_to_tables_sessions_and_attachments(tmp_path: Path, capsys: Capture) -> None:
    log = write_everything(tmp_path / "a.mcap")
    other = write_everything(tmp_path / "b.mcap")
    for name in ("a.csv", "a.csv.gz", "a.parquet"):
        told = json.loads(snakebot(capsys, "log", "export", log, tmp_path / name, "--json"))
        assert told["rows"] == 50
    snakebot(capsys, "log", "export", log, other, tmp_path / "session")
    assert (tmp_path / "session" / "session.yaml").exists()
    snakebot(capsys, "log", "export", log, tmp_path / "snakebot.dbc")
    assert (tmp_path / "snakebot.dbc").read_bytes() == b'VERSION ""'
    assert "exists already" in snakebot(capsys, "log", "export", log, tmp_path / "a.csv", status=2)
    assert "2 were given" in snakebot(capsys, "log", "export", log, other, tmp_path / "c.csv", status=2)
    assert "nor an attachment" in snakebot(capsys, "log", "export", log, tmp_path / "x.dbc", status=2)
    said = snakebot(capsys, "log", "export", tmp_path / "no.mcap", tmp_path / "n.csv", status=2)
    assert f"no such log; `snakebot log list {tmp_path}`" in said
    said = snakebot(capsys, "log", "info", tmp_path / "gone" / "a.mcap", status=2)
    assert f"no such log: there is no folder {tmp_path / 'gone'}" in said


def test_an_exported_table_can_be_imported_again(tmp_path: Path, capsys: Capture) -> None:
    log = read_log(write_everything(tmp_path / "a.mcap"))
    for name in ("a.csv", "a.parquet"):
        snakebot(capsys, "log", "export", log.path, tmp_path / name)
        target = tmp_path / f"{name}.mcap"
        snakebot(capsys, "log", "import", tmp_path / name, target)
        again = read_log(target)
        for column in ("t_s", "sequence", "sent_rad", "applied_rad", "measured_rad", "latency_s", "late"):
            np.testing.assert_array_equal(getattr(again, column), getattr(log, column))
        np.testing.assert_array_equal(again.pose, log.pose)
        assert again.metadata["imported_from"] == name
    said = snakebot(capsys, "log", "import", tmp_path / "a.csv", tmp_path / "a.csv.mcap", status=6)
    assert "exists already" in said


def test_import_with_a_column_map(tmp_path: Path, capsys: Capture) -> None:
    table = tmp_path / "lab.csv"
    table.write_text(
        "made by LabTool 3;;;;;;\nTime;goal0;goal1;pos a;pos b;state;V\n"
        "1795000000000,0;10,5;-20;512;1024;run;7400\n1795000000010,0;;;0;-2048;run;7300\n"
    )
    bench_file = tmp_path / "bench.yaml"
    bench_file.write_text("joints: 2\nencoder_counts_per_rev: 4096\n")
    maps = tmp_path / "columns.txt"
    maps.write_text("# ours = theirs\nt_s = Time:ms\n\ncmd_*_rad = goal#:deg\nsupply_v=V:mV\n")
    command = shlex.split("--delimiter ; --decimal , --skip-rows 1 --map enc_1_rad='pos a:counts'")
    command += ["--map", "enc_2_rad=-pos b:counts", "--map-file", str(maps), "--robot", str(bench_file)]
    command += shlex.split("--alpha 10 --beta 80 --omega 2 --speed 0.1 --note 'on the bench'")
    snakebot(capsys, "log", "import", table, tmp_path / "lab.mcap", *command)
    log = read_log(tmp_path / "lab.mcap")
    assert log.robot.joints == 2
    np.testing.assert_allclose(log.t_s, [0, 0.01], atol=1e-6)
    assert abs(log.metadata["start_time_ns"] - 1795000000 * 10**9) < 1000
    np.testing.assert_allclose(np.degrees(log.sent_rad), [[10.5, -20], [np.nan, np.nan]])
    np.testing.assert_allclose(log.measured_rad, [[np.pi / 4, -np.pi / 2], [0, np.pi]])
    np.testing.assert_allclose(log.telemetry["supply_v"], [7.4, 7.3])
    assert log.gait == Gait.from_degrees(10, 80, 2)
    assert log.forward_speed_m_s == 0.1
    assert log.metadata["notes"] == "on the bench"


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ("t_s", "write NAME="),
        ("=x", "write NAME="),
        ("speed=x", "speed is no column of a session"),
        ("t_s=Time:deg", "t_s cannot be in deg"),
        ("cmd_1_rad=q:mm", "cannot be in mm"),
    ],
)
def test_nonsense_in_a_column_map_is_one_line(entry: str, said: str) -> None:
    with pytest.raises(BadInputError, match=said):
        parse_map([entry], ROBOT)


def test_column_map_grammar() -> None:
    robot = load_robot("penn_state")
    mapping = parse_map(["cmd_*_rad=-q#:deg", "t_s=Time [s]: raw", "enc_1_rad=a:b:counts"], robot)
    assert mapping["cmd_5_rad"].column == "q4"
    assert mapping["cmd_5_rad"].factor == pytest.approx(-np.pi / 180)
    assert mapping["t_s"] == Source("Time [s]: raw", 1.0)
    assert mapping["enc_1_rad"].column == "a:b"
    with pytest.raises(BadInputError, match="mapped twice"):
        parse_map(["t_s=a", "t_s=b"], robot)


def test_import_errors_name_the_place(tmp_path: Path, capsys: Capture) -> None:
    table = tmp_path / "lab.csv"
    table.write_text("t,a\n0,1\n1,x\n")
    target = tmp_path / "lab.mcap"
    one = tmp_path / "one.yaml"
    one.write_text("joints: 1\n")
    run = ("log", "import", table, target, "--robot", one, "--map", "t_s=t", "--map", "enc_1_rad=a")
    assert "row 3, column a: not a number: 'x'" in snakebot(capsys, *run, "--map", "cmd_1_rad=a", status=2)
    table.write_text("t,a\n0,1\n1,2\n")
    said = snakebot(capsys, *run, "--map", "cmd_1_rad=b", status=2)
    assert "column b is missing (for cmd_1_rad); found t, a" in said
    said = snakebot(capsys, *run, "--map", "cmd_1_rad=a:hours", status=2)
    assert "hours is no unit of it, these are: counts, deg, mrad, rad, rev; found t, a" in said
    assert "one character" in snakebot(capsys, *run, "--delimiter", "ab", status=2)
    assert "cannot read" in snakebot(capsys, "log", "import", tmp_path / "gone.csv", target, status=2)
    assert "beta_deg is missing" in snakebot(capsys, *run, "--alpha", "3", status=2)
    assert not list(tmp_path.glob("*.mcap*"))


def test_recover(tmp_path: Path, capsys: Capture) -> None:
    writer = RunWriter(tmp_path / "run", ROBOT, start_time_ns=START_NS)
    for tick in make_ticks(300):
        writer.tick(tick)
    flushed(writer)
    said = snakebot(capsys, "log", "recover", writer.part_path, status=6)
    assert "still writing" in said
    torn = tmp_path / "torn.mcap.part"
    torn.write_bytes(writer.part_path.read_bytes()[:-500])
    writer.close()
    whole = torn.read_bytes()

    told = json.loads(snakebot(capsys, "log", "recover", torn, "-o", tmp_path / "copy.mcap", "--json"))
    assert torn.read_bytes() == whole
    assert told["ticks"] == len(read_log(tmp_path / "copy.mcap").sequence) > 100
    assert "cut short" in told["left_out"][0]
    assert f"{told['ticks']} ticks" in snakebot(capsys, "log", "recover", torn)
    assert not torn.exists()
    log = read_log(tmp_path / "torn.mcap")
    assert log.complete
    assert log.metadata["recovered"] is True
    assert "exists already" in snakebot(
        capsys, "log", "recover", tmp_path / "copy.mcap", "-o", log.path, status=6
    )
    assert "--output" in snakebot(capsys, "log", "recover", log.path, status=2)
    assert "no such log" in snakebot(capsys, "log", "recover", tmp_path / "gone.mcap.part", status=2)
    cut = tmp_path / "cut.mcap.part"
    cut.write_bytes(whole[: len(whole) // 20])
    assert "not one tick in it is whole" in snakebot(capsys, "log", "recover", cut, status=2)
    assert cut.exists(), "what cannot be read today may be tomorrow"
    assert [path.name for path in tmp_path.glob("cut*")] == [cut.name]
    (tmp_path / "x.mcap.part").write_bytes(b"no log")
    assert "not an MCAP log" in snakebot(capsys, "log", "recover", tmp_path / "x.mcap.part", status=2)
    assert not (tmp_path / "x.mcap").exists()


def test_session_make_and_check(tmp_path: Path, capsys: Capture) -> None:
    for name in ("a", "b"):
        wave_log(tmp_path / "runs" / f"{name}.mcap", duration_s=4)
    wave_log(tmp_path / "runs" / "c.mcap", alpha_deg=30, duration_s=4)
    command = ("session", "make", tmp_path / "s", tmp_path / "runs", "--hold-out", "c", "--json")
    made = json.loads(snakebot(capsys, *command))
    assert made["repeats"] == {"b": "a"}
    assert made["held_out"] == ["c"]
    checked = json.loads(snakebot(capsys, "session", "check", tmp_path / "s", "--json"))
    assert [(run["run"], run["repeat_of"], run["hold_out"]) for run in checked["runs"]] == [
        ("a.csv", None, False),
        ("b.csv", "a.csv", False),
        ("c.csv", None, True),
    ]
    assert "b.csv" in snakebot(capsys, "session", "check", tmp_path / "s")
    (tmp_path / "one.yaml").write_text("joints: 1\n")
    other = snakebot(capsys, "session", "check", tmp_path / "s", "--robot", tmp_path / "one.yaml", status=2)
    assert re.search(r"--robot \S+one\.yaml: a robot of 1 joint, the recordings have \d", other)
    again = (
        "session",
        "make",
        tmp_path / "t",
        tmp_path / "s",
        tmp_path / "runs",
        "--format",
        "parquet",
        "--json",
    )
    made = json.loads(snakebot(capsys, *again, "--no-find-repeats", "--repeat", "a=a.csv"))
    assert made["runs"] == 6
    assert made["repeats"] == {"b.csv": "a.csv", "a": "a.csv"}
    assert "is not empty" in snakebot(capsys, *command, status=2)
    assert "no such run" in snakebot(
        capsys, "session", "make", tmp_path / "u", tmp_path / "s", "--hold-out", "x", status=2
    )
    for repeats, said in ((("a=b", "b=a"), "which repeats a"), (("a=a",), "would repeat itself")):
        marks = [word for entry in repeats for word in ("--repeat", entry)]
        new = ("session", "make", tmp_path / "u", tmp_path / "runs", "--no-find-repeats", *marks)
        assert said in snakebot(capsys, *new, status=2)
    assert not (tmp_path / "u").exists()
    degrees = "".join(f"{t / 50},{30 * math.sin(t / 25)},{0.5 * math.sin(t / 25)}\n" for t in range(500))
    (tmp_path / "deg").mkdir()
    (tmp_path / "deg" / "a.csv").write_text("t_s,cmd_1_rad,enc_1_rad\n" + degrees)
    (tmp_path / "deg" / "session.yaml").write_text("robot: {joints: 1}\nruns: [{file: a.csv}]\n")
    assert "are these degrees?" in snakebot(capsys, "session", "check", tmp_path / "deg")
    assert "no such file or folder" in snakebot(capsys, "session", "check", tmp_path / "nope", status=2)
    (tmp_path / "s" / "a.csv").write_text("t_s,cmd_1_rad\n")
    assert "a.csv: row 1: column" in snakebot(capsys, "session", "check", tmp_path / "s", status=2)


def test_every_command_has_examples_and_says_what_its_options_do() -> None:
    for group in (log_module.command, session_module.command):
        assert isinstance(group, click.Group)
        context = click.Context(group)
        commands = {name: group.get_command(context, name) for name in group.list_commands(context)}
        for name, command in {"": group, **commands}.items():
            assert command is not None
            assert "Examples:" in (command.epilog or ""), name
            for option in command.params:
                if isinstance(option, click.Option):
                    assert option.help or option.name == "form", (name, option.name)


def test_gait_of_a_tick_log_is_what_was_commanded(tmp_path: Path) -> None:
    gait = Gait.from_degrees(66, 80, 2)
    with RunWriter(tmp_path / "a", ROBOT, {"gait": gait_to_mapping(gait)}) as writer:
        writer.tick(Tick(0, 0.0, START_NS, np.zeros(5), np.zeros(5)))
    assert open_run(writer.path).gait == gait


def test_the_index_says_what_going_through_says(tmp_path: Path) -> None:
    path = write_everything(tmp_path / "a.mcap")
    quick, thorough = summarize(path), summarize(path, thorough=True)
    assert quick.duration_s >= thorough.duration_s > 0
    assert replace(quick, duration_s=0.0) == replace(thorough, duration_s=0.0)
    data = bytearray(path.read_bytes())
    for place in range(
        len(data) - 1200, len(data), 7
    ):  # whatever is wrong with the index: no error, nothing made up
        damaged = tmp_path / "damaged.mcap"
        damaged.write_bytes(data[:place] + bytes([data[place] ^ 0x55]) + data[place + 1 :])
        summary = summarize(damaged)
        assert (summary.ticks, summary.messages) == (thorough.ticks, thorough.messages)
    path.write_bytes(data[:-400])
    assert summarize(path).state == "damaged"


def test_list_shows_speed_fault_effect_and_end(tmp_path: Path, capsys: Capture) -> None:
    about: dict[str, dict[str, object]] = {
        "a": {"ended": "finished", "steady_speed_m_s": 0.131, "faults": ["free:3", "rigid:4@2s"]},
        "b": {
            "ended": "interrupted",
            "forward_speed_m_s": 0.2,
            "steady_speed_m_s": 0.1,
            "effects": ["backlash:x=1"],
        },
        "c": {"ended": "error: the board's watchdog " + 200 * "x", "effects": 7, "steady_speed_m_s": "fast"},
        "d": {"steady_speed_m_s": math.inf, "faults": {}},
    }
    for name, metadata in about.items():
        with RunWriter(tmp_path / name, ROBOT, metadata) as writer:
            writer.tick(make_ticks(1)[0])
    lines = snakebot(capsys, "log", "list", tmp_path).splitlines()
    cells = [dict(zip(lines[0].split(), re.split(r"  +", line), strict=True)) for line in lines[1:]]
    assert [cell["m/s"] for cell in cells] == ["0.131", "0.2", "-", "-"]
    assert [cell["fault"] for cell in cells] == ["free:3 rigid:4@2s", "-", "-", "-"]
    assert [cell["effect"] for cell in cells] == ["-", "backlash:x=1", "-", "-"]
    assert [cell["ended"][:18] for cell in cells] == ["finished", "interrupted", "error: the board's", "-"]
    assert max(map(len, lines)) < 220
    listed = json.loads(snakebot(capsys, "log", "list", tmp_path, "--json"))["logs"]
    assert [log["forward_speed_m_s"] for log in listed] == [0.131, 0.2, None, None]
    assert [str(log["ended"])[:11] for log in listed] == ["finished", "interrupted", "error: the ", "None"]


def test_check_takes_logs_and_folders_of_them_as_a_diagnosis_does(tmp_path: Path, capsys: Capture) -> None:
    for name, alpha_deg in (("a", 40.0), ("b", 40.0), ("c", 30.0)):
        wave_log(tmp_path / "runs" / f"{name}.mcap", alpha_deg, duration_s=4)
    checked = json.loads(snakebot(capsys, "session", "check", tmp_path / "runs", "--json"))
    assert [(run["run"], run["repeat_of"]) for run in checked["runs"]] == [
        ("a", None),
        ("b", "a"),
        ("c", None),
    ]
    one = tmp_path / "runs" / "a.mcap"
    assert snakebot(capsys, "session", "check", one).startswith(f"{one}: 5 joints with a body, 1 run\n")
    both = snakebot(capsys, "session", "check", one, tmp_path / "runs" / "c.mcap")
    assert ", 2 runs\n" in both
