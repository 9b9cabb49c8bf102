"""A few stretches, held out where runs are, for pictures: command, measured, and predicted before and after."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.result import Cause, Trace

MOST_POINTS = 400  # samples of a trace; chosen
MOST_RUNS = 3  # traces that are drawn, where causes need no more; chosen


def traces(
    angles: AngleEvidence, shown: Sequence[int], nominal: Trial, best: Trial, causes: Sequence[Cause]
) -> tuple[Trace, ...]:
    """Of the ``shown`` runs for each cause the one, and the joint, in which it shows best; then those with the largest
    gap, one trace a motion.
    """
    blocks = angles.blocks
    before, after = (angles.mean_square(trial.readings) for trial in (nominal, best))
    gap: dict[tuple[int, int], float] = {}
    fall: dict[tuple[int, int], float] = {}
    for run in shown:
        for joint in range(angles.data.joints):
            rows = (blocks.run == run) & (blocks.joint == joint)
            if rows.any():
                gap[run, joint] = float(before[rows].mean())
                fall[run, joint] = gap[run, joint] - float(after[rows].mean())
    out: list[Trace] = []
    seen: set[int] = set()
    for number, cause in enumerate(causes):
        where = [key for key in fall if key[1] + 1 in cause.joints]
        if cause.stage != "body" and where:
            run, joint = max(where, key=lambda key: (fall[key], -key[0], -key[1]))
            seen.add(angles.data.runs[run].motion)
            out.append(_trace(angles, nominal, best, run, joint, number))
    for run, joint in sorted(gap, key=lambda key: (-gap[key], key)):
        motion = angles.data.runs[run].motion
        if motion in seen or len(out) >= MOST_RUNS:
            continue
        seen.add(motion)
        out.append(_trace(angles, nominal, best, run, joint, None))
    return tuple(out)


def _trace(
    angles: AngleEvidence, nominal: Trial, best: Trial, index: int, joint: int, cause: int | None
) -> Trace:
    run = angles.data.runs[index]
    keep = np.unique(np.linspace(0, run.t_s.size - 1, min(MOST_POINTS, run.t_s.size)).astype(int))

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
        cause=cause,
    )
