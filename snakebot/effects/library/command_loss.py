"""Set-points that never arrive."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect, Track
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


@dataclass(frozen=True)
class Loss:
    """A link filter that drops set-points; a batch gives mean and variance of the one that is then in force."""

    probability: float

    def online(
        self, t_s: float, setpoint_rad: Floats, rng: np.random.Generator
    ) -> tuple[float, Floats] | None:
        return None if rng.random() < self.probability else (t_s, setpoint_rad)

    def batch(self, track: Track) -> Track:
        square = track.setpoint_rad**2
        if track.variance_rad2 is not None:
            square += track.variance_rad2
        mean, square = self._held(track.setpoint_rad), self._held(square)
        return replace(track, setpoint_rad=mean, variance_rad2=np.maximum(square - mean**2, 0.0))

    def _held(self, table: Floats) -> Floats:
        """Mean of what is held: each row with 1 - p, what was held before with p; a servo that is off holds nothing."""
        from scipy.signal import lfilter

        p = self.probability

        def held(part: Floats) -> Floats:
            kept: Floats = lfilter([1.0 - p], [1.0, -p], part, axis=0, zi=p * part[:1])[0]
            return kept

        if not np.isnan(table).any():
            return held(table)
        out = table.copy()
        for column in out.T:
            edges = np.flatnonzero(np.diff(np.isnan(column))) + 1
            for part in np.split(column, edges):
                part[:] = held(part)
        return out


class CommandLoss(Effect):
    name = "command_loss"
    example = "command_loss:probability=0.1"
    stage = "link"
    covers = frozenset({"delay"})
    summary = "Some set-points are lost at random; the one before stays in force."
    title = "lost set-points"
    sentence = "{probability} of the set-points are lost on their way to the robot"
    look = "Look at cable, plugs and termination of the link, and at the error counters of `snakebot doctor`."
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
    shows_in = frozenset({"mean", "scatter"})
    parameters = (
        Parameter(
            "probability",
            "",
            0.0,
            0.95,
            "of losing a set-point",
            typical=0.1,
            spread=0.15,
            words="share that is lost",
            shown=("%", 100.0),
        ),
    )

    def link_filter(self, spec: EffectSpec, robot: Robot) -> Loss:
        return Loss(spec.value("probability"))

    def outside_mjcf(self, spec: EffectSpec) -> str:
        return f"leave out a set-point with probability {spec.value('probability'):g} in your own loop"


EFFECT = CommandLoss()
