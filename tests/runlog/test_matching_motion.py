"""One answer to whether two runs are one motion."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.runlog.matching.motion import STILL_RAD, CommandedMotion, same_command, same_motion

T_S = np.arange(0, 8, 0.01)


def told(command_rad: np.ndarray, t_s: np.ndarray = T_S, *, lifted: bool = False) -> CommandedMotion:
    return CommandedMotion(t_s, command_rad, lifted)


def wave(t_s: np.ndarray = T_S, amplitude_rad: float = 0.5, joints: int = 2) -> np.ndarray:
    ramp = np.clip(t_s / 2, 0, 1)
    return np.column_stack([amplitude_rad * ramp * np.sin(2 * t_s + j) for j in range(joints)])


def test_a_motion_is_itself_on_jittering_ticks_and_another_one_is_not() -> None:
    late = T_S + np.random.default_rng(0).uniform(0, 0.003, T_S.size)
    assert same_motion(told(wave()), told(wave(late), late)) is not None
    for other in (wave(amplitude_rad=0.53), wave(1.05 * T_S), wave() + 0.05, -wave()):
        assert same_motion(told(wave()), told(other)) is None


@pytest.mark.parametrize("rate_hz", [20.0, 100.0])
def test_a_gait_a_tenth_larger_is_another_one_however_slow_the_log(rate_hz: float) -> None:
    t_s = np.arange(0, 10, 1 / rate_hz)
    small, large = (told(amplitude * np.sin(4 * t_s)[:, None], t_s) for amplitude in (0.5, 0.55))
    assert same_motion(small, large) is None


def test_joints_that_stand_still_are_no_evidence() -> None:
    still = np.full((T_S.size, 4), 0.2)
    assert same_motion(told(still), told(still)) is None
    assert same_motion(told(still), told(still), claimed=True) is None
    # four joints of five agree at every sample; the one that moves does not
    other_wave = 0.5 * np.sin(3.1 * T_S)[:, None]
    one, other = np.column_stack([wave(joints=1), still]), np.column_stack([other_wave, still])
    assert same_motion(told(one), told(other)) is None
    assert same_motion(told(one), told(other), claimed=True) is None
    assert same_motion(told(one), told(one)) is not None


def test_joints_that_stand_still_must_stand_at_the_same_angle() -> None:
    one = np.column_stack([wave(joints=1), np.zeros(T_S.size)])
    within, off = (one + np.array([0.0, angle]) for angle in (0.5 * STILL_RAD, 0.1))
    assert same_motion(told(one), told(within)) is not None
    assert same_motion(told(one), told(off)) is None


def test_only_a_run_that_claims_it_may_begin_later_or_lack_a_part() -> None:
    whole, part = told(wave()), told(wave()[150:], T_S[150:])
    assert same_motion(part, whole) is None
    found = same_motion(part, whole, claimed=True)
    assert found is not None
    assert found.shift_s == pytest.approx(1.5, abs=1e-4)
    holed = wave()
    holed[300:360] += 0.05
    assert same_motion(whole, told(holed)) is None
    claimed = same_motion(whole, told(holed), claimed=True)
    assert claimed is not None
    assert not claimed.same[310:350].any()


def test_a_joint_may_ramp_up_from_another_angle() -> None:
    start = 0.06 * np.clip(1 - T_S / 1.5, 0, 1)
    one = wave(joints=5)
    other = one + np.column_stack([np.zeros((T_S.size, 4)), start])
    assert same_motion(told(one), told(other)) is not None
    assert same_motion(told(one), told(one + start[:, None])) is None  # all of them: another motion


def test_a_motion_in_the_air_is_not_the_one_on_the_ground() -> None:
    assert same_motion(told(wave()), told(wave(), lifted=True), claimed=True) is None


def test_servos_that_are_off_are_off_in_both() -> None:
    off = wave()
    off[:400, 0] = np.nan
    assert same_motion(told(off), told(off)) is not None
    assert same_motion(told(off), told(wave())) is None
    size = np.array([0.5, 0.5])
    assert same_command(off, off, size).all()
    assert not same_command(off, wave(), size)[:400, 0].any()
