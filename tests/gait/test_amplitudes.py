"""Gaits whose joints have amplitudes of their own: sent, changed, checked, kept in files, and simulated."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from snakebot.cli.main import main
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, check_motion, load_gait
from snakebot.physics import ChainModel, replay, simulate_gaits
from snakebot.robot import load_robot
from snakebot.runlog.log import gait_from_mapping, gait_to_mapping

ROBOT = load_robot("penn_state")
SHARES = (1.0, 0.5, 0.8, 0.0, 0.25)
GAIT = Gait.from_degrees(40, 80, 2, shares=SHARES)


def test_each_joint_swings_by_its_share() -> None:
    t = np.linspace(0, GAIT.period_s, 401)
    np.testing.assert_allclose(
        np.abs(GAIT.angles(t, 5)).max(axis=0), GAIT.alpha_rad * np.array(SHARES), atol=1e-4
    )


def test_a_motion_says_the_same_at_once_and_one_by_one_and_changes_without_a_jump() -> None:
    motion = GaitMotion(replace(GAIT, shares=()), 5, 30.0, 2.0).changed(10.0, GAIT, 2.0)
    t = np.arange(0.0, 30.0, 0.01)
    together = motion.sampled(t)
    np.testing.assert_allclose(together, [motion.angles(moment) for moment in t], atol=1e-12)
    assert np.abs(np.diff(together, axis=0)).max() < 1.3 * 0.01 * GAIT.alpha_rad * GAIT.omega_rad_s
    late = together[(t > 15) & (t < 25)]
    np.testing.assert_allclose(np.abs(late).max(axis=0), GAIT.alpha_rad * np.array(SHARES), atol=1e-3)


def test_limits_are_checked_joint_by_joint() -> None:
    limits = ROBOT.limits.model_copy(update={"angle_deg": 30.0})
    strict = ROBOT.model_copy(update={"limits": limits})
    with pytest.raises(BadInputError, match="joint 1: the motion asks for angle 40"):
        check_motion(GaitMotion(GAIT, 5, 20.0, 2.0), strict)
    check_motion(GaitMotion(replace(GAIT, shares=(0.7,) * 5), 5, 20.0, 2.0), strict)


def test_what_is_no_share_or_fits_no_robot_is_refused() -> None:
    with pytest.raises(BadInputError, match="from 0 to 1"):
        replace(GAIT, shares=(1.2,) * 5)
    with pytest.raises(BadInputError, match="from 0 to 1"):
        replace(GAIT, shares=(float("nan"),) * 5)
    with pytest.raises(BadInputError, match="5 amplitudes, and the robot has 4 joints"):
        GaitMotion(GAIT, 4, 20.0, 2.0)


def test_files_and_logs_keep_them(tmp_path: Path) -> None:
    path = tmp_path / "gait.yaml"
    path.write_text("alpha_deg: 40\nbeta_deg: 80\nomega_rad_s: 2\namplitudes: [1, 0.5, 0.8, 0, 0.25]\n")
    assert load_gait(path) == GAIT
    assert gait_from_mapping(gait_to_mapping(GAIT), "log") == GAIT
    assert "amplitudes" not in gait_to_mapping(replace(GAIT, shares=()))
    path.write_text("alpha_deg: 40\nbeta_deg: 80\nomega_rad_s: 2\namplitudes: [1, x]\n")
    with pytest.raises(BadInputError, match=r"line 4: amplitudes is .* not a list of numbers"):
        load_gait(path)
    with pytest.raises(BadInputError, match="not a list of numbers"):
        gait_from_mapping({**gait_to_mapping(GAIT), "amplitudes": "1"}, "log")


def test_the_compiled_sweep_moves_as_the_angles_do() -> None:
    assert ROBOT.body is not None
    model = ChainModel.from_body(ROBOT.body)
    row = [[GAIT.alpha_rad, GAIT.beta_rad, GAIT.omega_rad_s]]
    found = simulate_gaits(model, row, shares=SHARES)
    t = np.linspace(0, 8 * GAIT.period_s, 8 * 800 + 1)
    s = np.clip(t / GAIT.period_s, 0, 1)
    moved = replay(model, t, (s**3 * (10 + s * (6 * s - 15)))[:, None] * GAIT.angles(t, 5))
    assert found.forward_speed_m_s[0] == pytest.approx(moved.forward_speed_m_s(4 * GAIT.period_s), rel=0.01)
    assert found.speed_m_s[0] < 0.8 * simulate_gaits(model, row).speed_m_s[0]
    with pytest.raises(BadInputError, match="3 amplitudes do not fit 5 joints"):
        simulate_gaits(model, row, shares=(1, 1, 1))


def test_run_takes_them(capsys: pytest.CaptureFixture[str]) -> None:
    wave = ["run", "--alpha", "40", "--beta", "80", "--omega", "2", "--dry-run"]
    with pytest.raises(SystemExit) as ended:
        main([*wave, "--amplitudes", "1,0.5,0.8,0,0.25"])
    assert ended.value.code == 0
    assert "amplitudes 1,0.5,0.8,0,0.25" in capsys.readouterr().out
    for words, said in ((["--amplitudes", "1,2"], "from 0 to 1"), (["--amplitudes", "1,1"], "2 amplitudes")):
        with pytest.raises(SystemExit) as ended:
            main([*wave, *words])
        assert ended.value.code == 2
        assert said in capsys.readouterr().err
