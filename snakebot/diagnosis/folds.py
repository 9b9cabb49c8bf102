"""Which runs are fitted and which are only predicted: folds over motions, repeats never split."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snakebot.diagnosis.data import Data

MOST_FOLDS = 5


@dataclass(frozen=True)
class Fold:
    """Indices of the runs that are fitted and of those that are scored."""

    fit: tuple[int, ...]
    score: tuple[int, ...]


def folds(data: Data, most: int = MOST_FOLDS) -> tuple[Fold, ...]:
    """Folds over the motions of the runs that may be fitted; held-out runs are in no fold.

    Motions are dealt out in order of how fast they move, so that every fold has slow and fast ones on both sides.
    With a single motion its two halves in time would be twins, so there is no fold, and the caller must say so.
    """
    free = [i for i, run in enumerate(data.runs) if not run.hold_out]
    motions = sorted({data.runs[i].motion for i in free}, key=lambda m: (_speed(data, m), m))
    count = min(most, len(motions))
    if count < 2:
        return ()
    made = []
    for k in range(count):
        out = set(motions[k::count])
        made.append(
            Fold(
                tuple(i for i in free if data.runs[i].motion not in out),
                tuple(i for i in free if data.runs[i].motion in out),
            )
        )
    return tuple(made)


def _speed(data: Data, motion: int) -> float:
    speeds = [0.0]
    for run in data.runs:
        if run.motion == motion and run.t_s.size > 1:
            steps = np.diff(run.command_rad, axis=0)
            with np.errstate(invalid="ignore"):
                square = np.square(steps[np.isfinite(steps)])
            speeds.append(float(np.sqrt(square.sum() / max(run.t_s[-1], 1e-9))))
    return max(speeds)
