"""Which runs are fitted and which are only predicted: folds over motions, repeats never split."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snakebot.diagnosis.evidence.data import Data

MOST_FOLDS = 5  # folds of a session; chosen


@dataclass(frozen=True)
class Fold:
    """Indices of the runs that are fitted and of those that are scored."""

    fit: tuple[int, ...]
    score: tuple[int, ...]


@dataclass(frozen=True)
class Split:
    """Which runs (indices) are fitted, and on which closure is taken.

    Attributes:
        free: runs that may be fitted.
        held_out: runs that the user holds out.
        folds: over the motions of the free runs; none where only one motion may be fitted.
    """

    free: tuple[int, ...]
    held_out: tuple[int, ...]
    folds: tuple[Fold, ...]

    @property
    def shown(self) -> tuple[int, ...]:
        """Runs on which before and after are told: those that the user holds out, else all."""
        return self.held_out or self.free

    @property
    def scored(self) -> tuple[int, ...]:
        """Runs that closure is taken on: those shown that no parameter was fitted to, each predicted from the others.

        None where only one motion may be fitted: what is left of it was fitted too.
        """
        return self.shown if self.held_out or self.folds else ()


def split_of(data: Data) -> Split:
    """Free runs, held-out runs and folds of a session."""
    held = tuple(i for i, run in enumerate(data.runs) if run.hold_out)
    free = tuple(i for i, run in enumerate(data.runs) if not run.hold_out)
    return Split(free, held, folds(data))


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
