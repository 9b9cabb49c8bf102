"""The lab does what a proposal says, and the scores of experiments are known for made-up trails."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from blind.cases import make_case
from blind.experiments import Trail, experiment_figures, open_group, trails, wanted
from blind.lab import Lab, at_random, off_the_ground, proposed
from blind.robot import Parameters, Robot, gait_command
from blind.session_files import add_run, write_session

from snakebot.errors import BadInputError
from snakebot.runlog import read_session

GAIT = "snakebot run --alpha 30 --beta 80 --omega 4 --offset 15 --duration 10 --ramp 2"
PROBE = "snakebot run --probe triangle:amplitude_deg=5,rate_deg_s=10,joints=3 --lifted --duration 10 --ramp 2"


def test_a_proposal_is_run_as_it_says_and_joins_the_session(tmp_path: Path) -> None:
    case = make_case("tune", 5, 1, 40)
    write_session(tmp_path / "s", case)
    before = read_session(tmp_path / "s")
    for command in (GAIT, PROBE):
        experiment = proposed(command, case.build.joints)
        run = Lab(case).perform(experiment, np.random.default_rng(0))
        assert run.t_s.size == 10 * case.build.rate_hz
        add_run(tmp_path / "s", run, experiment.gait, experiment.probe, lifted=experiment.lifted)
    session = read_session(tmp_path / "s")
    assert len(session.runs) == len(before.runs) + 2
    *_, gait, probe = session.runs
    assert gait.gait is not None
    assert np.degrees(gait.gait.offset_rad) == pytest.approx(15, abs=1e-3)
    assert gait.pose is not None
    assert probe.gait is None
    assert probe.pose is None
    assert probe.metadata["lifted"] is True
    swing = np.degrees(np.ptp(probe.measured_rad, axis=0))
    assert swing[2] == pytest.approx(10, abs=1.0)
    assert np.delete(swing, 2).max() < 1.5


def test_a_robot_in_the_air_goes_nowhere() -> None:
    t = np.arange(0.0, 6.0, 0.01)
    command = gait_command(t, np.radians(40), np.radians(80), 3.0)
    run = Robot(off_the_ground(Parameters().noiseless())).run(t, command, np.random.default_rng(0))
    assert np.abs(run.pose[:, :2]).max() < 1e-3  # nothing to push against: its centre of mass stays
    assert np.abs(np.degrees(run.encoder_rad)).max() > 35


@pytest.mark.parametrize(
    "command", ["snakebot run --alpha 30", "rm -rf /", GAIT + " --port can:can0", "", "'"]
)
def test_what_the_lab_does_not_understand_it_does_not_do(command: str) -> None:
    with pytest.raises((ValueError, BadInputError)):
        proposed(command)


def test_gaits_of_the_control_are_safe_and_differ() -> None:
    rng = np.random.default_rng(0)
    drawn = [at_random(rng).gait for _ in range(5)]
    assert len({str(g) for g in drawn}) == 5


def label(size: float = 3.0) -> Any:
    effect = {"name": "rate_limit", "stage": "servo", "joints": [3], "values": {}, "size": size}
    return {"stratum": "single", "asked_size": size, "effects": [effect]}


def answer(effect: str, *others: str, more: bool = False) -> Any:
    cause = {"effect": effect, "probability": 0.9, "indistinguishable_from": list(others), "parameters": {}}
    return {"verdict": "explained", "causes": [cause], "next_experiment": {"command": GAIT} if more else None}


TIE = answer("voltage_sag", "rate_limit", more=True)


def figures(mine: list[Any], control: list[Any]) -> dict[str, Any]:
    pairs = [(label(), TIE)]
    found = {
        "proposed": {"t": Trail(label(), [TIE, *mine])},
        "random": {"t": Trail(label(), [TIE, *control])},
    }
    return {f.key: f for f in experiment_figures(["t"], pairs, found)}


def test_one_good_experiment_against_three_at_random() -> None:
    found = figures([answer("rate_limit")], [TIE, TIE, answer("rate_limit")])
    assert found["named_after"].value == 1.0
    assert found["experiments"].value == 1.0
    assert found["fewer"].value == 3.0
    assert found["fewer"].met is True


def test_a_wrong_answer_resolves_nothing() -> None:
    found = figures([answer("deadband")], [TIE, TIE, TIE])
    assert found["named_after"].value == 0.0
    assert found["resolved"].value == 0.0
    assert found["experiments"].met is False
    assert found["fewer"].value is None


def test_faint_effects_are_not_experimented_on() -> None:
    assert wanted(label(), TIE)
    assert not wanted(label(1.5), TIE)
    assert not wanted(label(), answer("rate_limit"))
    assert open_group(TIE)
    assert not open_group(answer("rate_limit"))


def test_trails_are_read_from_files(tmp_path: Path) -> None:
    (tmp_path / "t.proposed.1.json").write_text('{"causes": []}')
    found = trails(tmp_path, ["t"], [(label(), TIE)])
    assert len(found["proposed"]["t"].answers) == 2
    assert not found["random"]
