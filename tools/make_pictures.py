#!/usr/bin/env python3
"""Draw the pictures of the documentation.

tools/make_pictures.py run          docs/run.png, from a run on the simulated board that this script makes itself
tools/make_pictures.py diagnosis    docs/diagnosis.svg, the rooms of a diagnosis and what goes from one to the next
tools/make_pictures.py examples     docs/examples-pwm.png and docs/examples-xl330.png, from the answers that the
                                    commands of docs/examples.md left in this folder; not drawn unless asked for
tools/make_pictures.py blind        docs/blind-reliability.png, docs/blind-wrong-1.png, docs/blind-wrong-2.png and
                                    docs/blind-wrong-3.png, what tools/blind/score --traces 3 left in this folder;
                                    not drawn unless asked for (docs/blind-reliability-seed5.png is an older one)
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np

from snakebot.runlog import read_log

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

ROOT = Path(__file__).resolve().parent.parent
GAIT = ["--alpha", "66", "--beta", "80", "--omega", "2"]

# The rooms of snakebot/diagnosis, in the order of the data: name, what happens there, what goes on to the next.
ROOMS = (
    ("evidence", "clean the runs;\nnominal prediction;\nnoise, tolerance", "residuals,\nallowed\nspread"),
    ("fit", "one explanation:\nleast squares, score\non held-out runs", "parameters,\nheld-out\nscore"),
    ("search", "add effects, prune,\nfind rivals that\ndo as well", "best\nexplanation,\nrivals"),
    ("verdict", "no gap, explained,\npartly, unexplained;\nprobabilities", "causes,\nties,\nclosure"),
    ("proposal", "the motion that\ntells the rivals\napart best", "next\nexperiment"),
    ("show", "terminal, page,\nJSON, calibrated\nrobot", ""),
)  # fmt: skip


def draw_diagnosis() -> None:
    """Boxes from left to right, an arrow with what is handed on, and the way back over the robot."""
    mpl.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "snakebot", "font.family": "sans-serif"})
    figure, axes = plt.subplots(figsize=(16, 3.2))
    wide, tall, step = 2.7, 1.9, 4.3
    for number, (name, does, gives) in enumerate(ROOMS):
        left = number * step
        box = FancyBboxPatch(
            (left, 0), wide, tall, "round,pad=0.06", facecolor="#e8eef7", edgecolor="#34507a"
        )
        axes.add_patch(box)
        axes.text(left + wide / 2, tall - 0.08, name, ha="center", va="top", weight="bold", fontsize=12)
        axes.text(left + wide / 2, 0.65, does, ha="center", va="center", fontsize=8.5)
        if gives:
            ends = (left + wide + 0.1, tall / 2), (left + step - 0.1, tall / 2)
            axes.add_patch(FancyArrowPatch(*ends, arrowstyle="-|>", mutation_scale=14, color="#34507a"))
            axes.text(
                left + (wide + step) / 2, tall / 2 + 0.12, gives, ha="center", va="bottom", fontsize=7.5
            )
    start = FancyArrowPatch(
        (-1.3, tall / 2), (-0.1, tall / 2), arrowstyle="-|>", mutation_scale=14, color="0.2"
    )
    axes.add_patch(start)
    axes.text(-1.35, tall / 2, "session:\nrecorded\nruns", ha="right", va="center", fontsize=9)
    proposal = [name for name, *_ in ROOMS].index("proposal") * step + wide / 2
    for path in (((proposal, -0.1), (proposal, -0.8)), ((proposal, -0.8), (-1.75, -0.8))):
        axes.plot(*zip(*path, strict=True), color="0.4", linestyle="--", linewidth=1)
    back = FancyArrowPatch((-1.75, -0.82), (-1.75, 0.3), arrowstyle="-|>", mutation_scale=14, color="0.4")
    axes.add_patch(back)
    axes.text(
        proposal / 2,
        -0.72,
        "run it on the robot, add it to the session",
        ha="center",
        va="bottom",
        fontsize=9,
    )
    axes.set(xlim=(-2.4, 5 * step + wide + 0.2), ylim=(-1.2, tall + 0.4), aspect="equal")
    axes.axis("off")
    target = ROOT / "docs" / "diagnosis.svg"
    figure.savefig(target, metadata={"Date": None}, bbox_inches="tight")


def draw_run() -> None:
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


EXAMPLES = {
    "docs/examples-pwm.png": [("bare.json", "square_05.csv", "PWM servo, a square wave")],
    "docs/examples-xl330.png": [
        ("kp_100.json", "up_and_down.csv", "XL330, position gain 100"),
        ("kp_800.json", "up_and_down.csv", "XL330, position gain 800"),
    ],
}


def draw_examples() -> None:
    """A trace of each answer: what was asked, what the servo did, and both simulations."""
    for picture, plots in EXAMPLES.items():
        figure, row = plt.subplots(
            1, len(plots), figsize=(9, 3.4), sharey=True, squeeze=False, layout="constrained"
        )
        for axes, (answer, run, title) in zip(row[0], plots, strict=True):
            traces = json.loads(Path(answer).read_text(encoding="utf-8"))["details"]["traces"]
            trace = next(one for one in traces if one["run"] == run)
            for key, label, style in (
                ("command_rad", "command", {"color": "0.45", "linestyle": "--", "linewidth": 1.0}),
                ("before_rad", "simulation now", {"color": "C3", "linewidth": 1.2}),
                ("after_rad", "simulation with it", {"color": "C4", "linewidth": 1.8}),
                ("measured_rad", "servo", {"color": "C0", "linewidth": 1.8}),
            ):
                angle = np.degrees(np.array(trace[key], dtype=float))
                axes.plot(trace["t_s"], angle, label=label, **style)
            axes.set_title(title, fontsize=12)
            axes.set_xlabel("time, s", fontsize=11)
            axes.spines[["top", "right"]].set_visible(False)
            axes.grid(alpha=0.25)
        row[0][0].set_ylabel("angle, deg", fontsize=11)
        figure.legend(
            *row[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False
        )
        figure.savefig(ROOT / picture, dpi=100)


def take_blind() -> None:
    """Of the latest report of the blind check: how often causes were right by their probability, and wrong answers."""
    for name in ("reliability", "wrong_1", "wrong_2", "wrong_3"):
        shutil.copyfile(f"{name}.png", ROOT / "docs" / f"blind-{name.replace('_', '-')}.png")


PICTURES = {
    "run": draw_run,
    "diagnosis": draw_diagnosis,
    "examples": draw_examples,
    "blind": take_blind,
}
ALWAYS = ("run", "diagnosis")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("picture", choices=list(PICTURES), nargs="*")
    for name in dict.fromkeys(parser.parse_args().picture or ALWAYS):
        PICTURES[name]()


if __name__ == "__main__":
    main()
