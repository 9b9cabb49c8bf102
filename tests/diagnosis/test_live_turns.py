"""``diagnose --live``: who decides when to run, when to stop, and what is left behind. Nothing moves here."""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click
import pytest

from snakebot.cli import diagnose_live
from snakebot.cli.diagnose_live import Live, live, starting_set
from snakebot.control import registry
from snakebot.errors import BadInputError, BoardFaultError, LostBoardError
from snakebot.gait import Gait, GaitMotion, check_motion
from snakebot.robot import Robot, load_robot, robot_from_mapping

ROBOT = load_robot("penn_state")
PROBE = "snakebot run --alpha 2 --beta 80 --omega 0.5 --duration 10 --ramp 2"
LIFTED = PROBE + " --lifted"


def cause(probability: float, *ties: str) -> Any:
    return SimpleNamespace(effect="rate_limit", probability=probability, indistinguishable_from=ties)


def verdict(*causes: Any, proposal: str | None = PROBE, name: str = "explained") -> Any:
    motion = None if proposal is None else SimpleNamespace(command=proposal, reason="they differ there")
    return SimpleNamespace(verdict=name, causes=causes, next_experiment=motion)


class Desk:
    """Stands in for the runs and the diagnosis; notes what is asked of both."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, folder: Path, *verdicts: Any) -> None:
        self.folder, self.verdicts = folder, list(verdicts)
        self.runs: list[list[str]] = []
        self.said: list[str] = []
        self.fails_at: int | None = None
        monkeypatch.setattr("snakebot.cli.run.command", SimpleNamespace(main=self._run))

    def _run(self, arguments: Sequence[str], standalone_mode: bool) -> None:
        assert not standalone_mode
        self.runs.append(list(arguments))
        if len(self.runs) == self.fails_at:
            raise LostBoardError("the wire is gone")
        Path(arguments[arguments.index("--log") + 1]).write_bytes(b"")
        click.echo(json.dumps({"ended": "finished", "ticks": 1201, "lost": 0, "clamped": 0}))

    def go(self, *, port: str = "sim:", budget: int = 9, yes: bool = True, robot: Robot = ROBOT) -> Any:
        return live(Live(port, self.folder, budget, yes), robot, self._diagnose, self.said.append)

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
    assert here.runs[5][:2] == ["--alpha", "2"]


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
    assert [run[run.index("--seed") + 1] for run in here.runs] == ["0", "1", "2", "3", "4"]
    logs = [Path(run[run.index("--log") + 1]).name for run in here.runs]
    assert logs == [f"live_0{i}.mcap" for i in range(1, 6)]


def test_a_real_robot_gets_port_and_no_seed(desk: Make) -> None:
    here = desk(verdict(cause(0.9)))
    here.go(port="serial:/dev/ttyUSB7")
    for run in here.runs:
        assert run[run.index("--port") + 1] == "serial:/dev/ttyUSB7"
        assert "--seed" not in run


def test_nobody_is_there_to_lift_a_real_robot(desk: Make) -> None:
    here = desk(verdict(cause(0.6), proposal=LIFTED))
    here.go(port="serial:/dev/ttyUSB7")
    assert len(here.runs) == 5
    assert "lifted off the ground first" in here.said[-1]


def test_a_simulated_robot_needs_no_hand(desk: Make) -> None:
    here = desk(verdict(cause(0.6), proposal=LIFTED), verdict(cause(0.9)))
    here.go()
    assert "--lifted" in here.runs[5]


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

    monkeypatch.setattr(diagnose_live.click, "confirm", confirm)
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
    assert gaits[0] == gaits[-1]
    assert [g[0] for g in gaits[:4]] != [g[0] for g in starting_set(ROBOT)[:4]]
    for alpha, beta, omega in gaits:
        check_motion(GaitMotion(Gait.from_degrees(alpha, beta, omega), 5, 12.0, 2.0), robot)


def test_runs_that_begin_from_different_poses_are_repeats_all_the_same(tmp_path: Path) -> None:
    """The run log does not say what repeats what; a joint with play starts elsewhere each time."""
    import warnings

    import numpy as np

    from snakebot.cli.diagnose import _session
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
        session = _session((tmp_path / "a", tmp_path / "b"), None)
    assert [run.repeat_of is not None for run in session.runs] == [False, True]


def test_a_stop_between_two_runs_ends_it_all(
    desk: Make, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "runtime"))
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
    assert ["--keep-stop" in arguments for arguments in turns.runs] == [False] + [True] * (
        len(turns.runs) - 1
    )
