"""A joint that does not answer for a while is told with the times; one that lags, waits or turns round is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from snakebot.analysis.standstill import standstill_lines, standstills
from snakebot.arrays import Floats
from snakebot.robot import load_robot
from snakebot.runlog import Run

ROBOT = load_robot("penn_state")
COUNT = ROBOT.rad_per_count
T_S = np.arange(0, 12, 0.01)


def run_of(command: Floats, measured: Floats, name: str = "run") -> Run:
    """One joint beside four that rest."""
    rest = np.zeros((T_S.size, 4))
    seen = np.round(np.column_stack([measured, rest]) / COUNT) * COUNT
    return Run(name=name, t_s=T_S, command_rad=np.column_stack([command, rest]), measured_rad=seen)


def sine(t_s: Floats) -> Floats:
    return np.asarray(0.6 * np.sin(2 * t_s))


def loose() -> Run:
    """Unplugged from 4 to 9 s."""
    away = (T_S >= 4) & (T_S < 9)
    return run_of(sine(T_S), np.where(away, sine(np.array(4.0)), sine(T_S - 0.05)), "loose")


def test_a_joint_that_is_unplugged_for_a_while_is_told_with_the_times() -> None:
    (found,) = standstills(loose(), ROBOT)
    assert found.joint == 0
    assert found.start_s == pytest.approx(4.0, abs=0.06)
    assert found.end_s == pytest.approx(9.0, abs=0.06)
    assert np.degrees(found.told_rad) == pytest.approx(68.8, abs=0.1)
    (line,) = standstill_lines([run_of(sine(T_S), sine(T_S - 0.05)), loose()], ROBOT)
    assert line == (
        "loose: from 4.0 to 9.0 s joint 1 is told to move by 68.8 deg and its reading does not change: "
        "a loose plug, a servo that switched off, or a stop?"
    )


def test_more_stretches_of_a_joint_are_counted() -> None:
    (line,) = standstill_lines([loose(), replace(loose(), name="again")], ROBOT)
    assert "(and 1 more such stretch)" in line


def test_lost_readings_and_no_commands_are_no_standstill() -> None:
    run = loose()
    away = ((T_S >= 4) & (T_S < 9))[:, None]
    assert standstills(replace(run, measured_rad=np.where(away, np.nan, run.measured_rad)), ROBOT) == []
    assert standstills(replace(run, command_rad=np.where(away, np.nan, run.command_rad)), ROBOT) == []


@pytest.mark.parametrize(
    "measured",
    [
        sine(T_S - 0.2),
        sine(T_S) + 0.3,
        np.clip(sine(T_S), -0.55, 0.55),
        np.zeros_like(T_S),  # over the whole run: told as a dead joint
    ],
)
def test_a_joint_that_only_trails_or_was_never_there_has_no_stretch(measured: Floats) -> None:
    assert standstills(run_of(sine(T_S), measured), ROBOT) == []


def test_steps_with_long_waits_are_no_standstill() -> None:
    def steps(t_s: Floats) -> Floats:
        return np.asarray(0.7 * np.sign(np.sin(1.5 * t_s + 0.01)))

    assert standstills(run_of(steps(T_S), steps(T_S - 0.15)), ROBOT) == []


def test_a_run_of_no_samples_or_one() -> None:
    for count in (0, 1, 2):
        run = loose()
        cut = replace(
            run, t_s=T_S[:count], command_rad=run.command_rad[:count], measured_rad=run.measured_rad[:count]
        )
        assert standstills(cut, ROBOT) == []
