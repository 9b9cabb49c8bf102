"""A case as a session folder that tells nothing but its signals.

All folders have the same time stamps, and those of robots with as many joints and the same rate, of which as much was
recorded, files of the same names and sizes: every number is written to a fixed width.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from blind.cases import Case
from blind.motions import Motion
from blind.records import forward_speed
from blind.robot import COUNTS_PER_REV, Recording

STAMP_S = 1_600_000_000  # of every file and folder


def _header(joints: int, *, pose: bool) -> str:
    columns = [f"{what}_{j}_rad" for what in ("cmd", "enc") for j in range(1, joints + 1)]
    return ",".join(["t_s", *columns, *(["x_m", "y_m", "heading_rad"] if pose else [])])


def write_session(folder: Path, case: Case) -> None:
    """Raises FileExistsError where the folder is there already."""
    link = case.build.link
    lines = [
        "robot:",
        f"  links: {case.build.joints + 1}",
        f"  half_length_m: {link['half_length_m']}",
        f"  link_mass_kg: {link['mass_kg']}",
        f"  friction: {{ct: {link['ct']}, cn: {link['cn']}, ct0: {link['ct0']}, cn0: {link['cn0']}}}",
        f"  servo: {{time_constant_s: {case.build.lag_s:06.4f}}}",
        f"  encoder_counts_per_rev: {COUNTS_PER_REV}",
    ]
    folder.mkdir()
    runs = case.runs()
    speeds = None if case.records.pose else [forward_speed(run, case.rng) for run in runs]
    write_runs(folder, lines, case.motions, runs, speeds)


def write_runs(
    folder: Path,
    robot: list[str],
    motions: Sequence[Motion],
    runs: Sequence[Recording],
    speeds_m_s: Sequence[float] | None = None,
) -> None:
    """Into an empty folder: what the lab says of its robot, and runs of the motions, the first of them once more.

    ``speeds_m_s``: of each run, in place of its pose.
    """
    names = [f"run_{i + 1:02d}.csv" for i in range(len(runs))]
    lines = [*robot, "runs:"]
    for i, (name, motion) in enumerate(zip(names, [*motions, motions[0]], strict=True)):
        lines.append(f"  - file: {name}")
        if motion.is_gait:
            lines.append(
                f"    gait: {{alpha_deg: {np.degrees(motion.alpha_rad):010.6f}, "
                f"beta_deg: {np.degrees(motion.beta_rad):010.6f}, omega_rad_s: {motion.omega_rad_s:08.6f}, "
                f"offset_deg: {np.degrees(motion.offset_rad):+010.6f}}}"
            )
        if speeds_m_s is not None:
            lines.append(f"    forward_speed_m_s: {speeds_m_s[i]:+09.6f}")
        if i == len(names) - 1:
            lines.append(f"    repeat_of: {names[0]}")
    _put(folder / "session.yaml", "\n".join(lines) + "\n")
    for name, run in zip(names, runs, strict=True):
        _put(folder / name, _table(run, pose=speeds_m_s is None))
    os.utime(folder, (STAMP_S, STAMP_S))


def add_run(
    folder: Path,
    run: Recording,
    gait: dict[str, float] | None,
    probe: str | None = None,
    *,
    lifted: bool = False,
    speed_m_s: float | None = None,
) -> None:
    """One more run for a session, as of a lab that does what was proposed; ``lifted`` off the ground it has no pose,
    nor where the lab has a speed in its place.
    """
    count = len(list(folder.glob("run_*.csv")))
    name = f"run_{count + 1:02d}.csv"
    entry = f"  - file: {name}\n"
    if gait is not None:
        entry += "    gait: {" + ", ".join(f"{k}: {v:.6f}" for k, v in gait.items()) + "}\n"
    if speed_m_s is not None and not lifted:
        entry += f"    forward_speed_m_s: {speed_m_s:.6f}\n"
    about = [f'probe: "{probe}"'] * (probe is not None) + ["lifted: true"] * lifted
    if about:
        entry += "    metadata: {" + ", ".join(about) + "}\n"
    with (folder / "session.yaml").open("a") as file:
        file.write(entry)
    _put(folder / name, _table(run, pose=not lifted and speed_m_s is None))


def _table(run: Recording, *, pose: bool) -> str:
    rows = np.column_stack([run.t_s, run.command_rad, run.encoder_rad, *([run.pose] if pose else [])])
    text = [",".join(f"{v:+011.6f}" for v in row) for row in rows]
    return "\n".join([_header(run.command_rad.shape[1], pose=pose), *text]) + "\n"


def _put(path: Path, text: str) -> None:
    path.write_text(text, encoding="ascii")
    os.utime(path, (STAMP_S, STAMP_S))
