"""``diagnose --live``: who decides when to run, when to stop, and what is left behind. Nothing moves here."""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click
import pytest

from snakebot.cli.diagnose_live import Live, live
from snakebot.cli.run_options import RunOptions
from snakebot.control import RecordedRun, RunPlan, RunResult, RunSettings, registry
from snakebot.control.progress import Progress, TrackingSoFar
from snakebot.diagnosis.live import starting_set
from snakebot.diagnosis.result import GaitDegrees, NextExperiment
from snakebot.errors import BadInputError, BoardFaultError, LostBoardError
from snakebot.gait import Gait, GaitMotion, check_motion
from snakebot.robot import Robot, load_robot, robot_from_mapping

ROBOT = load_robot("penn_state")
PROBE = "snakebot run --alpha 2 --beta 80 --omega 0.5 --duration 10 --ramp 2"
LIFTED = PROBE + " --lifted"


def cause(probability: float, *ties: str) -> Any:
    return SimpleNamespace(effect="rate_limit", probability=probability, indistinguishable_from=ties)


def verdict(*causes: Any, proposal: str | None = PROBE, name: str = "explained") -> Any:
    motion = None
    if proposal is not None:
        motion = NextExperiment(
            gait=GaitDegrees(alpha_deg=2, beta_deg=80, omega_rad_s=0.5),
            lifted=proposal.endswith("--lifted"),
            duration_s=10,
            ramp_s=2,
            motion="a small gait",
            separates=(),
            expected_probability_after=0.9,
            reason="they differ there",
            command=proposal,
        )
    return SimpleNamespace(verdict=name, causes=causes, next_experiment=motion)


@dataclass(frozen=True)
class Asked:
    """One run that was asked for."""

    plan: RunPlan
    settings: RunSettings
    options: RunOptions


