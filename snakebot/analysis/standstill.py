"""Stretches in which a joint is told to move and its reading stands still: a plug that came loose for a while."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from snakebot.arrays import Floats
from snakebot.robot import Robot
from snakebot.runlog import Run

STILL_COUNTS = 2.5  # range of readings in encoder counts, up to which a joint stands still; chosen
LEAST_S = 1.0  # of a stretch; a shorter stop comes with every reversal of a joint that has play; chosen
# Range of the commands in a stretch. A soft servo that holds a weight lets 17 deg go by (recordings of others); chosen.
LEAST_TOLD_RAD = math.radians(30)
# Before a reading moves again, in which its command may have moved already: delay and lag of a sound joint, s; chosen.
ANSWERS_IN_S = 0.4


@dataclass(frozen=True)
class Standstill:
    """Where a joint (0-based) stood still, from its run's first sample on, and over which range it was told to move."""

    joint: int
    start_s: float
    end_s: float
    told_rad: float


def standstills(run: Run, robot: Robot) -> list[Standstill]:
    """All stretches of a run; where a joint stands still over the whole run, or nearly, that is no stretch."""
    found = []
    for joint in range(run.joints):
        known = np.isfinite(run.command_rad[:, joint]) & np.isfinite(run.measured_rad[:, joint])
        if known.sum() >= 3:
            t_s, told = run.t_s[known], run.command_rad[known, joint]
            seen = run.measured_rad[known, joint]
            if float(np.ptp(seen)) > STILL_COUNTS * robot.rad_per_count:
                for start, end in _still(t_s, seen, STILL_COUNTS * robot.rad_per_count):
                    asked = told[start:end][t_s[start:end] <= t_s[end - 1] - ANSWERS_IN_S]
                    range_rad = float(np.ptp(asked)) if asked.size else 0.0
                    if range_rad >= LEAST_TOLD_RAD:
                        begin_s, end_s = (float(t_s[at] - run.t_s[0]) for at in (start, end - 1))
                        found.append(Standstill(joint, begin_s, end_s, range_rad))
    return found


def standstill_lines(runs: Sequence[Run], robot: Robot) -> list[str]:
    """A line for each joint of several runs of one robot: its longest stretch, and how many more there are."""
    by_joint: dict[int, list[tuple[str, Standstill]]] = {}
    for run in runs:
        for one in standstills(run, robot):
            by_joint.setdefault(one.joint, []).append((run.name, one))
    lines = []
    for joint, found in sorted(by_joint.items()):
        name, one = max(found, key=lambda pair: pair[1].end_s - pair[1].start_s)
        others = len(found) - 1
        more = f" (and {others} more such stretch{'es' * (others > 1)})" if others else ""
        lines.append(
            f"{name}: from {one.start_s:.1f} to {one.end_s:.1f} s joint {joint + 1} is told to move by "
            f"{math.degrees(one.told_rad):.3g} deg and its reading does not change{more}: "
            "a loose plug, a servo that switched off, or a stop?"
        )
    return lines


def _still(t_s: Floats, seen_rad: Floats, most_rad: float) -> list[tuple[int, int]]:
    """First sample and end of the stretches of ``LEAST_S`` and more in which readings keep within ``most_rad``."""
    width = math.ceil(LEAST_S / float(np.median(np.diff(t_s)))) + 1
    if width < 3 or width > t_s.size:
        return []
    windows = sliding_window_view(seen_rad, width)
    still = windows.max(axis=1) - windows.min(axis=1) <= most_rad
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    ends = edges[1::2] + width - 1
    return [(int(a), int(b)) for a, b in zip(edges[::2], ends, strict=True) if t_s[b - 1] - t_s[a] >= LEAST_S]
