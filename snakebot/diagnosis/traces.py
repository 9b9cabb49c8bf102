"""A few stretches, held out where runs are, for pictures: command, measured, and predicted before and after."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.context import Context
from snakebot.diagnosis.result import Trace
from snakebot.diagnosis.trial import Trial

Floats = NDArray[np.float64]

POINTS = 400
RUNS = 3


def traces(context: Context, nominal: Trial, best: Trial) -> tuple[Trace, ...]:
    """The runs and joints with the largest gap, one trace a motion."""
    blocks = context.angle_blocks
    size: dict[tuple[int, int], float] = {}
    for run in context.shown_runs:
        for joint in range(context.data.joints):
            rows = (blocks.run == run) & (blocks.joint == joint)
            if rows.any():
                size[run, joint] = float(nominal.held_square[: blocks.count][rows].mean())
    out: list[Trace] = []
    seen: set[int] = set()
    for run, joint in sorted(size, key=lambda key: (-size[key], key)):
        motion = context.data.runs[run].motion
        if motion in seen or len(out) >= RUNS:
            continue
        seen.add(motion)
        out.append(_trace(context, nominal, best, run, joint))
    return tuple(out)


def _trace(context: Context, nominal: Trial, best: Trial, index: int, joint: int) -> Trace:
    run = context.data.runs[index]
    keep = np.unique(np.linspace(0, run.t_s.size - 1, min(POINTS, run.t_s.size)).astype(int))

    def column(values: Floats) -> tuple[float | None, ...]:
        return tuple(round(float(v), 5) if np.isfinite(v) else None for v in values[keep, joint])

    return Trace(
        run=run.name,
        joint=joint + 1,
        t_s=tuple(round(float(t), 4) for t in run.t_s[keep]),
        command_rad=column(run.command_rad),
        measured_rad=column(run.measured_rad),
        before_rad=column(nominal.readings[index]),
        after_rad=column(best.readings[index]),
    )
