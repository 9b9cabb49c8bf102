"""Runs of all kinds that go through the servo stage together come out as one by one."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from snakebot.effects import assemble
from snakebot.effects.prediction import joint_run, joint_runs
from snakebot.effects.servo_stage import ServoRun
from snakebot.effects.stages import Stages
from snakebot.robot import load_robot

ROBOT = load_robot("penn_state")
SPECS = {
    "nothing": (),
    "late joints": ("command_delay:delay_s=0.03,joints=2",),
    "swapped cables, and chance": ("wiring:permutation=2+1+3+4+5", "command_loss:probability=0.2"),
    "a rigid joint": ("joint_rigid:angle_deg=5,joints=3",),
    "feels the load": ("joint_friction:coulomb_nm=0.2,stiffness_nm_rad=20,joints=4",),
    "sensor": ("encoder_offset:offset_deg=2,joints=5",),
}


def run_of(stages: Stages, samples: int, kind: str) -> ServoRun:
    """A run of this many samples at 50 Hz, that has load, an unpowered while, known angles, or nothing of it."""
    rng = np.random.default_rng(samples)
    t_s = np.arange(samples) / 50
    command = 0.5 * np.sin(6 * t_s[:, None] + np.arange(5))
    known = 0.4 * np.sin(6 * t_s[:, None] + np.arange(5) - 0.3)
    if kind == "unpowered":
        command[samples // 3 : samples // 2, 1] = np.nan
    run = ServoRun(t_s, stages.link(t_s, command), known_rad=known)
    if kind == "loaded":
        return dataclasses.replace(run, load_nm=0.1 * rng.normal(size=known.shape))
    if kind == "without readings":
        return dataclasses.replace(run, known_rad=None, initial_rad=[0.1, 0.0, -0.1, 0.0, 0.2])
    if kind == "a reading is missing":
        known[0, 2] = np.nan
    return run


@pytest.mark.parametrize("name", SPECS)
def test_together_as_one_by_one(name: str) -> None:
    stages = assemble(ROBOT, SPECS[name])
    kinds = ("plain", "loaded", "unpowered", "without readings", "a reading is missing", "plain", "loaded")
    runs = [run_of(stages, 40 + 7 * i, kind) for i, kind in enumerate(kinds)]
    together = joint_runs(stages, runs)
    for run, found in zip(runs, together, strict=True):
        alone = joint_run(stages, run)
        assert np.isfinite(found.reading_rad).all()
        np.testing.assert_array_equal(found.reading_rad, alone.reading_rad)
        np.testing.assert_array_equal(found.servos.load_nm, alone.servos.load_nm)
        np.testing.assert_array_equal(found.servos.powered, alone.servos.powered)
    assert len({found.reading_rad.tobytes() for found in together}) == len(runs)


def test_no_run_gives_no_run() -> None:
    assert joint_runs(assemble(ROBOT, ()), []) == []
