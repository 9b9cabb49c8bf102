"""Which effects this data cannot tell apart: the winner is simulated at its fit, and the rivals are fitted to that.

If a rival then comes as close as the noise allows, no search over this data could have preferred one to the
other on good grounds, whichever happened to win. The same holds where both leave nothing beyond noise and tolerance,
and one leads by little. Nothing is wired in: the ties of one session are not those of another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from snakebot.diagnosis.context import Context
from snakebot.diagnosis.data import Data
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.hypothesis import bounds
from snakebot.diagnosis.merit import CLEAR_SE, lead, touched
from snakebot.diagnosis.side_by_side import side_by_side
from snakebot.diagnosis.simulate import Simulator
from snakebot.diagnosis.trial import Trial, run_trial

ALIKE = 0.02  # a lead in score under this (4 % of the mean square) is no ground to prefer
AT_THE_FLOOR = 0.15  # ... nor is one under this, where both leave nothing that counts: robots differ by more
TOO_FAR = 0.5  # a rival that trails this much on the data itself is not refitted to the simulated ones


def indistinguishable(context: Context, best: Trial, rivals: Sequence[Trial]) -> list[Trial]:
    """Those of ``rivals`` that this data cannot tell from ``best``."""
    near = [r for r in rivals if _trails(context, best, r) < TOO_FAR and not degenerate(best, r)]
    if not near:
        return []
    ahead = [r for r in near if _leads(context, best, r)]
    clear: set[Trial] = set()
    if ahead:
        ideal = _as_if(context, best)
        told, *refits = side_by_side(
            lambda t: run_trial(ideal, t.hypothesis, [t.theta], cross=False), [best, *ahead]
        )
        clear = {r for r, refit in zip(ahead, refits, strict=True) if _apart(ideal, told, refit) >= ALIKE}
    return [r for r in near if r not in clear]


def _leads(context: Context, best: Trial, rival: Trial) -> bool:
    """Whether ``best`` is clearly ahead on the data itself."""
    seen = lead(context, best, rival)
    enough = AT_THE_FLOOR if not gap_of(context, rival).any else ALIKE
    return seen.z >= CLEAR_SE and seen.mean >= enough


def _apart(ideal: Context, told: Trial, refit: Trial) -> float:
    """The lead of the truth over a rival fitted to what it made."""
    rows = touched(ideal, told, refit)
    return ideal.gain(told.fitted_square, refit.fitted_square, rows).mean if rows.any() else 0.0


def degenerate(best: Trial, rival: Trial) -> bool:
    """Whether a rival with more parameters has shrunk to the simpler ``best``: one of them stands at its bound."""
    if rival.theta.size <= best.theta.size:
        return False
    lower, upper, log = bounds(rival.hypothesis.parameters)
    near = 0.01 * np.where(log, rival.theta, upper - lower)
    at_bound = (rival.theta - lower < 0.1 * near) | (log & (upper - rival.theta < near))
    return bool(at_bound.any())


def _trails(context: Context, best: Trial, rival: Trial) -> float:
    return lead(context, best, rival).mean


def _as_if(context: Context, best: Trial) -> Context:
    """The context in which ``best`` is the truth: its readings and a draw of the noise, on the same samples.

    What the best explanation leaves over is noise as well: two effects that differ by less than the rest are
    not told apart.
    """
    rng = np.random.default_rng(context.seed)
    predicted = context.simulator.predict(best.specs)
    blocks = context.angle_blocks
    left = np.sqrt(
        [
            float(np.median(best.held_square[: blocks.count][blocks.joint == joint]))
            if np.any(blocks.joint == joint)
            else 0.0
            for joint in range(context.data.joints)
        ]
    )
    runs = []
    for run, made in zip(context.data.runs, predicted, strict=True):
        noise = rng.normal(size=run.measured_rad.shape) * left
        measured = np.where(np.isfinite(run.measured_rad), made.reading_rad + noise, np.nan)
        runs.append(replace(run, measured_rad=measured))
    data = Data(context.data.robot, tuple(runs), 0)
    ground = context.ground
    if ground is not None:
        features = context.ground_features(best.specs)
        spread = np.sqrt(np.minimum(ground.floor_square, context.ground_allowed_square))
        ground = replace(
            ground,
            value=np.where(np.isfinite(features), features, ground.value)
            + rng.normal(size=spread.size) * spread,
        )
    return replace(
        context, data=data, simulator=Simulator(data), ground=ground, least_square=None, _ground_cache={}
    )
