"""Readings that wrap at 180 deg run on; steps, lone bad readings and holes in a log are left as they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sessions import bench, make_session

from snakebot.arrays import Floats
from snakebot.diagnosis import diagnose
from snakebot.diagnosis.evidence.turns import run_on
from snakebot.runlog import Run, Session

T_S = np.arange(0, 6, 0.02)
WIDE = np.column_stack([3.6 * np.sin(1.5 * T_S), 0.3 * np.sin(T_S)])


def wrapped(angle_rad: Floats) -> Floats:
    return np.asarray((angle_rad + np.pi) % (2 * np.pi) - np.pi)


def session_of(*runs: tuple[Floats, Floats]) -> Session:
    """Commands and readings a run."""
    return Session(
        bench(2),
        tuple(
            Run(name=f"run_{i}", t_s=T_S, command_rad=command, measured_rad=measured)
            for i, (command, measured) in enumerate(runs)
        ),
    )


def test_wrapped_readings_run_on_and_are_told_with_joint_run_and_time() -> None:
    found, lines = run_on(session_of((0.5 * WIDE, 0.5 * WIDE), (WIDE, wrapped(WIDE))))
    for run, truth in zip(found.runs, (0.5 * WIDE, WIDE), strict=True):
        assert run.measured_rad == pytest.approx(truth)
    (line,) = lines
    assert line.startswith("joint 1: the reading jumps by a whole turn 6 times, first in run_1 at 0.7 s")


def test_commands_that_wrap_with_the_readings_run_on_too() -> None:
    found, _ = run_on(session_of((wrapped(WIDE), wrapped(WIDE))))
    assert found.runs[0].command_rad == pytest.approx(WIDE)
    assert found.runs[0].measured_rad == pytest.approx(WIDE)


def test_a_run_that_begins_in_another_turn_is_put_beside_the_others() -> None:
    """An encoder that is off by nearly half a turn reads 176 deg in one run and -178 deg in the next."""
    command = 0.2 * WIDE
    readings = [wrapped(command + np.radians([176, 0])), wrapped(command + np.radians([183, 0]))]
    found, _ = run_on(session_of(*((command, reading) for reading in readings)))
    off = [np.degrees(np.mean(run.measured_rad - run.command_rad, axis=0)[0]) for run in found.runs]
    assert off == pytest.approx([176, 183])


def test_steps_bad_readings_and_holes_are_no_turn() -> None:
    steps = np.column_stack([2.3 * np.sign(np.sin(T_S)), 0 * T_S])
    spoilt = 0.5 * WIDE
    spoilt[100, 0] += 3.0
    for measured in (steps, spoilt):
        session = session_of((WIDE, measured))
        assert run_on(session) == (session, [])
    kept = np.abs(WIDE[:, 0]) < 2.8
    session = session_of((WIDE, wrapped(WIDE)))
    run = session.runs[0]
    hole = replace(run, t_s=T_S[kept], command_rad=WIDE[kept], measured_rad=wrapped(WIDE)[kept])
    assert run_on(replace(session, runs=(hole,)))[1] == []


def test_a_late_joint_that_passes_180_deg_is_still_called_late() -> None:
    session = make_session(
        bench(1), ["command_delay:delay_s=0.06"], gaits=((170, 0, 2.0), (200, 0, 1.0), (40, 0, 3.0))
    )
    spoilt = tuple(replace(run, measured_rad=wrapped(run.measured_rad)) for run in session.runs)
    found = diagnose(replace(session, runs=spoilt), quick=True, only=["command_delay", "servo_lag"])
    assert [cause.effect for cause in found.causes] == ["command_delay"]
    assert any("joint 1: the reading jumps by a whole turn" in line for line in found.warnings)
