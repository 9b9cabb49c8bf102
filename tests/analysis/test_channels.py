"""Dead and swapped channels are told; a robot that only lags, plays or rubs is not doubted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from snakebot.analysis import analyze_run
from snakebot.analysis.channels import channel_doubts, dead_joints, doubts_of_runs, swapped_joints
from snakebot.control import RunSettings, open_board, plan_run, record
from snakebot.gait import Gait, GaitMotion, parse_probe
from snakebot.robot import load_robot
from snakebot.runlog import Run

ROBOT = load_robot("penn_state")
COUNT = ROBOT.rad_per_count


def run_of(gait: Gait, lag_s: float = 0.08, order: tuple[int, ...] = (0, 1, 2, 3, 4)) -> Run:
    """A run whose readings trail; reading j is what the joint ``order[j]`` does."""
    t_s = np.arange(0, 12, 0.01)
    motion = GaitMotion(gait, 5, 12.0, 2.0)
    command, late = motion.sampled(t_s), motion.sampled(t_s - lag_s)
    measured = np.round(late / COUNT) * COUNT
    return Run(name="run", t_s=t_s, command_rad=command, measured_rad=measured[:, order])


def test_a_swapped_pair_is_told_once() -> None:
    run = run_of(Gait.from_degrees(40, 80, 2), order=(0, 3, 2, 1, 4))
    (doubt,) = channel_doubts(run, ROBOT)
    assert doubt.text == (
        "joints 2 and 4: each reading follows the other's command: are their channels swapped?"
    )
    assert doubt.text in analyze_run(run, ROBOT, predict=False).warnings


def test_a_dead_joint_is_told_with_how_far_it_should_have_moved() -> None:
    run = run_of(Gait.from_degrees(40, 80, 2))
    run.measured_rad[:, 2] = 0.1
    (doubt,) = channel_doubts(run, ROBOT)
    assert doubt.text.startswith("joint 3 is told to move by 80 deg and its reading does not change")
    run.measured_rad[:, 2] = np.nan
    assert len(channel_doubts(run, ROBOT)) == 1


def test_of_several_runs_each_joint_is_told_once_with_the_runs_that_show_it() -> None:
    runs = [run_of(Gait.from_degrees(alpha, 80, 2)) for alpha in (30, 40, 20)]
    for run in runs[:2]:
        run.measured_rad[:, 2] = 0.1
    named = [replace(run, name=f"{number}.csv") for number, run in enumerate(runs)]
    (line,) = doubts_of_runs(named, ROBOT)
    assert line.startswith("0.csv, 1.csv: joint 3 is told to move by 80 deg")
    (line,) = doubts_of_runs(named[:2], ROBOT)
    assert line.startswith("every run: joint 3")
    assert doubts_of_runs(named[2:], ROBOT) == []


def test_a_probe_of_one_joint_shows_a_swap_with_one_that_is_to_stand_still() -> None:
    t_s = np.arange(0, 10, 0.01)
    command = np.zeros((t_s.size, 5))
    command[:, 2] = 0.3 * np.sin(t_s)
    measured = command[:, [0, 1, 3, 2, 4]]
    assert swapped_joints(command, measured, COUNT) == [(2, 3)]
    assert dead_joints(command, measured, COUNT) == [2]
    run = Run(name="run", t_s=t_s, command_rad=command, measured_rad=measured)
    assert len(channel_doubts(run, ROBOT)) == 1


def test_a_joint_with_a_known_fault_is_not_doubted() -> None:
    run = run_of(Gait.from_degrees(40, 80, 2))
    run.measured_rad[:, 2] = 0.0
    for faults in (["rigid:3"], ["free:3"], ["rigid:3@2s"]):
        known = Run(name="r", t_s=run.t_s, command_rad=run.command_rad, measured_rad=run.measured_rad,
                    metadata={"faults": faults})  # fmt: skip
        assert channel_doubts(known, ROBOT) == []


@settings(deadline=None, max_examples=60)
@given(
    st.floats(2, 70), st.floats(-180, 180), st.floats(0.3, 4), st.floats(0, 0.2), st.integers(0, 2**32 - 1)
)
def test_a_robot_that_only_trails_is_never_doubted(
    alpha_deg: float, beta_deg: float, omega_rad_s: float, lag_s: float, seed: int
) -> None:
    run = run_of(Gait.from_degrees(alpha_deg, beta_deg, omega_rad_s), lag_s)
    noise = np.random.default_rng(seed).normal(0, COUNT, run.measured_rad.shape)
    noisy = Run(name="r", t_s=run.t_s, command_rad=run.command_rad, measured_rad=run.measured_rad + noise)
    assert channel_doubts(noisy, ROBOT) == []


@pytest.mark.parametrize(
    "probe", [None, "triangle:amplitude_deg=5,rate_deg_s=20", "steps:amplitude_deg=20,joints=3"]
)
def test_a_run_tells_what_is_wrong_with_its_channels_and_a_sound_one_nothing(
    probe: str | None, tmp_path: Path
) -> None:
    what = Gait.from_degrees(40, 80, 2) if probe is None else parse_probe(probe)
    doubts = []
    for name, effects in (("sound", []), ("stuck", ["joint_rigid:angle_deg=0,joints=3"])):
        with open_board("sim:", ROBOT, effects=effects, virtual=True) as board:
            board.link._about = {}  # type: ignore[attr-defined]  # nobody has told the log of it
            settings = RunSettings(log_path=tmp_path / name)
            doubts.append(record(board, ROBOT, plan_run(what, 5, cycles=1), settings).doubts)
    assert doubts[0] == ()
    assert len(doubts[1]) == 1
    assert doubts[1][0].startswith("joint 3 is told to move by")
