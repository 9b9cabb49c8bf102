"""Runs of logs and sessions, opened by name, together, and with their repeats."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from runlog_samples import ROBOT, flushed, make_ticks, session_folder, write_everything

from snakebot.analysis import load
from snakebot.errors import BadInputError, LogError
from snakebot.runlog import LogWarning, Run, RunWriter, open_run, open_runs, open_session, write_session
from snakebot.runlog.listing import summarize
from snakebot.runlog.repeats import mark_repeats
from snakebot.runlog.run import Session


def test_logs_and_sessions_open_alike(tmp_path: Path) -> None:
    log = write_everything(tmp_path / "logs" / "one.mcap")
    write_everything(tmp_path / "logs" / "two.mcap")
    run = open_run(log)
    assert run.name == "one"
    write_session(tmp_path / "s", ROBOT, [run])
    np.testing.assert_array_equal(open_run(tmp_path / "s").command_rad, run.command_rad)
    np.testing.assert_array_equal(open_run(tmp_path / "s" / "one.csv").command_rad, run.command_rad)
    assert [r.name for r in open_session(tmp_path / "logs").runs] == ["one", "two"]
    together = open_runs([tmp_path / "s", log, tmp_path / "logs"])
    assert [r.name for r in together.runs] == ["one.csv", "one", "one-2", "two"]
    with pytest.raises(BadInputError, match="holds 2 runs; name one"):
        open_run(tmp_path / "logs")
    for nonsense in (tmp_path, tmp_path / "gone.mcap", tmp_path / "x.txt", tmp_path / "s" / "gone.csv"):
        with pytest.raises(BadInputError):
            open_session(nonsense)


def test_sessions_of_other_robots_do_not_mix(tmp_path: Path) -> None:
    write_everything(tmp_path / "one.mcap")
    with pytest.raises(BadInputError, match="1 joints, but"):
        open_runs([tmp_path / "one.mcap", session_folder(tmp_path / "s")])


def test_repeats_are_found(tmp_path: Path) -> None:
    t_s = np.arange(0, 5, 0.01)
    wave = np.sin(2 * t_s)[:, None] * np.ones(5)
    late = t_s + np.random.default_rng(0).uniform(0, 0.002, t_s.size)  # a loop's jitter
    runs = [
        Run("a", t_s, wave, wave),
        Run("b", late, np.sin(2 * late)[:, None] * np.ones(5), wave),
        Run("larger", t_s, 1.1 * wave, wave),
        Run("faulty", t_s, wave, wave, metadata={"faults": ["free:3"]}),
        Run("again", t_s + 7, wave, wave),
        Run("own", t_s, wave, wave, repeat_of="again"),
        Run("off", t_s, np.where(t_s[:, None] < 9, np.nan, wave), wave),
    ]
    assert [run.repeat_of for run in mark_repeats(runs)] == [None, "a", None, None, "a", "a", None]


def test_logs_without_ticks_are_left_out_and_told(tmp_path: Path) -> None:
    """Of runs that were refused: one of them made all the others unreadable."""
    for name in ("a", "z"):
        RunWriter(tmp_path / name, ROBOT).close()
    sound = write_everything(tmp_path / "m.mcap")
    left = [tmp_path / "a.mcap", sound, tmp_path / "z.mcap"]
    opening: list[Callable[[], Session]] = [lambda: open_session(tmp_path), lambda: open_runs(left)]
    for opened in opening:
        with pytest.warns(LogWarning, match="holds no ticks: left out") as told:
            session = opened()
        assert len(told) == 2
        assert [run.name for run in session.runs] == ["m"]
        assert len([note for note in session.warnings if "left out" in note]) == 2
    with pytest.warns(LogWarning, match="left out"):
        assert [item.run.name for item in load(left)] == ["m"]
    sound.unlink()
    failing: list[Callable[[], object]] = [lambda: open_session(tmp_path), lambda: load([left[0], left[2]])]
    for fails in failing:
        with pytest.warns(LogWarning), pytest.raises(BadInputError, match="none of these logs holds a tick"):
            fails()
    for one in (open_session, open_run, lambda path: load([path])):
        with pytest.raises(BadInputError, match="holds no ticks"):
            one(left[0])


def test_a_log_of_which_nothing_is_left_does_not_stop_the_others(tmp_path: Path) -> None:
    sound = write_everything(tmp_path / "m.mcap")
    cut = tmp_path / "cut.mcap.part"
    cut.write_bytes(sound.read_bytes()[:200])
    (tmp_path / "empty.mcap").touch()
    (tmp_path / "zeros.mcap").write_bytes(bytes(5000))
    with pytest.warns(LogWarning, match="is left: left out") as told:
        assert [run.name for run in open_session(tmp_path).runs] == ["m"]
    assert len(told) == 3
    with pytest.raises(LogError, match="too damaged"):
        open_session(cut)


@pytest.mark.parametrize(
    ("metadata", "complete", "ended", "aborted"),
    [
        ({"ended": "finished"}, True, "finished", False),
        ({"ended": "interrupted"}, True, "interrupted", True),
        ({"ended": "error: x"}, True, "error: x", True),
        ({}, True, None, False),
        ({"ended": 7}, True, None, False),
        ({"recovered": True}, True, "cut short", True),
        ({"recovered": True, "ended": "finished"}, True, "finished", False),
        ({}, False, "cut short", True),
    ],
)
def test_how_a_run_ended(
    tmp_path: Path, metadata: dict[str, object], complete: bool, ended: str | None, aborted: bool
) -> None:
    writer = RunWriter(tmp_path / "run", ROBOT, metadata)
    writer.tick(make_ticks(1)[0])
    if complete:
        writer.close()
        path = writer.path
    else:
        flushed(writer)
        path = Path(shutil.copy(writer.part_path, tmp_path / "copy.mcap.part"))
    run = open_run(path)
    assert (run.ended, run.aborted) == (ended, aborted)
    assert summarize(path).ended == ended
    writer.close()
