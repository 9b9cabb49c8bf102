"""Outputs: whole or not at all, over nothing but an earlier one of its kind; also where nobody reads."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from snakebot.cli.main import main
from snakebot.control import RunLoop
from snakebot.errors import BadInputError, BoardFaultError, LostBoardError, SnakebotError
from snakebot.robot import robot_from_mapping
from snakebot.runlog import Run, read_log, write_session
from snakebot.runlog.listing import summarize
from snakebot.runlog.session_write import write_table
from snakebot.whole_files import check_apart, check_output, replacing, write_all

SNAKEBOT = [sys.executable, "-m", "snakebot.cli.main"]


@pytest.fixture
def session(tmp_path: Path) -> Path:
    t_s = np.arange(0, 8, 0.02)
    angle = 0.5 * np.sin(2 * t_s)[:, None]
    runs = [Run(name, t_s, angle, angle) for name in ("a", "b")]
    return write_session(tmp_path / "session", robot_from_mapping({"joints": 1}, "test"), runs)


@pytest.mark.parametrize("option", ["--report", "--json", "--apply"])
@pytest.mark.parametrize("other", ["session.yaml", "a.csv", "log.mcap"])
def test_nothing_is_written_over_something_else(
    session: Path, option: str, other: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (session / "log.mcap").write_bytes(b"\x89MCAP0\r\n")
    target = session / other
    before = target.read_bytes()
    for command in ["diagnose"] + ["analyze"] * (option == "--report"):
        with pytest.raises(SystemExit) as ended:
            main([command, str(session), option, str(target)])
        assert ended.value.code == 2
        assert f"{option} {target}: exists, and is no" in capsys.readouterr().err
        assert target.read_bytes() == before


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("report", "<!DOCTYPE html>\n<html>"),
        ("JSON", '{"schema": 1}'),
        ("robot", "schema: snakebot.robot/1\n"),
    ],
)
def test_an_earlier_one_of_its_kind_gives_way(tmp_path: Path, kind: str, text: str) -> None:
    path = tmp_path / "out"
    check_output("--x", path, kind)
    for sound in (text, ""):
        path.write_text(sound)
        check_output("--x", path, kind)
    path.write_text("t_s,cmd_1_rad\n")
    with pytest.raises(BadInputError, match=f"is no {kind}"):
        check_output("--x", path, kind)


def test_two_outputs_in_one_file_are_refused(tmp_path: Path) -> None:
    check_apart([("--json", tmp_path / "a"), ("--report", tmp_path / "b")])
    with pytest.raises(BadInputError, match=r"--report .*is the file of --json"):
        check_apart([("--json", tmp_path / "a"), ("--report", tmp_path / ".." / tmp_path.name / "a")])


def full_disk(*_: object, **__: object) -> int:
    raise OSError(28, "No space left on device")


def test_a_full_disk_leaves_what_was_there(
    tmp_path: Path, session: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = tmp_path / "old.html"
    old.write_text("<!doctype html>")
    run = Run("a", np.array([0.0, 1.0]), np.zeros((2, 1)), np.zeros((2, 1)))
    robot = robot_from_mapping({"joints": 1}, "test")
    there = sorted(tmp_path.rglob("*"))
    monkeypatch.setattr(Path, "write_text", full_disk)
    monkeypatch.setattr(Path, "write_bytes", full_disk)
    attempts: list[Callable[[], object]] = [
        lambda: write_all([(old, "new"), (tmp_path / "more.json", "{}")]),
        lambda: write_table(tmp_path / "a.csv", {"t_s": np.zeros(2)}),
        lambda: write_session(tmp_path / "new_session", robot, [run]),
    ]
    for attempt in attempts:
        with pytest.raises((OSError, BadInputError), match="No space left"):
            attempt()
    assert sorted(tmp_path.rglob("*")) == there
    assert old.read_text() == "<!doctype html>"


def test_a_full_disk_is_status_6_and_a_place_that_is_none_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(BadInputError, match="cannot be written") as wrong:
        write_all([(tmp_path / "nowhere" / "a.json", "{}")])
    assert wrong.value.exit_status == 2
    monkeypatch.setattr(Path, "write_text", full_disk)
    with pytest.raises(BadInputError, match="No space left") as full:
        write_all([(tmp_path / "a.json", "{}")])
    assert full.value.exit_status == 6


def test_a_device_is_not_replaced() -> None:
    with replacing(Path(os.devnull)) as handed_out:
        assert handed_out == Path(os.devnull)
    assert Path(os.devnull).is_char_device()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize("words", [["--help"], ["analyze"]])
def test_standard_output_that_cannot_be_written_is_one_line(session: Path, words: list[str]) -> None:
    more = [str(session)] if words == ["analyze"] else []
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [*SNAKEBOT, *words, *more], stdout=full, stderr=subprocess.PIPE, text=True, timeout=100
        )
    assert done.returncode == 6
    assert done.stderr.splitlines()[-1] == (
        "snakebot: standard output cannot be written: No space left on device"
    )
    assert "Traceback" not in done.stderr


def test_a_reader_that_goes_away_is_no_error(session: Path) -> None:
    done = subprocess.Popen(
        [*SNAKEBOT, "analyze", str(session)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert done.stdout is not None
    assert done.stderr is not None
    done.stdout.close()
    assert done.wait(100) == 0
    assert done.stderr.read() == ""
    done.stderr.close()


@pytest.mark.parametrize("words", ["gait list", "run --alpha 40 --beta 80 --omega 3 --duration 5 --fast"])
def test_an_output_that_is_closed_is_no_error(words: str, tmp_path: Path) -> None:
    """As ``>&-`` leaves it: Python then has no standard output at all."""
    shell = f"{shlex.join(SNAKEBOT)} {words} >&-"
    done = subprocess.run(["sh", "-c", shell], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, "error" in done.stderr) == (0, False), done.stderr


RUN = ["run", "--alpha", "40", "--beta", "80", "--omega", "3", "--duration", "5", "--fast"]


@pytest.mark.parametrize("more", [[], ["--dry-run"]])
def test_a_reader_that_goes_is_no_failure_of_the_run(tmp_path: Path, more: list[str]) -> None:
    """As ``| head -1``: the table is longer than what is read."""
    inside, outside = os.pipe()
    os.close(inside)
    with open(outside, "wb") as nobody:
        done = subprocess.run(
            [*SNAKEBOT, *RUN, *more], stdout=nobody, stderr=subprocess.PIPE, cwd=tmp_path, timeout=100
        )
    assert done.returncode == 0, done.stderr
    assert b"Traceback" not in done.stderr
    assert len(list(tmp_path.glob("runs/*.mcap"))) == (0 if "--dry-run" in more else 1)


@pytest.mark.parametrize(
    ("words", "status"), [(["run", "--alpha", "600", "--beta", "80", "--omega", "3"], 2), (["nonsense"], 2)]
)
def test_an_error_that_nobody_reads_keeps_its_status(words: list[str], status: int) -> None:
    inside, outside = os.pipe()
    os.close(inside)
    with open(outside, "wb") as nobody:
        done = subprocess.run([*SNAKEBOT, *words], stdout=nobody, stderr=nobody, timeout=100)
    assert done.returncode == status


@pytest.mark.parametrize(
    "error", [BoardFaultError("refused"), LostBoardError("gone"), KeyboardInterrupt(), ZeroDivisionError()]
)
@pytest.mark.parametrize("ticks", [0, 1])
def test_a_run_that_ended_before_its_first_set_point_keeps_no_log(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    error: BaseException,
    ticks: int,
) -> None:
    monkeypatch.chdir(tmp_path)

    def refused(loop: RunLoop) -> None:
        loop.progress.ticks = ticks
        raise error

    monkeypatch.setattr(RunLoop, "run", refused)
    with pytest.raises(SystemExit) as ended:
        main(RUN)
    assert ended.value.code not in (0, None)
    logs = [path for path in (tmp_path / "runs").iterdir() if path.is_file()]
    assert len(logs) == ticks
    assert ("log up to there" in capsys.readouterr().err) == bool(ticks)
    for log in logs:
        said = read_log(log).metadata["ended"]
        assert said == f"error: {error if isinstance(error, SnakebotError) else type(error).__name__}"


def test_the_speed_of_a_run_is_kept_with_its_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([*RUN[:-3], "--duration", "10", "--fast", "--json", "--log", str(tmp_path / "a.mcap")])
    told = json.loads(capsys.readouterr().out)["forward_speed_m_s"]
    assert told > 0.05
    log = read_log(tmp_path / "a.mcap")
    assert log.metadata["steady_speed_m_s"] == told
    assert log.forward_speed_m_s is None  # nobody measured it
    assert summarize(log.path).speed_m_s == told
