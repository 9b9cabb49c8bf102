"""Finds the runs that repeat another's motion: they tell the noise floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from snakebot.runlog.matching.motion import CommandedMotion, same_motion
from snakebot.runlog.run import Run

_CIRCUMSTANCES = ("faults", "effects", "robot", "port", "simulated", "lifted")


def mark_repeats(runs: Sequence[Run]) -> tuple[Run, ...]:
    """The runs, each that repeats an earlier one marked so; a run that says itself what it repeats is left as it is.

    The same motion (see ``matching``) under the same faults, effects, robot and port.
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
    if any(run.metadata.get(key) != other.metadata.get(key) for key in _CIRCUMSTANCES):
        return False
    return same_motion(CommandedMotion.of(run), CommandedMotion.of(other)) is not None
