"""Set-points that never arrive."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.effects.effect import Effect, Track
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    from snakebot.effects.effect import Vector
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


@dataclass(frozen=True)
class Loss:
    """A link filter that drops set-points; a batch gives mean and variance of the one that is then in force."""

    probability: float

    def online(
        self, t_s: float, setpoint_rad: Vector, rng: np.random.Generator
    ) -> tuple[float, Vector] | None:
        return None if rng.random() < self.probability else (t_s, setpoint_rad)

    def batch(self, track: Track) -> Track:
        p = self.probability
        mean = track.setpoint_rad.copy()
        square = mean**2 if track.variance_rad2 is None else mean**2 + track.variance_rad2
        for before, now in itertools.pairwise(range(len(mean))):
            known = np.isfinite(mean[before]) & np.isfinite(
                mean[now]
            )  # switched off and on again: no mixture
            mean[now] += np.where(known, p * (mean[before] - mean[now]), 0.0)
            square[now] += np.where(known, p * (square[before] - square[now]), 0.0)
        return Track(track.time_s, mean, np.maximum(square - mean**2, 0.0))


class CommandLoss(Effect):
    name = "command_loss"
    stage = "link"
    summary = "Some set-points are lost at random; the one before stays in force."
    mark = (
        "Flat treads in the joints' motion that begin on a tick and end with a catch-up, at "
        "random, on all joints at once; in the mean a delay of p / (1 - p) ticks."
    )
    confused_with = (
        (
            "command_delay",
            "the mean looks like a short delay; scatter between repeats, or the applied set-point, tells",
        ),
    )
    per_joint = False
    parameters = (Parameter("probability", "", 0.0, 0.95, "of losing a set-point", typical=0.1, spread=0.15),)

    def link_filter(self, spec: EffectSpec, robot: Robot) -> Loss:
        return Loss(spec.value("probability"))


EFFECT = CommandLoss()
