"""Names out of files and folders of strangers: nothing is written, and nobody is signalled, outside the own folder."""

from __future__ import annotations

import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from snakebot.cli.main import main
from snakebot.control import registry
from snakebot.effects import robot_effects
from snakebot.errors import BadInputError
from snakebot.robot import Robot, load_robot
from snakebot.runlog import Run, RunWriter, Telemetry, Tick, open_session, write_session

BENCH = Robot(name="../../robot", joints=1)
ZERO = np.zeros(1)
NAMES = [
    "../../x",
    "/tmp/x",
    "..",
    ".",
    "",
    "a/b",
    "\\\\host\\x",
    "~/x",
    "$(touch x)",
    "x\0y",
    "x\ny",
    "con.csv",
    "a" * 300,
]


def a_run(name: str, **more: Any) -> Run:
    column = np.zeros((3, 1))
    return replace(Run(name, np.arange(3.0), column, column), **more)


def everything(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


def snakebot(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return int(ended.value.code or 0)


def a_log(path: Path, readings: dict[str, float] | None = None, robot: Robot = BENCH) -> Path:
    with RunWriter(path, robot, start_time_ns=0) as writer:
        for count in range(3):
            writer.tick(Tick(count, count / 100, count, ZERO, ZERO, ZERO, ZERO, count, 0.001, False))
        writer.telemetry(Telemetry(0.0, readings or {"supply_v": 12.0}))
    return writer.path


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(names=st.lists(st.sampled_from(NAMES) | st.text(max_size=12), min_size=1, max_size=4, unique=True))
def test_runs_of_any_name_are_written_into_the_session(
    tmp_path_factory: pytest.TempPathFactory, names: list[str]
) -> None:
    outside = tmp_path_factory.mktemp("outside")
    folder = outside / "in" / "deep" / "session"
    try:
        write_session(folder, BENCH, [a_run(name) for name in names])
    except BadInputError:
        return  # a name that is too long for a file
    assert len(open_session(folder).runs) == len(names)
    assert {path for path in outside.rglob("*") if path.is_file()} == {
        path for path in folder.iterdir() if path.is_file()
    }
    assert len(list(folder.iterdir())) == len(names) + 1


@pytest.mark.parametrize(
    "name", ["../run.csv", "{outside}/run.csv", "link.csv", "folder/../../run.csv", "linked/run.csv"]
)
def test_a_session_reads_only_its_own_folder(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "session"
    (folder / "folder").mkdir(parents=True)
    (tmp_path / "run.csv").write_text("t_s,cmd_1_rad,enc_1_rad\n0,0,0\n")
    (folder / "link.csv").symlink_to(tmp_path / "run.csv")
    (folder / "linked").symlink_to(tmp_path)
    run = {"file": name.format(outside=tmp_path)}
    (folder / "session.yaml").write_text(json.dumps({"robot": {"joints": 1}, "runs": [run]}))
    with pytest.raises(BadInputError, match="leaves the session's folder"):
        open_session(folder)


@pytest.mark.parametrize("laid", [".mcap.tmp", ".mcap"])
def test_a_link_in_a_strangers_folder_is_not_written_through(tmp_path: Path, laid: str) -> None:
    """The name of the file that is about to be made is a link to one of mine."""
    mine = tmp_path / "mine"
    mine.write_text("dear")
    folder = tmp_path / "theirs"
    data = a_log(tmp_path / "log").read_bytes()
    folder.mkdir()
    (folder / "run.mcap.part").write_bytes(data)
    (folder / f"run{laid}").symlink_to(mine)
    snakebot("log", "recover", folder / "run.mcap.part")
    assert mine.read_text() == "dear"


EFFECTS = [
    "{secret}",
    "{secret}:width_deg=1",
    "secret.yaml",
    "../secret",
    "file://{secret}",
    "worn_servo.yaml",
    "",
]


@pytest.mark.parametrize("named", EFFECTS)
@pytest.mark.parametrize("kind", ["session", "log"])
def test_effects_in_a_strangers_description_are_names_and_no_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, kind: str, named: str
) -> None:
    """Whatever the file holds, even sound effects: it is not opened, and nothing of it is told."""
    monkeypatch.chdir(tmp_path)
    secret = tmp_path / "secret.yaml"
    secret.write_text("effects: ['encoder_offset:offset_deg=1', password]\n")
    (tmp_path / "worn_servo.yaml").write_text(secret.read_text())
    robot = replace_effects(BENCH, named.format(secret=secret))
    path = tmp_path / "theirs"
    if kind == "session":
        t_s = np.arange(0.0, 5.0, 0.02)
        angle = 0.5 * np.sin(2 * t_s)[:, None]
        write_session(path, robot, [Run(name, t_s, angle, 0.9 * angle) for name in "ab"])
        command: tuple[object, ...] = ("diagnose", path, "--quick")
    else:
        path = a_log(path, robot=robot)
        command = ("log", "replay", path, "--dry-run")
    opened: list[str] = []
    _opened.append(opened)
    try:
        assert snakebot(*command) == 2
    finally:
        _opened.remove(opened)
    assert "secret.yaml" not in " ".join(opened)
    said = capsys.readouterr().err
    assert "effects: no effect is called" in said
    assert "password" not in said


def test_a_description_may_name_the_sets_that_come_with_snakebot() -> None:
    wide = load_robot("penn_state").model_copy(update={"effects": ("worn_servo", "backlash:width_deg=2")})
    assert [spec.name for spec in robot_effects(wide)] == [
        "backlash",
        "rate_limit",
        "servo_offset",
        "backlash",
    ]


_opened: list[list[str]] = []


@pytest.fixture(autouse=True, scope="module")
def _hear_of_open_files() -> None:
    def hear(event: str, args: tuple[object, ...]) -> None:
        if event == "open" and _opened:
            _opened[-1].append(str(args[0]))

    sys.addaudithook(hear)


def replace_effects(robot: Robot, name: str) -> Robot:
    return robot.model_copy(update={"effects": (name,)})


@pytest.mark.parametrize("name", ["out.csv", "out.csv.gz", "out.parquet", "robot.yaml", "out"])
@pytest.mark.parametrize("there", [False, True])
def test_an_export_does_not_go_through_a_link(tmp_path: Path, name: str, there: bool) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    if there:
        (elsewhere / name).write_text("dear")
    log = a_log(tmp_path / "log")
    (tmp_path / name).symlink_to(elsewhere / name)
    assert snakebot("log", "export", log, tmp_path / name) == 2
    assert everything(elsewhere) == ({name} if there else set())
    assert (tmp_path / name).is_symlink()


def test_what_a_log_calls_its_readings_stays_in_the_header(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A name with a line end in it would else be rows of anybody's numbers."""
    names = ["a,b", "c\n9,9,9,9", 'd"e', "=1+1", "../x"]
    log = a_log(tmp_path / "in" / "log", dict.fromkeys(names, 1.0))
    out = tmp_path / "out"
    assert snakebot("log", "export", log, out) == 0
    assert snakebot("log", "export", log, tmp_path / "in" / "log.csv") == 0
    capsys.readouterr()
    with pytest.warns(UserWarning, match="unknown columns"):
        (run,) = open_session(out).runs
    assert len(run.t_s) == 3
    assert everything(tmp_path) == {
        "in",
        "in/log.mcap",
        "in/log.csv",
        "out",
        "out/session.yaml",
        "out/log.csv",
    }


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="one user a machine")
def test_what_others_lay_in_the_temporary_folder_gets_no_signal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """/tmp is everybody's: a file there says which process `snakebot stop` signals."""
    monkeypatch.setattr(registry, "SHARED", (tmp_path,))
    with registry.registered("sim:"):
        (run,) = registry.running()
        assert run.pid == os.getpid()
        shared = tmp_path / f"snakebot-{os.getuid()}"
        shared.chmod(0o777)
        assert registry.running() == []
        shared.chmod(0o755)
        elsewhere = tmp_path / "elsewhere"
        shared.rename(elsewhere)
        shared.symlink_to(elsewhere)
        assert registry.running() == []
        before = everything(tmp_path)
        with registry.registered("sim:"):
            assert everything(tmp_path) == before
