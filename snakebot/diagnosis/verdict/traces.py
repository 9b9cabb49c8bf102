"""A few stretches, held out where runs are, for pictures: command, measured, and predicted before and after.

Of several causes each is shown where it matters most: where the prediction with all the others is worst without it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.predictor import Predictor
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.result import Cause, Trace
from snakebot.diagnosis.sizes import MOST_TOLD
from snakebot.diagnosis.verdict.budget import specs_by_run

MOST_POINTS = 400  # samples of a trace; chosen


def traces(
    evidence: Evidence, nominal: Trial, best: Trial, causes: Sequence[Cause], terms: Sequence[int | None]
) -> tuple[Trace, ...]:
    """Of the runs shown for each cause the one, and the joint, in which it shows best; then those with the largest gap,
    one trace a motion.

    Args:
        terms: for each cause its place in the hypothesis of ``best``; None where it has none.
    """
    angles, shown = evidence.angles, evidence.split.shown
    gap, left = (_square_of(angles, shown, trial.readings) for trial in (nominal, best))
    out: list[Trace] = []
    seen: set[int] = set()
    for number, (cause, term) in enumerate(zip(causes, terms, strict=True)):
        where = [key for key in gap if key[1] + 1 in cause.joints]
        if cause.stage == "body" or not where:
            continue
        others = _without(evidence.predictor, shown, best, term) if len(best.hypothesis.terms) > 1 else None
        off = gap if others is None else _square_of(angles, shown, others)

        def plain(key: tuple[int, int], off: dict[tuple[int, int], float] = off) -> float:
            """What the cause takes away, times its part of the gap: much of it, and little of others. Nothing where all
            causes together are further off than none: no picture of what they do.
            """
            return max(off[key] - left[key], 0.0) ** 2 / gap[key] if left[key] < gap[key] else 0.0

        run, joint = max(where, key=lambda key: (plain(key), -key[0], -key[1]))
        seen.add(angles.data.runs[run].motion)
        out.append(_trace(angles, nominal, best, run, joint, number, others))
    for run, joint in sorted(gap, key=lambda key: (-gap[key], key)):
        motion = angles.data.runs[run].motion
        if motion in seen or len(out) >= MOST_TOLD:
            continue
        seen.add(motion)
        out.append(_trace(angles, nominal, best, run, joint, None, None))
    return tuple(out)


def _square_of(
    angles: AngleEvidence, shown: Sequence[int], readings: Sequence[Floats]
) -> dict[tuple[int, int], float]:
    """Mean square error of each run and joint that was read, rad^2."""
    blocks, square = angles.blocks, angles.mean_square(readings)
    out = {}
    for run in shown:
        for joint in range(angles.data.joints):
            rows = (blocks.run == run) & (blocks.joint == joint)
            if rows.any():
                out[run, joint] = float(square[rows].mean())
    return out


def _without(
    predictor: Predictor, shown: Sequence[int], best: Trial, term: int | None
) -> list[Floats] | None:
    """Readings as predicted with all terms but one."""
    if term is None:
        return None
    kept = frozenset(at for at in range(len(best.hypothesis.terms)) if at != term)
    readings = list(best.readings)
    for runs, specs in specs_by_run(best, kept, shown):
        for index, reading in zip(runs, predictor.readings(specs, runs), strict=True):
            readings[index] = reading
    return readings


def _trace(
    angles: AngleEvidence,
    nominal: Trial,
    best: Trial,
    index: int,
    joint: int,
    cause: int | None,
    others: Sequence[Floats] | None,
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
        others_rad=() if others is None else column(others[index]),
    )
