"""Finds the runs that repeat another's motion: they tell the noise floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from snakebot.runlog.run import Run

SAME_COMMAND = 0.02  # rms difference over rms of the command; what is left is the jitter of the ticks
_CIRCUMSTANCES = ("faults", "effects", "robot", "port", "simulated", "lifted")


def mark_repeats(runs: Sequence[Run]) -> tuple[Run, ...]:
    """The runs, each that repeats an earlier one marked so; a run that says itself what it repeats is left as it is.

    The same motion: equal commands at equal times, the same gait, and the same faults, effects, robot and port.
    """
    marked: list[Run] = []
    for run in runs:
        if run.repeat_of is None:
            first = next(
                (other for other in marked if other.repeat_of is None and is_repeat(run, other)), None
            )
            run = run if first is None else replace(run, repeat_of=first.name)
        marked.append(run)
    firsts = {run.name: run.repeat_of for run in marked}
    return tuple(
        run
        if firsts.get(run.repeat_of or "") is None
        else replace(run, repeat_of=firsts[run.repeat_of or ""])
        for run in marked
    )


def is_repeat(run: Run, other: Run) -> bool:
    """Whether two runs were commanded the same motion under the same circumstances."""
    if run.joints != other.joints or run.gait != other.gait:
        return False
    if any(run.metadata.get(key) != other.metadata.get(key) for key in _CIRCUMSTANCES):
        return False
    if abs(run.duration_s - other.duration_s) > SAME_COMMAND * max(run.duration_s, other.duration_s):
        return False
    t_s = run.t_s - run.t_s[0]
    difference = amplitude = 0.0
    for mine, theirs in zip(run.command_rad.T, other.command_rad.T, strict=True):
        known = np.isfinite(theirs)
        if np.isfinite(mine).any() != known.any():
            return False
        if not known.any():
            continue
        there = np.interp(t_s, other.t_s[known] - other.t_s[0], theirs[known])
        both = np.isfinite(mine)
        difference += float(np.sum((mine - there)[both] ** 2))
        amplitude += float(np.sum(mine[both] ** 2))
    return amplitude > 0 and difference <= SAME_COMMAND**2 * amplitude
