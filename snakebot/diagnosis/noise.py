"""Noisy encoders: the one cause that leaves no mark on the mean, found by how readings scatter from sample to
sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snakebot.diagnosis.context import Context

PLAIN_NOISE_RAD = np.radians(0.2)  # scatter that is taken for granted beside the encoder's counts
OUTSTANDING = 4.0  # a joint this many times noisier than the middle one stands out


@dataclass(frozen=True)
class Noise:
    """Joints (1-based) whose readings scatter more than an encoder's should, and by how much."""

    joints: tuple[int, ...]
    std_deg: float
    ci95: tuple[float, float]


def noisy_encoders(context: Context) -> Noise | None:
    """None where the scatter is what one takes for granted."""
    white = context.floor.white_rad
    q = context.data.quantiser_rad
    middle = float(np.median(white))
    loud: list[int] = [
        j
        for j, w in enumerate(white)
        if w > max(PLAIN_NOISE_RAD, 4 * q)
        or (white.size >= 3 and w > max(OUTSTANDING * middle, 0.5 * PLAIN_NOISE_RAD, 4 * q))
    ]
    if not loud:
        return None
    std = float(np.sqrt(max(float(np.mean(np.square(white[loud]))) - q * q, 0.0)))
    samples = sum(int(run.use[:, j].sum()) for run in context.data.runs for j in loud)
    # third differences share their noise, and the estimate itself is rough
    relative = float(1.96 * np.sqrt(2.5 / max(samples, 1)) + 0.02)
    degrees = float(np.degrees(std))
    return Noise(tuple(j + 1 for j in loud), degrees, (degrees * (1 - relative), degrees * (1 + relative)))
