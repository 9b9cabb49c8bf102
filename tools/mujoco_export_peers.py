"""The exported model in MuJoCo beside our own prediction, on the same commands: what the export keeps of each effect.

    python tools/mujoco_export_peers.py

A recording of 6 s is simulated with each effect of the library, at the size of its example, with noise of the encoders
of 0.05 deg. Printed: the error of our own prediction and of MuJoCo against it, and the way over ground of both.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import tempfile
from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import Any

import numpy as np

from snakebot.arrays import Floats
from snakebot.calibrated.mujoco_model import mujoco_model
from snakebot.effects import effects, predict
from snakebot.gait import Gait, GaitMotion
from snakebot.robot import Robot, load_robot

NOISE_DEG = 0.05
GAIT = Gait(radians(30), radians(80), 4.0)


@dataclass(frozen=True)
class Compared:
    """Errors against the recording, root mean square, and ways over ground in its second half (nan on a bench)."""

    ours_rad: float
    theirs_rad: float
    our_way_m: float
    their_way_m: float


def exported(robot: Robot, folder: Path) -> tuple[Any, Any]:
    """The model in MuJoCo, and its callbacks, as a user would load them."""
    import mujoco

    path = folder / "snake.xml"
    made = mujoco_model(robot, path)
    path.write_text(made.xml, encoding="utf-8")
    (folder / "snake.py").write_text(made.callbacks, encoding="utf-8")
    spec = importlib.util.spec_from_file_location("snake", folder / "snake.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return mujoco.MjModel.from_xml_path(str(path)), module


def in_mujoco(
    robot: Robot, t_s: Floats, command_rad: Floats, start_rad: Floats, folder: Path
) -> tuple[Floats, Floats]:
    """Readings (N, k), and centres of mass (N, 2), at the times (N,) of commands (N, k)."""
    import mujoco

    model, callbacks = exported(robot, folder)
    data = mujoco.MjData(model)
    held = callbacks.install(model)
    try:
        held.put_down(data, start_rad)
        steps = round(float(t_s[1] - t_s[0]) / model.opt.timestep)
        readings, places = [], []
        for setpoint in command_rad:
            readings.append(held.encoders(data))
            places.append(np.average(data.xipos[1:], axis=0, weights=model.body_mass[1:])[:2])
            data.ctrl[:] = setpoint
            mujoco.mj_step(model, data, steps)
    finally:
        callbacks.remove()
    return np.array(readings), np.array(places)


def compare(robot: Robot, specs: tuple[str, ...], folder: Path, duration_s: float = 6.0) -> Compared:
    """A recording of the robot with effects, our own prediction of it, and that of the exported model."""
    t = np.arange(int(duration_s * 100)) / 100
    command = GaitMotion(GAIT, robot.joints, duration_s, 1.0).sampled(t)
    calibrated = robot.model_copy(update={"effects": specs})
    ours = predict(calibrated, (), t, command, body=robot.body is not None, quantise=False)
    noise = np.radians(NOISE_DEG) * np.random.default_rng(0).normal(size=command.shape)
    recorded = np.round((ours.encoder_rad + noise) / robot.rad_per_count) * robot.rad_per_count
    readings, places = in_mujoco(calibrated, t, command, ours.joint_angle_rad[0], folder)
    half, way = t.size // 2, float("nan")
    if ours.motion is not None:
        way = float(np.linalg.norm(ours.motion.com_m[-1] - ours.motion.com_m[half]))
    return Compared(
        ours_rad=float(np.sqrt(np.mean(np.square(ours.encoder_rad - recorded)))),
        theirs_rad=float(np.sqrt(np.mean(np.square(readings - recorded)))),
        our_way_m=way,
        their_way_m=float(np.linalg.norm(places[-1] - places[half])),
    )


def main() -> int:
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    robot = load_robot("penn_state")
    print("effect                 ours, mrad   MuJoCo, mrad   ratio   way, mm (ours, MuJoCo)")
    for spec in ("", *(effect.example for effect in effects().values() if effect.applies_to(robot))):
        with tempfile.TemporaryDirectory() as folder:
            found = compare(robot, (spec,) if spec else (), Path(folder))
        ratio = found.theirs_rad / found.ours_rad
        print(
            f"{spec.partition(':')[0] or 'none':22} {1e3 * found.ours_rad:8.2f} {1e3 * found.theirs_rad:14.2f} "
            f"{ratio:9.2f}   {1e3 * found.our_way_m:.0f}, {1e3 * found.their_way_m:.0f}",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
