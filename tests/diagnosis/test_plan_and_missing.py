"""``snakebot session plan`` and ``snakebot session check``: before recording, and after."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from sessions import bench, make_run, make_session, snake

from snakebot.cli.main import main
from snakebot.cli.session import command
from snakebot.diagnosis import live
from snakebot.diagnosis.live import numbered
from snakebot.diagnosis.missing import missing
from snakebot.diagnosis.plan import plan
from snakebot.diagnosis.proposal import menu
from snakebot.diagnosis.proposal.motions import Motions, WrittenGait
from snakebot.gait import Gait
from snakebot.robot import load_robot
from snakebot.runlog import Session, write_session


def both(pairs: tuple[tuple[str, str], ...], *names: str) -> bool:
    return any(set(pair) == set(names) for pair in pairs)


@pytest.mark.slow
def test_gaits_of_one_frequency_do_not_part_delay_and_lag_those_of_several_do() -> None:
    robot = bench(1)
    narrow = plan(robot, [Gait.from_degrees(4, 80, 0.5, 0)])
    assert both(narrow.tied, "command_delay", "servo_lag")
    assert "rate_limit" in narrow.hidden
    assert any(both(run.parts, "command_delay", "servo_lag") for run in narrow.added)
    wide = plan(robot)
    assert both(wide.parted, "command_delay", "servo_lag")
    assert both(wide.parted, "rate_limit", "servo_lag")
    assert "rate_limit" in wide.shown
    assert both(wide.left, "servo_offset", "encoder_offset")
    assert both(wide.left, "command_gain", "encoder_gain")  # though their examples are far from each other
    assert wide.channel is not None
    assert wide.duration_s > 12 * len(wide.experiments)


def test_where_the_menu_holds_nothing_no_run_is_added(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(menu, "known_motions", lambda: Motions((), (), (), ()))
    found = plan(bench(1), [Gait.from_degrees(4, 80, 0.5, 0)])
    assert found.tied
    assert found.added == ()


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_pose_parts_what_angles_do_not() -> None:
    gaits = [Gait.from_degrees(50, 80, 2.0, 0), Gait.from_degrees(30, 80, 4.0, 0)]
    without, with_pose = plan(snake(), gaits), plan(snake(), gaits, pose=True)
    assert both(without.tied, "command_gain", "encoder_gain")
    assert both(with_pose.parted, "command_gain", "encoder_gain")
    assert "ground_friction" in with_pose.shown
    assert "ground_friction" not in without.shown


def call(*words: object) -> Result:
    return CliRunner().invoke(command, [str(w) for w in words], catch_exceptions=True)


def test_the_commands_of_a_plan_can_be_pasted(tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(bench(1).to_yaml())
    words = ("plan", path, "--gait", "40,80,2", "--port", "serial:/dev/ttyUSB0", "--folder", "new runs")
    shown = call(*words)
    assert shown.exit_code == 0, shown.output
    lines = [line for line in shown.output.splitlines() if line and not line.startswith("#")]
    assert lines[0] == "mkdir -p 'new runs'"
    assert lines[-1] == "snakebot diagnose 'new runs'"
    wanted = f"--robot {path} --port serial:/dev/ttyUSB0 --log 'new runs/run_01.mcap'"
    assert lines[1].startswith("snakebot run --alpha 40 --beta 80 --omega 2 ")
    assert lines[1].endswith(wanted)
    data = json.loads(call(*words, "--json").output)
    assert data["commands"] == lines[1:3]
    assert [run["command"] for run in data["added"]] == lines[3:-1]


def test_the_command_of_a_run_bends_as_its_gait_does() -> None:
    bent, straight = numbered([Gait.from_degrees(50, 80, 2, 5), Gait.from_degrees(50, 80, 2)])
    assert "--omega 2 --offset 5 --duration" in bent.command
    assert "--offset" not in straight.command


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("plan", "nobody"), "nobody"),
        (("plan", "penn_state", "--gait", "40"), "ALPHA,BETA,OMEGA"),
        (("plan", "penn_state", "--gait", "400,80,2"), "angle"),
        (("plan", "penn_state", "--gait", "nan,80,2"), "finite|number"),
        (("plan", "penn_state", "--gait", "40,80,2", "--gait", "40,80,2"), "twice"),
        (("plan", "penn_state", "--port", "pigeon:1"), "pigeon"),
    ],
)
def test_a_plan_of_nonsense_is_one_line(words: tuple[str, ...], said: str) -> None:
    import re

    result = call(*words)
    assert type(result.exception).__name__ == "BadInputError", result.output
    assert re.search(said, str(result.exception))


GOOD = ((66, 80, 2.0), (30, 80, 4.0), (4, 80, 0.5))


def kinds(session: Session) -> set[str]:
    return {lack.kind for lack in missing(session)}


def test_a_whole_session_lacks_nothing() -> None:
    assert not kinds(make_session(bench(), gaits=GOOD, duration_s=10.0))


def test_each_lack_is_named_with_a_command() -> None:
    robot = bench()
    whole = make_session(robot, gaits=GOOD, duration_s=10.0)
    first = whole.runs[0]
    assert kinds(Session(robot, whole.runs[:3])) == {"no repeat"}
    assert kinds(Session(robot, (first, whole.runs[3]))) == {"few motions", "no small motion"}
    short = make_run(robot, (), GOOD[0], "short", duration_s=4.0)
    assert "short run" in kinds(Session(robot, (*whole.runs, short)))
    still = [replace(run, measured_rad=run.measured_rad * (1.0, 0.0)) for run in whole.runs]
    (lack,) = [m for m in missing(Session(robot, tuple(still)), port="can:x") if m.kind == "still joint"]
    assert "joint 2 never moves" in lack.text
    assert lack.command == "snakebot doctor can:x"
    idle = [replace(run, command_rad=run.command_rad * (0.0, 1.0)) for run in whole.runs]
    assert any("joints=1" in lack.command for lack in missing(Session(robot, tuple(idle))))
    reading = first.measured_rad.copy()
    reading[::20] = np.nan
    assert kinds(Session(robot, (replace(first, measured_rad=reading), *whole.runs[1:]))) == {"lost samples"}
    jitter = first.t_s + 0.004 * np.random.default_rng(0).random(first.t_s.size)
    assert kinds(Session(robot, (replace(first, t_s=jitter), *whole.runs[1:]))) == {"clock"}
    again = missing(Session(robot, whole.runs[:3]), robot="my.yaml", port="serial:x")
    assert again[0].command == (
        "snakebot run --alpha 66 --beta 80 --omega 2 --duration 12 --robot my.yaml --port serial:x"
    )


def test_a_small_motion_is_the_smallest_of_the_starting_set(monkeypatch: pytest.MonkeyPatch) -> None:
    wide, small = WrittenGait(50, 80, 2.0), WrittenGait(3, 80, 0.5)
    monkeypatch.setattr(live, "known_motions", lambda: Motions((wide, small), (), (), ()))
    whole = make_session(bench(), gaits=GOOD, duration_s=10.0)
    (lack,) = missing(Session(whole.robot, (whole.runs[0], whole.runs[1], whole.runs[3])))[1:]
    assert lack.kind == "no small motion"
    assert lack.command.startswith("snakebot run --alpha 3 ")


def test_a_body_without_a_pose_is_told() -> None:
    robot = load_robot("penn_state")
    bare = make_session(robot, gaits=GOOD, duration_s=8.0)
    assert "no pose" in kinds(bare)
    measured = [replace(run, forward_speed_m_s=0.1) for run in bare.runs]
    assert "no pose" not in kinds(Session(robot, tuple(measured)))


def test_the_check_of_a_session_tells_what_is_missing(tmp_path: Path) -> None:
    whole = make_session(bench(1), gaits=GOOD[:1], duration_s=10.0)
    write_session(tmp_path / "s", whole.robot, whole.runs[:1], "csv")
    shown = call("check", tmp_path / "s", "--port", "serial:/dev/ttyUSB0")
    assert shown.exit_code == 0, shown.output
    assert "missing: no motion is recorded twice" in shown.output
    assert "  snakebot run --alpha 66" in shown.output
    data = json.loads(call("check", tmp_path / "s", "--json").output)
    assert {lack["kind"] for lack in data["missing"]} == {"few motions", "no repeat", "no small motion"}


def test_many_short_runs_are_one_line_with_a_command_that_can_be_pasted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for number in range(9):
        rows = "".join(f"{t / 50},{0.3 * np.sin(t / (9 + number))},0\n" for t in range(150 + number))
        (tmp_path / f"r{number}.csv").write_text("t_s,cmd_1_rad,enc_1_rad\n" + rows)
    files = "".join(f"  - {{file: r{number}.csv}}\n" for number in range(9))
    (tmp_path / "session.yaml").write_text(f"robot: {{joints: 1, name: our_bench}}\nruns:\n{files}")
    with pytest.raises(SystemExit):
        main(["session", "check", str(tmp_path)])
    out = capsys.readouterr().out
    assert out.count("10 to 20 s tell more") == 1
    assert "r0.csv and 8 more: 2.98 to 3.14 s" in out
    assert "--robot our_bench" not in out  # no command knows it by this name
    assert "--robot ROBOT.yaml --port PORT" in out  # a run of the simulation would be none of this robot


@pytest.mark.parametrize("command", [["session", "check"], ["diagnose"]])
def test_an_effect_of_the_robot_that_is_none_is_refused(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "".join(f"{t / 50},{0.3 * np.sin(t / 9)},{0.2 * np.sin(t / 9)}\n" for t in range(150))
    (tmp_path / "r.csv").write_text("t_s,cmd_1_rad,enc_1_rad\n" + rows)
    (tmp_path / "session.yaml").write_text(
        "robot: {joints: 1, effects: [backlahs]}\nruns:\n  - {file: r.csv}\n"
    )
    with pytest.raises(SystemExit) as ended:
        main([*command, str(tmp_path)])
    assert ended.value.code == 2
    assert "did you mean backlash?" in capsys.readouterr().err


def test_runs_of_a_robot_in_another_state_or_broken_off_are_told() -> None:
    session = make_session(bench(1), duration_s=9.0)
    sound, odd, half, *rest = session.runs
    odd = replace(odd, metadata={"faults": ["free:1"], "effects": ["rate_limit:limit_rad_s=1"]})
    half = replace(half, metadata={"ended": "interrupted: Ctrl-C"})
    found = {one.kind: one for one in missing(replace(session, runs=(sound, odd, half, *rest)))}
    assert f"{odd.name}: fault free:1, effect rate_limit:limit_rad_s=1" in found["mixed runs"].text
    assert half.name in found["aborted run"].text
    assert f" {sound.name.removesuffix('.csv')}.mcap" in found["mixed runs"].command
    assert ".csv" not in found["mixed runs"].command
    assert odd.name.removesuffix(".csv") not in found["mixed runs"].command
    assert half.name.removesuffix(".csv") not in found["aborted run"].command
    assert not {"mixed runs", "aborted run"} & {one.kind for one in missing(session)}


def test_one_motion_alone_is_said_in_good_english() -> None:
    session = make_session(bench(1), gaits=[(40, 80, 2.0)], duration_s=9.0)
    (found,) = (one for one in missing(session) if one.kind == "few motions")
    assert found.text.startswith("one motion alone: ")
