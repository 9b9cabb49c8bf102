"""Set-points lost at random: their mark is not in the mean but in delays that all joints share and that have no memory.

A set-point that is lost leaves every joint behind by its own rate times the same short time. So the residuals are taken
apart into that common delay and the rest: where the common delay explains most of them, and what it was a third of a
second ago says nothing about now, set-points get lost (or come at random times, which a robot feels no differently).
A log that lacks rows, or was stamped unevenly, shakes alike but delays nothing: so the mean must show the loss as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.blocks import mean_difference
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.merit import CLEAR_SE
from snakebot.diagnosis.score import CHANGED
from snakebot.diagnosis.trial import Trial

Floats = NDArray[np.float64]

MEMORY_S = 0.35  # beyond this a lost set-point is forgotten
UNSTEADY = 2.0  # repeats that differ by this many times the readings' own noise differ by chance
LEAST_SHARE = 0.5  # of the residual that the common delay must explain beyond chance
MOST_MEMORY = 0.25  # correlation that may be left after MEMORY_S


@dataclass(frozen=True)
class RandomDelay:
    """Share of the residual's mean square that a common delay explains beyond chance, and its memory (correlation)."""

    share: float
    memory: float
    rms_s: float

    @property
    def evident(self) -> bool:
        return self.share > LEAST_SHARE and abs(self.memory) < MOST_MEMORY


def unsteady(context: Context) -> bool:
    """Whether repeats of a motion differ by more than the noise of their readings."""
    floor = context.floor
    return floor.known and bool(np.nanmax(floor.repeat_rad / floor.white_rad) > UNSTEADY)


def earned(context: Context, loss: Trial, base: Trial) -> bool:
    """Whether lost set-points predict held-out angles clearly better than ``base``, without them, does.

    Neither is helped by a shift in time here: what comes at random is no wire that is a little slower. And a gap need
    not stand above the floor, which repeats that differ by chance have raised. How much they gain does not count:
    most of what they do is scatter.
    """
    blocks = context.angle_blocks
    with_loss, without = (blocks.mean_square(context.residuals(t.readings)) for t in (loss, base))
    allowed, free = context.scale.square, context.selects[: blocks.count]
    rows = free & (np.abs(with_loss - without) > CHANGED * allowed)
    if not rows.any():
        return False
    gain = 0.5 * (np.log1p(without / allowed) - np.log1p(with_loss / allowed))
    return mean_difference(gain[rows], blocks.run[rows]).z > CLEAR_SE


def random_delay(context: Context, trial: Trial) -> RandomDelay:
    """Look for a common random delay in what ``trial`` leaves over. Needs two joints at least."""
    k = context.data.joints
    if k < 2:
        return RandomDelay(0.0, 1.0, 0.0)
    explained = total = weight = 0.0
    lagged, power, square = 0.0, 0.0, 0.0
    for run, reading, left in zip(context.data.runs, trial.readings, trial.left, strict=True):
        use = np.asarray(run.use.all(axis=1))
        if use.sum() < 50:
            continue
        rate: Floats = np.asarray(np.gradient(reading, run.t_s, axis=0))
        residual = np.where(use[:, None], left, 0.0)
        noise = float(np.square(context.floor.white_rad).sum())
        speed: Floats = np.asarray(np.square(rate).sum(axis=1))
        moving = use & (speed > 0.1 * np.quantile(speed[use], 0.9))
        delay = np.where(moving, -(residual * rate).sum(axis=1) / np.maximum(speed, 1e-12), 0.0)
        explained += float((np.square(delay) * speed)[moving].sum())
        total += float(np.square(residual)[moving].sum())
        weight += float(moving.sum()) * noise
        delay = np.where(moving, delay - delay[moving].mean(), 0.0)
        step = max(1, round(MEMORY_S / run.period_s))
        if delay.size > 2 * step:
            lagged += float((delay[step:] * delay[:-step]).sum())
            power += float(np.square(delay[step:]).sum())
        square += float(np.square(delay[moving]).mean())
    if total <= 2 * weight or power <= 0:  # nothing but the readings' own noise
        return RandomDelay(0.0, 1.0, 0.0)
    share = (explained / total - 1 / k) / (1 - 1 / k)
    return RandomDelay(float(share), lagged / power, float(np.sqrt(square / len(context.data.runs))))
