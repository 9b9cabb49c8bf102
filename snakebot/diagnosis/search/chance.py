"""What comes by chance does not come again: the scatter that lost set-points make has to show between repeats."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.data import PreparedRun
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.sizes import CLEAR
from snakebot.effects.prediction import predict
from snakebot.effects.spec import EffectSpec
from snakebot.robot import Robot


def too_random(evidence: Evidence, trial: Trial) -> bool:
    """Whether repeats of a motion would differ by clearly more than they do, if what an explanation says of the way to
    the servos came by chance. Where nothing is repeated, nothing is known of that.
    """
    by_chance = [s for s in trial.specs if s.effect.stage == "link" and "scatter" in s.effect.shows_in]
    known = np.isfinite(evidence.floor.repeat_rad)
    count = Counter(run.motion for run in evidence.data.runs)
    repeated = [run for run in evidence.data.runs if count[run.motion] > 1]
    if not by_chance or not repeated or not known.any():
        return False
    robot, floor_rad = evidence.data.robot, evidence.floor.rad
    square = np.mean([_scatter_square(robot, by_chance, run) for run in repeated], axis=0)
    return bool(square[known].sum() > CLEAR**2 * np.square(floor_rad[known]).sum())


def _scatter_square(robot: Robot, specs: Sequence[EffectSpec], run: PreparedRun) -> Floats:
    """(k,) mean square of what a run differs by from its mean: half of that of two runs with draws of their own.

    Zero for a joint that the run does not tell of.
    """
    draws = np.random.default_rng(0).spawn(2)
    one, other = (
        predict(
            robot, (), run.t_s, run.command_rad,
            measured_rad=run.measured_rad, applied_rad=_arriving(robot, specs, run, rng),
            load_nm=np.zeros_like(run.command_rad), body=False, quantise=False,
        ).encoder_rad
        for rng in draws
    )  # fmt: skip
    apart = one - other
    use = run.use & np.isfinite(apart)
    return np.asarray(0.5 * np.square(np.where(use, apart, 0.0)).sum(axis=0) / np.maximum(use.sum(axis=0), 1))


def _arriving(
    robot: Robot, specs: Sequence[EffectSpec], run: PreparedRun, rng: np.random.Generator
) -> Floats:
    """(N, k) set-points in force: the last of those that came through."""
    filters = [spec.effect.link_filter(spec, robot) for spec in specs]
    applied = run.command_rad.copy()
    for row in range(1, len(applied)):
        comes = all(
            f is None or f.online(float(run.t_s[row]), applied[row], rng) is not None for f in filters
        )
        if not comes:
            applied[row] = applied[row - 1]
    return applied
