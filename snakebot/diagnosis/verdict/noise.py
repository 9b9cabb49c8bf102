"""Noisy encoders: the one cause that leaves no mark on the mean, found by how readings scatter from sample to
sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.floor import Floor, white_noise_by_part
from snakebot.diagnosis.sizes import OUTSTANDING
from snakebot.effects.effect import Effect
from snakebot.effects.registry import effects
from snakebot.robust import SIGMAS_95


@dataclass(frozen=True)
class EncoderScatter:
    """Joints (1-based) whose readings scatter more than an encoder's should, and by how much."""

    joints: tuple[int, ...]
    std_deg: float
    ci95: tuple[float, float]

    @property
    def doubts(self) -> dict[int, str]:
        """By joint (0-based), what to say where no noise of the encoders may be named."""
        return {
            joint - 1: f"joint {joint}: readings scatter from sample to sample more than an encoder's should "
            f"({self.std_deg:.2g} deg), and noise of the encoders may not be named"
            for joint in self.joints
        }


def noise_effect() -> Effect:
    """The effect that shows in the scatter of the readings alone."""
    return next(e for e in effects().values() if e.stage == "sensor" and e.shows_in == {"scatter"})


def noisy_encoders(data: Data, floor: Floor) -> EncoderScatter | None:
    """None where the scatter is what one takes for granted. It is not where a joint scatters more than usual, or stands
    out of the median joint; and in either case of its counts.
    """
    white = floor.white_rad
    q, usual_rad = data.quantiser_rad, data.robot.tolerance.scatter_rad
    middle = float(np.median(white))
    loud: list[int] = [
        j
        for j, w in enumerate(white)
        if w > max(usual_rad, OUTSTANDING * q)
        or (white.size >= 3 and w > max(OUTSTANDING * middle, 0.5 * usual_rad, OUTSTANDING * q))
    ]
    if not loud:
        return None
    std = float(np.sqrt(max(float(np.mean(np.square(white[loud]))) - q * q, 0.0)))
    parts = np.array([part for j in loud for part in white_noise_by_part(data, j)])
    # how well it is known, by how much it differs from quarter to quarter of the runs
    apart = float(parts.std(ddof=1) / (parts.mean() * np.sqrt(parts.size))) if parts.size > 1 else 1.0
    relative = min(SIGMAS_95 * apart, 1.0)
    degrees = float(np.degrees(std))
    return EncoderScatter(
        tuple(j + 1 for j in loud), degrees, (degrees * (1 - relative), degrees * (1 + relative))
    )
