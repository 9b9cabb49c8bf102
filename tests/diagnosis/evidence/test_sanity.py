"""What a diagnosis doubts about a session before it fits anything."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.cli.main import main
from snakebot.diagnosis import diagnose
from snakebot.runlog import Session, write_session


def with_a_dead_joint() -> Session:
    session = make_session(bench(2), duration_s=4.0)
    for run in session.runs:
        run.measured_rad[:, 1] = 0.2
    return session


def test_a_diagnosis_and_a_check_of_a_session_tell_a_dead_joint_in_the_same_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = with_a_dead_joint()
    said = [
        w for w in diagnose(session, only=("servo_offset",), quick=True).warnings if "joint 2 is told" in w
    ]
    assert len(said) == 1
    assert said[0].startswith("every run: joint 2 is told to move by ")
    write_session(tmp_path / "s", session.robot, session.runs)
    with pytest.raises(SystemExit):
        main(["session", "check", str(tmp_path / "s")])
    assert said[0] in capsys.readouterr().out


def test_a_swapped_pair_is_doubted_and_a_sound_robot_is_not() -> None:
    session = make_session(bench(3), duration_s=4.0)
    swapped = replace(
        session, runs=tuple(replace(run, measured_rad=run.measured_rad[:, [1, 0, 2]]) for run in session.runs)
    )
    (line,) = [
        w for w in diagnose(swapped, only=("servo_offset",), quick=True).warnings if "channels swapped" in w
    ]
    assert line.startswith("every run: joints 1 and 2")
    sound = diagnose(session, only=("servo_offset",), quick=True)
    assert not [w for w in sound.warnings if "swapped" in w or "does not change" in w]
    assert np.isfinite(sound.closure.joint_angle.rms_before)