class Desk:
    """Stands in for the runs and the diagnosis; notes what is asked of both."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, folder: Path, *verdicts: Any) -> None:
        self.folder, self.verdicts = folder, list(verdicts)
        self.runs: list[Asked] = []
        self.said: list[str] = []
        self.fails_at: int | None = None
        self.interrupted_at: int | None = None
        self.asked_late_at: int | None = None
        monkeypatch.setattr("snakebot.cli.execution.execute", self._run)

    def _run(
        self, robot: Robot, plan: RunPlan, settings: RunSettings, options: RunOptions, page: object
    ) -> RecordedRun:
        assert page is None
        self.runs.append(Asked(plan, settings, options))
        if len(self.runs) == self.fails_at:
            raise LostBoardError("the wire is gone")
        assert settings.log_path is not None
        settings.log_path.write_bytes(b"")
        ended = "interrupted" if len(self.runs) == self.interrupted_at else "finished"
        progress = Progress(12.0, TrackingSoFar(robot.joints, 1.0), ticks=1201)
        result = RunResult(ended, 12.0, progress)
        late = len(self.runs) == self.asked_late_at
        return RecordedRun(result, settings.log_path, asked_late=late)

    def go(self, *, port: str = "sim:", budget: int = 9, yes: bool = True, robot: Robot = ROBOT) -> Any:
        plan = Live(self.folder, budget, RunOptions(port=port, yes=yes))
        return live(plan, robot, self._diagnose, self.said.append)

    def _diagnose(self, folder: Path) -> Any:
        assert folder == self.folder
        return self.verdicts.pop(0)


Make = Callable[..., Desk]


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Make:
    return lambda *verdicts: Desk(monkeypatch, tmp_path / "logs", *verdicts)


def test_one_sure_cause_ends_it_after_the_starting_set(desk: Make) -> None:
    here = desk(verdict(cause(0.9)))
    here.go()
    assert len(here.runs) == 5
    assert "Nothing is left to tell apart" in here.said[-1]


def test_no_gap_ends_it(desk: Make) -> None:
    here = desk(verdict(name="no_gap"))
    here.go()
    assert len(here.runs) == 5


@pytest.mark.parametrize(
    "still_open",
    [verdict(cause(0.6)), verdict(cause(0.95, "backlash")), verdict(cause(0.95), name="unexplained")],
)
def test_what_is_open_is_followed_up_until_it_stands(desk: Make, still_open: Any) -> None:
    here = desk(still_open, verdict(cause(0.9)))
    assert here.go().causes[0].probability == 0.9
    assert len(here.runs) == 6
    gait = here.runs[5].plan.gait
    assert gait is not None
    assert math.degrees(gait.alpha_rad) == pytest.approx(2)


def test_the_same_proposal_twice_ends_it(desk: Make) -> None:
    here = desk(verdict(cause(0.6)), verdict(cause(0.6)))
    here.go()
    assert len(here.runs) == 6
    assert "proposed again" in here.said[-1]


def test_no_proposal_ends_it(desk: Make) -> None:
    here = desk(verdict(cause(0.6), proposal=None))
    here.go()
    assert len(here.runs) == 5
    assert "No further motion" in here.said[-1]


def test_the_budget_holds(desk: Make) -> None:
    here = desk(*(verdict(cause(0.6), proposal=f"{PROBE} --offset {i}") for i in range(9)))
    here.go(budget=7)
    assert len(here.runs) == 7
    assert "budget of 7 runs is used up" in here.said[-1]
    with pytest.raises(BadInputError, match="the starting set needs 5"):
        desk().go(budget=4)


def test_each_simulated_run_has_noise_of_its_own_and_a_real_one_no_seed(desk: Make) -> None:
    here = desk(verdict(cause(0.9)))
    here.go()
    assert [run.options.seed for run in here.runs] == [0, 1, 2, 3, 4]
    logs = [run.settings.log_path.name for run in here.runs if run.settings.log_path]
    assert logs == [f"live_0{i}.mcap" for i in range(1, 6)]


def test_a_real_robot_gets_port_and_no_seed(desk: Make) -> None:
    here = desk(verdict(cause(0.9)))
    here.go(port="serial:/dev/ttyUSB7")
    for run in here.runs:
        assert run.options.port == "serial:/dev/ttyUSB7"
        assert run.options.seed == 0


def test_nobody_is_there_to_lift_a_real_robot(desk: Make) -> None:
    here = desk(verdict(cause(0.6), proposal=LIFTED))
    here.go(port="serial:/dev/ttyUSB7")
    assert len(here.runs) == 5
    assert "lifted off the ground first" in here.said[-1]


def test_a_simulated_robot_needs_no_hand(desk: Make) -> None:
    here = desk(verdict(cause(0.6), proposal=LIFTED), verdict(cause(0.9)))
    here.go()
    assert here.runs[5].plan.lifted


def test_standard_output_is_left_to_the_verdict(desk: Make, capsys: pytest.CaptureFixture[str]) -> None:
    here = desk(verdict(cause(0.9)))
    here.go()
    assert capsys.readouterr().out == ""
    assert "1201 ticks" in here.said[0]


@pytest.mark.parametrize(("yeses", "runs"), [(2, 2), (5, 5), (6, 6)])
def test_each_motion_is_asked_for(desk: Make, monkeypatch: pytest.MonkeyPatch, yeses: int, runs: int) -> None:
    asked: list[str] = []

    def confirm(text: str, **_: Any) -> bool:
        asked.append(text)
        return len(asked) <= yeses

    monkeypatch.setattr(click, "confirm", confirm)
    here = desk(verdict(cause(0.6)), verdict(cause(0.9)))
    here.go(yes=False, port="serial:/dev/ttyUSB7")
    assert len(here.runs) == runs
    assert len(asked) == min(yeses + 1, 6)
    assert all("serial:/dev/ttyUSB7 will move" in text for text in asked)


def test_a_lost_board_ends_it_and_what_is_there_is_told(desk: Make) -> None:
    here = desk()
    here.fails_at = 3
    with pytest.raises(LostBoardError):
        here.go()
    assert "holds 2 logs: snakebot diagnose" in here.said[-1]


def test_an_interrupted_run_ends_it_with_its_exit_status(desk: Make) -> None:
    here = desk()
    here.interrupted_at = 3
    with pytest.raises(SystemExit) as ended:
        here.go()
    assert ended.value.code == 130
    assert len(here.runs) == 3
    assert "holds 3 logs" in here.said[-1]


def test_ctrl_c_while_a_log_is_closed_ends_it(desk: Make) -> None:
    here = desk()
    here.asked_late_at = 2
    with pytest.raises(SystemExit) as ended:
        here.go()
    assert ended.value.code == 130
    assert len(here.runs) == 2
    assert "no further run is made" in here.said[-2]


def test_a_used_folder_is_refused(desk: Make, tmp_path: Path) -> None:
    here = desk()
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "old.mcap").write_bytes(b"")
    with pytest.raises(BadInputError, match="holds something already"):
        here.go()
    assert here.runs == []


def test_a_slow_robot_gets_smaller_gaits_all_of_them_safe() -> None:
    text = ROBOT.to_mapping() | {"limits": {"angle_deg": 35, "speed_rad_s": 0.8, "acceleration_rad_s2": 4}}
    robot = robot_from_mapping(text, "slow")
    gaits = starting_set(robot)
    assert len(gaits) == 5
    assert gaits[0].motion == gaits[-1].motion
    assert [g.motion for g in gaits[:4]] != [g.motion for g in starting_set(ROBOT)[:4]]
    for each in gaits:
        assert isinstance(each.motion, Gait)
        check_motion(GaitMotion(each.motion, 5, 12.0, 2.0), robot)


def test_runs_that_begin_from_different_poses_are_repeats_all_the_same(tmp_path: Path) -> None:
    """The run log does not say what repeats what; a joint with play starts elsewhere each time."""
    import warnings

    import numpy as np

    from snakebot.cli.diagnose import given_session
    from snakebot.runlog import Run, write_session

    t_s = np.arange(0, 12, 0.01)
    gait = GaitMotion(Gait.from_degrees(50, 80, 2), 5, 12.0, 2.0)
    runs = []
    for name, start_rad in (("a", [0.0] * 5), ("b", [0.0, 0.0, 0.06, 0.0, 0.0])):
        command = GaitMotion(gait.gait, 5, 12.0, 2.0, start_rad).sampled(t_s)
        runs.append(Run(name=name, t_s=t_s, command_rad=command, measured_rad=command))
    for run in runs:  # a session of one run each, as logs are
        write_session(tmp_path / run.name, ROBOT, [run])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        session = given_session((tmp_path / "a", tmp_path / "b"), None)
    assert [run.repeat_of is not None for run in session.runs] == [False, True]


def test_a_stop_between_two_runs_ends_it_all(desk: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    turns = desk(verdict(cause(0.5)))
    before = signal.getsignal(registry.STOP_SIGNAL)

    def diagnose(folder: Path) -> Any:
        (run,) = registry.running()
        with registry.registered(run.port):
            pass  # as a run does
        registry.stop(run)
        time.sleep(5)
        raise AssertionError("not stopped")

    monkeypatch.setattr(turns, "_diagnose", diagnose)
    with pytest.raises(BoardFaultError, match="no further run"):
        turns.go(port="serial:/dev/robot")
    assert signal.getsignal(registry.STOP_SIGNAL) is before
    assert not registry.running()
    assert [run.settings.keep_stop for run in turns.runs] == [False] + [True] * (len(turns.runs) - 1)
