"""Noisy encoders."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.effect import Effect, on_joints
from snakebot.effects.parameter import Parameter

if TYPE_CHECKING:
    from snakebot.effects.effect import Start
    from snakebot.effects.observed import Observed
    from snakebot.effects.spec import EffectSpec
    from snakebot.robot import Robot


class Noise:
    """A sensor filter with scatter (joints,) and a random walk of single counts at a rate of lost ones (joints,)."""

    def __init__(self, std_rad: Floats, lost_per_s: Floats, count_rad: float) -> None:
        self._std, self._lost, self._count = std_rad, lost_per_s, count_rad
        self._walk = np.zeros(std_rad.size)
        self._last_s: float | None = None

    def online(self, t_s: float, angle_rad: Floats, rng: np.random.Generator) -> Floats:
        expected = self._lost * max(0.0, t_s - (t_s if self._last_s is None else self._last_s))
        self._last_s = t_s
        self._walk += self._count * (rng.poisson(expected / 2) - rng.poisson(expected / 2))
        return angle_rad + self._walk + self._std * rng.standard_normal(self._std.size)

    def batch(self, t_s: Floats, angle_rad: Floats) -> Floats:
        return angle_rad

    def variance_rad2(self, t_s: Floats) -> Floats:
        variance: Floats = self._std**2 + (t_s - t_s[0])[:, None] * self._lost * self._count**2
        return variance


class EncoderNoise(Effect):
    name = "encoder_noise"
    example = "encoder_noise:std_deg=0.3"
    stage = "sensor"
    summary = "Readings scatter, and counts may get lost permanently."
    title = "noisy encoders"
    sentence = "The readings of {on} scatter by {std_deg}"
    look = "Look at the encoder's cable, shield and magnet distance; read a joint at rest for some seconds."
    mark = (
        "Differences between repeated runs that have no memory (scatter) or add up through the "
        "run (lost counts)."
    )
    shows_in = frozenset({"scatter"})
    parameters = (
        Parameter(
            "std_deg",
            "deg",
            0.0,
            30.0,
            "scatter of each reading",
            typical=0.3,
            spread=0.5,
            words="scatter",
            in_mjcf="numeric encoder_noise_rad, entry {j}, in rad",
        ),
        Parameter(
            "lost_per_s",
            "1/s",
            0.0,
            1e5,
            "counts lost or gained a second, at random",
            1.0,
            10.0,
            default=0.0,
            fitted=False,
            words="counts lost or gained each second",
        ),
    )

    def sensor_filter(self, spec: EffectSpec, robot: Robot) -> Noise:
        joints = spec.joint_indices(robot.joints)
        return Noise(
            on_joints(math.radians(spec.value("std_deg")), joints, robot.joints, 0.0),
            on_joints(spec.value("lost_per_s"), joints, robot.joints, 0.0),
            robot.rad_per_count,
        )

    def starts(self, observed: Observed, joints: tuple[int, ...]) -> list[Start]:
        noise = math.degrees(observed.over(observed.scatter_rad, joints, 0.01))
        return [{"std_deg": self.parameters[0].clip(max(noise, 0.01))}]


EFFECT = EncoderNoise()
