"""``--live`` runs a probe that is proposed as it runs a gait; one in the air only where somebody can lift the robot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from snakebot.cli import diagnose_live
from snakebot.cli.diagnose_live import Live, live
from snakebot.cli.run_options import RunOptions
from snakebot.diagnosis import live as turns
from snakebot.diagnosis.proposal.motions import known_motions
from snakebot.diagnosis.result import (
    AngleClosure,
    Cause,
    Closure,
    Diagnosis,
    NextExperiment,
    StageShares,
    Unexplained,
    Where,
)
from snakebot.robot import Robot, load_robot
from snakebot.runlog import read_log

PROBE = "triangle:amplitude_deg=5,rate_deg_s=20,joints=3"


def verdict(lifted: bool) -> Diagnosis:
    """Dead band or backlash, and a probe that would tell."""
    air = " --lifted" if lifted else ""
    return Diagnosis(
        verdict="explained",
        where=Where(
            stage="servo", stage_shares=StageShares(servo=1.0), joints=(3,), joint_shares=(1.0,), regime=""
        ),
        causes=(
            Cause(
                effect="deadband",
                joints=(3,),
                stage="servo",
                probability=0.9,
                parameters={},
                indistinguishable_from=("backlash",),
                specification="deadband:width_deg=3,joints=3",
            ),
        ),
        ranking=(),
        closure=Closure(
            held_out_runs=(),
            joint_angle=AngleClosure(rms_before=0.1, rms_after=0.0, rms_floor=0.0, closed=1.0),
            forward_speed=None,
        ),
        unexplained=Unexplained(share=0.0, where="", significant=False),
        next_experiment=NextExperiment(
            gait=None,
            probe=PROBE,
            lifted=lifted,
            duration_s=8.0,
            ramp_s=1.0,
            motion="joint 3 alone",
            separates=(("deadband", "backlash"),),
            expected_probability_after=0.9,
            reason="they differ there",
            command=f"snakebot run --probe {PROBE} --duration 8 --ramp 1{air}",
        ),
    )


def begin_with(monkeypatch: pytest.MonkeyPatch, some: slice) -> None:
    """Some gaits of the starting set alone."""
    fewer = replace(known_motions(), start=known_motions().start[some])
    monkeypatch.setattr(turns, "known_motions", lambda: fewer)


@pytest.mark.parametrize("lifted", [False, True])
def test_the_proposed_probe_is_run_and_logged(
    lifted: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    begin_with(monkeypatch, slice(3, None))
    plan = Live(tmp_path / "logs", 5, RunOptions(yes=True, fast=True))
    live(plan, load_robot("penn_state"), lambda folder: verdict(lifted), lambda text: None)
    logs = [read_log(path) for path in sorted((tmp_path / "logs").glob("*.mcap"))]
    assert [log.metadata.get("probe") for log in logs[-2:]] == [
        None,
        PROBE,
    ]  # the same proposal is not run twice
    assert logs[-1].metadata.get("lifted", False) is lifted


def test_nobody_lifts_a_real_robot_when_nobody_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    moved: list[turns.Experiment] = []
    begin_with(monkeypatch, slice(1, 3))

    def move(plan: Live, robot: Robot, wanted: turns.Experiment, *_: object) -> bool:
        moved.append(wanted)
        return True

    monkeypatch.setattr(diagnose_live, "run_one", move)
    plan = Live(tmp_path / "logs", 5, RunOptions(port="serial:/dev/ttyUSB0", yes=True))
    live(plan, load_robot("penn_state"), lambda folder: verdict(True), said.append)
    assert moved
    assert not any(experiment.lifted for experiment in moved)
    assert any("lift" in line for line in said)
