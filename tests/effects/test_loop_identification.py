"""Numbers of a position loop read off its motion are those with which the motion was made."""

from dataclasses import dataclass

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.effects import Observed, predict
from snakebot.effects.loop_identification import Carried, loops
from snakebot.robot import Robot, robot_from_mapping

MASS, LENGTH, G = 0.5, 0.1, 9.81
CARRIED = Carried(MASS * G * LENGTH, 0.0, MASS * LENGTH**2)


@dataclass
class Run:
    t_s: Floats
    command_rad: Floats
    measured_rad: Floats


def bench() -> Robot:
    return robot_from_mapping(
        {
            "joints": 1,
            "servo": {"time_constant_s": 0.0, "arm": {"mass_kg": MASS, "length_m": LENGTH, "down_deg": 0.0}},
        },
        "bench",
    )


def moved(spec: str, amplitude_rad: float = 1.0, omegas: tuple[float, ...] = (1.0, 3.0, 6.0)) -> Observed:
    """A bench in motion; ``omegas``: of its sinusoids, rad/s."""
    t, robot, runs = np.arange(0, 8, 0.01), bench(), []
    for omega in omegas:
        command = amplitude_rad * (np.minimum(t, 1) * np.sin(omega * t))[:, None]
        runs.append(Run(t, command, predict(robot, [spec], t, command).encoder_rad))
    return Observed(robot, runs)


def test_a_loop_with_torque_to_spare() -> None:
    spec = "position_loop:stiffness_nm_rad=3,damping_nm_s_rad=0.3,armature_kg_m2=0.003,coulomb_nm=0.05"
    found = loops(moved(spec), (0,), CARRIED)[0]
    assert found.stiffness_nm_rad == pytest.approx(3.0, rel=0.1)
    # what resists a motion of 3 rad/s: how much of it is dry shows little in sinusoids
    dry_nm = found.coulomb_nm + found.load_friction * CARRIED.gravity_nm / 2
    assert 3.0 * found.damping_nm_s_rad + dry_nm == pytest.approx(3.0 * 0.3 + 0.05, rel=0.15)


def test_a_drive_that_has_no_more_to_give() -> None:
    """Told further than it can lift, it is not a softer loop."""
    spec = "position_loop:stiffness_nm_rad=6,damping_nm_s_rad=0.1,full_drive_deg=4,armature_kg_m2=0.003"
    found = loops(moved(spec, omegas=(0.5, 1.0)), (0,), CARRIED)[0]
    torque_nm = 6.0 * np.radians(4.0)
    assert found.stiffness_nm_rad * found.limit_rad == pytest.approx(torque_nm, rel=0.2)


def test_without_power_there_is_no_loop_to_read_off() -> None:
    seen = moved("position_loop:stiffness_nm_rad=3,damping_nm_s_rad=0.3")
    off = [Run(run.t_s, np.full_like(run.command_rad, np.nan), run.measured_rad) for run in seen.runs]
    assert loops(Observed(bench(), off), (0,), CARRIED) == []


def test_too_few_samples_say_nothing() -> None:
    seen = moved("position_loop:stiffness_nm_rad=3,damping_nm_s_rad=0.3").runs[0]
    short = Run(seen.t_s[:4], seen.command_rad[:4], seen.measured_rad[:4])
    assert loops(Observed(bench(), [short]), (0,), CARRIED) == []


def test_no_number_is_below_zero() -> None:
    """A joint that does the opposite of what it is told is no loop of negative stiffness."""
    seen = moved("position_loop:stiffness_nm_rad=3,damping_nm_s_rad=0.3")
    turned = [Run(run.t_s, -run.command_rad, run.measured_rad) for run in seen.runs]
    assert all(min(loop) >= 0 for loop in loops(Observed(bench(), turned), (0,), CARRIED))
