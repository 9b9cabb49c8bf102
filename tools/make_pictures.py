#!/usr/bin/env python3
"""Draw the README's picture, docs/run.png, from a run on the simulated board that this script makes itself."""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np

from snakebot.runlog import read_log

mpl.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parent.parent
GAIT = ["--alpha", "66", "--beta", "80", "--omega", "2"]


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "run.mcap"
        options = [*GAIT, "--cycles", "6", "--fast", "--log", str(log)]
        subprocess.run(
            [sys.executable, "-m", "snakebot.cli.main", "run", *options],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        run = read_log(log).to_run()
        robot = read_log(log).robot
    assert run.pose is not None
    assert robot.body is not None
    length = robot.body.half_length_m
    figure, (ground, joints) = plt.subplots(
        2, 1, figsize=(10, 5.2), height_ratios=(1, 1.1), layout="constrained"
    )
    ground.plot(run.pose[:, 0], run.pose[:, 1], color="0.75", linewidth=1, label="centre of mass")
    colours = plt.get_cmap("viridis")
    for moment in np.linspace(2, 20, 7):
        k = int(np.searchsorted(run.t_s, moment))
        x, y = body(run.measured_rad[k], run.pose[k], length)
        ground.plot(x, y, "-o", color=colours(moment / 24), linewidth=3, markersize=4, solid_capstyle="round")
        ground.annotate(
            f"{moment:.0f} s", (x.mean(), y.max()), (0, 6), textcoords="offset points", ha="center"
        )
    ground.set(aspect="equal", xlabel="x, m", ylabel="y, m", title="the body over the ground")
    window = (run.t_s >= 6) & (run.t_s <= 12.5)
    for joint in range(run.joints):
        colour = f"C{joint}"
        joints.plot(
            run.t_s[window],
            np.degrees(run.command_rad[window, joint]),
            color=colour,
            linewidth=0.8,
            alpha=0.5,
        )
        joints.plot(
            run.t_s[window],
            np.degrees(run.measured_rad[window, joint]),
            color=colour,
            label=f"joint {joint + 1}",
        )
    joints.set(xlabel="time, s", ylabel="angle, deg", title="set-points (thin) and encoders")
    joints.legend(ncols=5, loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)
    for axes in (ground, joints):
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(ROOT / "docs" / "run.png", dpi=110)


def body(
    joint_angle_rad: np.ndarray, pose: np.ndarray, half_length_m: float
) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the links over the ground, from joint angles and the pose of the centre of mass."""
    angles = np.concatenate([[0.0], np.cumsum(joint_angle_rad)])
    angles += pose[2] - angles.mean()
    ends = np.concatenate([[0], np.cumsum(2 * half_length_m * np.exp(1j * angles))])
    centres = (ends[1:] + ends[:-1]) / 2
    ends += complex(pose[0], pose[1]) - centres.mean()
    assert math.isclose(abs(ends[1] - ends[0]), 2 * half_length_m)
    return ends.real, ends.imag


if __name__ == "__main__":
    main()
