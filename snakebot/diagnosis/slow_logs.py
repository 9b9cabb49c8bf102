"""Logs that are slower than the set-points came, told by the gap that they make.

A log of every fifth set-point, taken as held, says that the robot was told everything two ticks later than it was: a
sound robot then runs ahead of its prediction. A curve through the rows, cut into ticks, takes that gap away.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.context import Context
from snakebot.diagnosis.data import Data
from snakebot.diagnosis.hypothesis import Hypothesis
from snakebot.diagnosis.result import Cause, RankingEntry
from snakebot.diagnosis.simulate import Simulator
from snakebot.diagnosis.ticks import SLOWER, is_slow, row_s

Floats = NDArray[np.float64]

TICKS_S = (0.05, 0.02, 0.01, 0.005, 0.002)  # intervals of set-points that are tried
PLAIN = 2.0  # times the tolerance in time that half a row must be, for a log to be too slow
GAP = 3.0  # mean square over the allowed one, from which on a joint has a gap in a run
CLOSED = 0.75  # share of such a gap that is taken away ...
MOST = 0.6  # ... in this share of the runs and joints that have one
SURE_AT_MOST = 0.8  # probability of a cause, where part of what the robot was told is guessed


def with_ticks(context: Context) -> Data | None:
    """The data with set-points between the rows, where those take the gap away; None where there is no need for them.

    Logs that say how often set-points came (``rate_hz``, as snakebot's own do) are believed.
    """
    data = context.data
    limit_s = context.shift_limits_s(Hypothesis())
    open_ = [i for i, run in enumerate(data.runs) if run.tick_s is None]
    slowest = max((row_s(data.runs[i]) for i in open_), default=0.0)
    if 0.5 * slowest < PLAIN * float(limit_s.max()):
        return None

    def squares(readings: Sequence[Floats]) -> Floats:
        shift_s = context.shifts_s(readings, context.free_runs, limit_s)
        return context.angle_blocks.mean_square(context.residuals(readings, shift_s))

    held = squares(context.nominal)
    if (held <= GAP * context.scale.square).all():
        return None
    best: tuple[float, Data] | None = None
    for tick_s in TICKS_S:
        if slowest <= SLOWER * tick_s:
            continue
        other = replace(
            data,
            runs=tuple(replace(run, tick_s=tick_s) if run.tick_s is None else run for run in data.runs),
        )
        made = squares([p.reading_rad for p in Simulator(other).predict(())])
        left = float(np.log1p(made / context.scale.square).mean())
        if _closes(context, held, made) and (best is None or left < best[0]):
            best = left, other
    return None if best is None else best[1]


def _closes(context: Context, held: Floats, made: Floats) -> bool:
    """Whether most gaps of a joint in a run, of mean squares ``held`` (B,), are gone from ``made`` (B,)."""
    blocks, allowed = context.angle_blocks, context.scale.square
    gaps = closed = 0
    for run in range(len(context.data.runs)):
        for joint in range(context.data.joints):
            rows = (blocks.run == run) & (blocks.joint == joint)
            if not rows.any() or held[rows].mean() <= GAP * allowed[rows].mean():
                continue
            gaps += 1
            before, after = (max(float((s[rows] - allowed[rows]).mean()), 0.0) for s in (held, made))
            closed += after <= (1 - CLOSED) * before
    return gaps > 0 and closed >= MOST * gaps


def slow_warning(data: Data, guessed: bool) -> str:
    """A line on the slow logs of a session. ``guessed``: no log says so, but the readings do."""
    slow = [run for run in data.runs if is_slow(run)]
    run = max(slow, key=row_s)
    assert run.tick_s is not None
    told = (
        "the readings follow set-points between the rows, or the servos are faster than described"
        if guessed
        else f"set-points came every {1e3 * run.tick_s:.3g} ms"
    )
    which = run.name if len(slow) == 1 else f"{run.name} and {len(slow) - 1} more"
    return (
        f"{which}: a row every {1e3 * row_s(run):.3g} ms, but {told}: a curve is laid through the rows, and no cause "
        "is sure; log a row for every set-point"
    )


def less_sure(causes: Sequence[Cause]) -> list[Cause]:
    """The causes with no probability above ``SURE_AT_MOST``; noise of the encoders is seen without any set-point."""
    return [
        c
        if c.effect == "encoder_noise"
        else c.model_copy(update={"probability": min(c.probability, SURE_AT_MOST)})
        for c in causes
    ]


def less_sure_ranking(ranking: Sequence[RankingEntry]) -> tuple[RankingEntry, ...]:
    """The same of the ranking."""
    return tuple(r.model_copy(update={"probability": min(r.probability, SURE_AT_MOST)}) for r in ranking)
