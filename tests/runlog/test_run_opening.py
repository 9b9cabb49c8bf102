"""Runs of logs and sessions, opened by name, together, and with their repeats."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from runlog_samples import ROBOT, session_folder, write_everything

from snakebot.errors import BadInputError
from snakebot.runlog import Run, open_run, open_runs, open_session, write_session
from snakebot.runlog.repeats import mark_repeats


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
