"""How far recordings went, as a calibrated description says it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_result_schema import FOUND

from snakebot.calibrated.recorded import asked_speed, reached
from snakebot.diagnosis.show.apply import calibrated
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion
from snakebot.optimise.outcomes import GaitSimulator
from snakebot.optimise.promise import row_of
from snakebot.robot import Recorded, load_robot
from snakebot.runlog import Run

ROBOT = load_robot("penn_state")
T = np.arange(1000) / 100


def run_of(gait: Gait, joints: int = 5, **more: object) -> Run:
    command = GaitMotion(gait, joints, 10.0, 2.0).sampled(T)
    return Run("a", T, command, command.copy(), gait=gait, **more)  # type: ignore[arg-type]


def test_the_fastest_gait_the_largest_joint_speed_and_the_torque_of_its_simulation() -> None:
    fast, wide = Gait.from_degrees(20, 80, 3), Gait.from_degrees(50, 80, 2)
    found = reached(ROBOT, [run_of(fast), run_of(wide)])
    assert found is not None
    assert found.omega_rad_s == 3
    assert found.joint_speed_rad_s == pytest.approx([wide.alpha_rad * 2] * 5, rel=0.03)
    torques = [GaitSimulator([(ROBOT, ())])(row_of(gait)[None]).torque_nm[0, 0] for gait in (fast, wide)]
    assert found.torque_nm is not None
    assert 0.98 * max(torques) < max(found.torque_nm) < 1.35 * max(torques)  # in the ramps it is more
    assert found.torque_nm[0] < found.torque_nm[2]  # the tail bears less


def test_lifted_off_the_ground_a_joint_bears_next_to_nothing() -> None:
    gait = Gait.from_degrees(20, 80, 2)
    ground, air = (reached(ROBOT, [run_of(gait, metadata={"lifted": up})]) for up in (None, True))
    assert ground is not None
    assert air is not None
    assert ground.torque_nm is not None
    assert air.torque_nm is not None
    assert max(air.torque_nm) < 0.3 * max(ground.torque_nm)


def test_a_step_asks_for_no_speed_and_a_servo_that_is_off_for_nothing() -> None:
    command = np.where(T[:, None] < 5, 0.0, np.radians(6)) * np.ones(2)
    command[:, 1] = np.nan
    run = Run("step", T, command, np.zeros_like(command))
    speed = asked_speed(run)
    assert speed[0] == pytest.approx(np.radians(6) / 0.1, rel=1e-6)
    assert speed[1] == 0.0
    bench = load_robot("penn_state").model_copy(update={"body": None, "joints": 2})
    found = reached(bench, [run])
    assert found is not None
    assert found.torque_nm is None
    assert found.omega_rad_s is None


def test_runs_without_samples_tell_nothing() -> None:
    empty = Run("a", np.zeros(1), np.zeros((1, 5)), np.zeros((1, 5)))
    assert reached(ROBOT, [empty]) is None
    assert reached(ROBOT, []) is None


def test_the_description_has_it_and_comes_back_from_its_file(tmp_path: Path) -> None:
    made = calibrated(ROBOT, FOUND, [run_of(Gait.from_degrees(20, 80, 2))])
    assert made.recorded is not None
    (tmp_path / "c.yaml").write_text(made.to_yaml())
    assert load_robot(tmp_path / "c.yaml") == made
    assert "recorded" not in calibrated(ROBOT, FOUND).to_mapping()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("joint_speed_rad_s: [1, 1]", "recorded.joint_speed_rad_s has 2 values for 5 joints"),
        ("joint_speed_rad_s: [1, 1, 1, 1, -1]", "recorded.joint_speed_rad_s.4"),
        ("joint_speed_rad: [1, 1, 1, 1, 1]", "joint_speed_rad_s"),
        ("omega_rad_s: 2", "recorded.joint_speed_rad_s"),
    ],
)
def test_what_is_wrong_in_a_file_is_one_line(given: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "c.yaml"
    path.write_text(ROBOT.to_yaml() + f"recorded:\n  {given}\n")
    with pytest.raises(BadInputError, match=said) as refused:
        load_robot(path)
    assert "\n" not in str(refused.value)


def test_an_old_description_without_it_loads() -> None:
    assert ROBOT.recorded is None
    assert Recorded(joint_speed_rad_s=(1.0,)).torque_nm is None
