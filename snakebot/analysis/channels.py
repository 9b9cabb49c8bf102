"""Channels that cannot be right: joints whose reading is dead, and pairs whose channels are swapped."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from snakebot.analysis.faults import joint_faults
from snakebot.arrays import Floats
from snakebot.robot import Robot
from snakebot.runlog import Run

# In encoder counts; chosen. A range above the first is a motion, one of up to the second is none, whatever the noise.
_MOVES_COUNTS, _STILL_COUNTS = 20.0, 2.5
# Misfit is 1 - correlation. A servo that trails by 26 deg of the gait's phase has 0.1; two commands of a wave with
# beta = 37 deg have 0.2 between them, with less they cannot be told apart by a servo's lag.
_FITS, _CLEARLY_WORSE = 0.1, 0.2
_FEWEST = 20  # samples


@dataclass(frozen=True)
class ChannelDoubt:
    """One joint that is dead, or two whose channels are swapped; 0-based.

    Attributes:
        told_rad: how far a dead joint is told to move, largest minus smallest set-point; 0 of a swapped pair.
    """

    joints: tuple[int, ...]
    told_rad: float = 0.0

    @property
    def text(self) -> str:
        """What a user should look at; one line."""
        if len(self.joints) == 2:
            a, b = (joint + 1 for joint in self.joints)
            return (
                f"joints {a} and {b}: each reading follows the other's command: are their channels swapped?"
            )
        return (
            f"joint {self.joints[0] + 1} is told to move by {math.degrees(self.told_rad):.3g} deg and its reading "
            "does not change: servo without power, encoder, or cable?"
        )


def channel_doubts(run: Run, robot: Robot) -> list[ChannelDoubt]:
    """What is doubtful about the channels of a run. Joints with a known fault are left out."""
    faults = joint_faults(run.metadata, run.joints)
    if len(run) < _FEWEST or faults.changed:
        return []
    faulty = {joint - 1 for joint in (*faults.free, *faults.rigid)}
    swapped = swapped_joints(run.command_rad, run.measured_rad, robot.rad_per_count)
    explained = {joint for pair in swapped for joint in pair} | faulty
    dead = dead_joints(run.command_rad, run.measured_rad, robot.rad_per_count)
    return [ChannelDoubt(pair) for pair in swapped if not set(pair) & faulty] + [
        ChannelDoubt((joint,), _range(run.command_rad[:, joint])) for joint in dead if joint not in explained
    ]


def doubts_of_runs(runs: Sequence[Run], robot: Robot) -> list[str]:
    """The same of several runs of one robot: a line for each joint or pair, with the runs that show it."""
    shown: dict[tuple[int, ...], list[tuple[str, ChannelDoubt]]] = {}
    for run in runs:
        for doubt in channel_doubts(run, robot):
            shown.setdefault(doubt.joints, []).append((run.name, doubt))
    lines = []
    for found in shown.values():
        names = [name for name, _ in found]
        where = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
        worst = max((doubt for _, doubt in found), key=lambda doubt: doubt.told_rad)
        if 1 < len(names) == len(runs):
            where = "every run"
        lines.append(f"{where}: {worst.text}")
    return lines


def dead_joints(command_rad: Floats, measured_rad: Floats, rad_per_count: float) -> list[int]:
    """0-based joints that are told to move and whose reading does not change, or never came.

    Args:
        command_rad, measured_rad: shape (N, k); nan where unknown.
        rad_per_count: of the encoders.
    """
    return [
        joint
        for joint in range(command_rad.shape[1])
        if _range(command_rad[:, joint]) > _MOVES_COUNTS * rad_per_count
        and _range(measured_rad[:, joint]) <= _STILL_COUNTS * rad_per_count
    ]


def swapped_joints(command_rad: Floats, measured_rad: Floats, rad_per_count: float) -> list[tuple[int, int]]:
    """Pairs of 0-based joints of which each reading follows the other's command, and clearly not its own.

    Args: as ``dead_joints``.
    """
    misfit = _misfit(command_rad, measured_rad, rad_per_count)
    return [
        (a, b)
        for a, b in combinations(range(command_rad.shape[1]), 2)
        if max(misfit[a, b], misfit[b, a]) < _FITS and min(misfit[a, a], misfit[b, b]) > _CLEARLY_WORSE
    ]


def _misfit(command_rad: Floats, measured_rad: Floats, rad_per_count: float) -> Floats:
    """Of reading a to command b, shape (k, k): 1 - correlation; 0 where neither moves, 1 where only one does."""
    joints = command_rad.shape[1]
    moves = _MOVES_COUNTS * rad_per_count
    told = [_range(command_rad[:, j]) > moves for j in range(joints)]
    seen = [_range(measured_rad[:, j]) > moves for j in range(joints)]
    misfit = np.ones((joints, joints))
    for a in range(joints):
        for b in range(joints):
            both = np.isfinite(measured_rad[:, a]) & np.isfinite(command_rad[:, b])
            if both.sum() < _FEWEST:
                continue
            if told[b] and seen[a]:
                misfit[a, b] = 1.0 - _correlation(measured_rad[both, a], command_rad[both, b])
            elif not told[b] and not seen[a]:
                misfit[a, b] = 0.0
    return misfit


def _correlation(x: Floats, y: Floats) -> float:
    x, y = x - x.mean(), y - y.mean()
    power = float(x @ x) * float(y @ y)
    return float(x @ y) / math.sqrt(power) if power > 0 else 0.0


def _range(values: Floats) -> float:
    """Largest minus smallest of those that are known; 0 where none is."""
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if known.size else 0.0
