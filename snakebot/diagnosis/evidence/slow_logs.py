"""Logs that are slower than the set-points came, told by the gap that they make.

A log of every fifth set-point, taken as held, says that the robot was told everything two ticks later than it was: a
sound robot then runs ahead of its prediction. A curve through the rows, cut into ticks, takes that gap away.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.gap import CERTAIN_RATIO
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.diagnosis.evidence.ticks import is_slow, row_s
from snakebot.diagnosis.evidence.tolerance import ShiftLimits
from snakebot.diagnosis.sizes import CLEAR, HALF, LITTLE, MUCH


def with_ticks(evidence: Evidence) -> Data | None:
    """The data with set-points between the rows, where those take the gap away; None where there is no need for them.

    Logs that say how often set-points came (``rate_hz``, as snakebot's own do) are believed.
    """
    data, angles = evidence.data, evidence.angles
    limits = ShiftLimits.of(data.robot)
    known_s = (
        data.robot.lag_spread_s + data.robot.tolerance.delay_s
    )  # to which the simulation knows when a joint moves
    open_ = [i for i, run in enumerate(data.runs) if run.tick_s is None]
    slowest = max((row_s(data.runs[i]) for i in open_), default=0.0)
    if 0.5 * slowest < CLEAR * known_s:
        return None

    def squares(readings: Sequence[Floats]) -> Floats:
        shift_s = angles.shifts_s(readings, evidence.split.free, limits)
        return angles.blocks.mean_square(angles.residuals(readings, shift_s))

    held = squares(evidence.predictor.nominal)
    if (held <= CERTAIN_RATIO * angles.allowed_square).all():
        return None
    best: tuple[float, Data] | None = None
    for ticks in range(2, round(1 / LITTLE) + 1):
        other = replace(
            data,
            runs=tuple(
                replace(run, tick_s=slowest / ticks) if run.tick_s is None else run for run in data.runs
            ),
        )
        made = squares([p.reading_rad for p in Simulator(other).predict(())])
        left = float(np.log1p(made / angles.allowed_square).mean())
        if _closes(angles, held, made) and (best is None or left < best[0]):
            best = left, other
    return None if best is None else best[1]


def _closes(angles: AngleEvidence, held: Floats, made: Floats) -> bool:
    """Whether most gaps of a joint in a run, of mean squares ``held`` (B,), are gone from ``made`` (B,)."""
    blocks, allowed = angles.blocks, angles.allowed_square
    gaps = closed = 0
    for run in range(len(angles.data.runs)):
        for joint in range(angles.data.joints):
            rows = (blocks.run == run) & (blocks.joint == joint)
            if not rows.any() or held[rows].mean() <= CERTAIN_RATIO * allowed[rows].mean():
                continue
            gaps += 1
            before, after = (max(float((s[rows] - allowed[rows]).mean()), 0.0) for s in (held, made))
            closed += after <= MUCH * before
    return gaps > 0 and closed >= HALF * gaps


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
