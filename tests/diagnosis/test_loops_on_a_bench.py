"""Servos under load on a bench: the loop is named with its stiffness, a weight with its mass, a missing arm is told."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.diagnosis import Diagnosis, diagnose
from snakebot.effects import Plant
from snakebot.robot import Robot, robot_from_mapping
from snakebot.runlog import Run, Session

pytestmark = pytest.mark.slow

LOOP = (
    "position_loop:stiffness_nm_rad=0.9,damping_nm_s_rad=0.04,armature_kg_m2=0.0016,coulomb_nm=0.02,"
    "load_friction=0.2,drive_friction_per_nm=0.4,full_drive_deg=45"
)
RIVALS = ("position_loop", "arm_payload", "second_order", "command_gain", "servo_offset", "compliance")


def bench(*effects: str, arm: bool = True, down_deg: float = 0.0) -> Robot:
    servo = {"arm": {"mass_kg": 0.3, "length_m": 0.1, "down_deg": down_deg}} if arm else {}
    return robot_from_mapping(
        {"joints": 1, "encoder_counts_per_rev": 4096, "servo": servo, "effects": list(effects)}, "bench"
    )


def session(true: Robot, stated: Robot, *specs: str) -> Session:
    """Slow and fast sines and a drop, of one robot, with the description of another."""
    t = np.arange(0, 6, 0.01)
    motions = {
        "slow": 1.3 * np.sin(1.2 * t) * np.minimum(t, 1),
        "fast": 0.9 * np.sin(1.5 * t + 0.9 * t**2),
        "two": 0.8 * np.sin(2 * t) + 0.5 * np.sin(5 * t),
        "drop": np.where(t < 2, 1.2 * np.sin(np.pi * t / 4) ** 2, np.nan),
    }
    runs = []
    for index, (name, command) in enumerate(motions.items()):
        plant, readings = Plant(true, specs, seed=index), []
        for now, setpoint in zip(t, command, strict=True):
            plant.advance(now)
            readings.append(plant.encoder_rad())
            plant.command(now, [setpoint])
        runs.append(Run(f"{name}.csv", t, command[:, None], np.array(readings)))
    return Session(stated, tuple(runs))


def value(found: Diagnosis, effect: str, parameter: str) -> float:
    (cause,) = found.causes
    assert cause.effect == effect
    return cause.parameters[parameter].estimate


def test_the_loop_is_named_with_its_stiffness() -> None:
    found = diagnose(session(bench(LOOP), bench()), only=RIVALS)
    assert found.verdict == "explained"
    assert value(found, "position_loop", "stiffness_nm_rad") == pytest.approx(0.9, rel=0.05)
    assert not any("describe the arm" in text for text in found.warnings)


def test_without_an_arm_the_stiffness_is_in_units_of_the_weight() -> None:
    found = diagnose(session(bench(LOOP), bench(arm=False)), only=RIVALS)
    weight_nm = 0.3 * 9.80665 * 0.1
    assert value(found, "position_loop", "stiffness_nm_rad") == pytest.approx(0.9 / weight_nm, rel=0.15)
    assert any("describe the arm" in text for text in found.warnings)


def test_a_horn_that_is_not_put_on_to_a_degree_is_part_of_the_loop() -> None:
    found = diagnose(session(bench(LOOP, down_deg=4.0), bench()), only=RIVALS)
    assert found.verdict == "explained"
    assert value(found, "position_loop", "stiffness_nm_rad") == pytest.approx(0.9, rel=0.05)
    assert value(found, "position_loop", "down_deg") == pytest.approx(4.0, abs=0.3)


def test_a_weight_on_a_calibrated_bench_is_named_with_its_mass() -> None:
    calibrated = bench(LOOP)
    found = diagnose(session(calibrated, calibrated, "arm_payload:mass_kg=0.1"), only=RIVALS)
    assert value(found, "arm_payload", "mass_kg") == pytest.approx(0.1, rel=0.05)
