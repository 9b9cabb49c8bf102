"""How well the joints follow: the tracking error (37), and the error's hysteresis against velocity."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats


@dataclass(frozen=True)
class Tracking:
    """Error of one joint, measured minus reference, over the samples where both are known.

    ``te`` is dimensionless (37); ``nan`` where there is no amplitude to divide by or no sample.
    """

    te: float
    rms_rad: float
    max_rad: float
    mean_rad: float
    samples: int


def tracking(measured_rad: Floats, reference_rad: Floats, amplitude_rad: float) -> Tracking:
    """Errors of one joint (N,) against its reference (N,); ``nan`` samples are left out.

    ``te = sqrt(sum (measured - reference)^2 / N) / amplitude`` (37).
    """
    error = measured_rad - reference_rad
    error = error[np.isfinite(error)]
    if len(error) == 0:
        return Tracking(math.nan, math.nan, math.nan, math.nan, 0)
    rms = float(np.sqrt(np.mean(error**2)))
    return Tracking(
        te=rms / amplitude_rad if amplitude_rad > 0 else math.nan,
        rms_rad=rms,
        max_rad=float(np.max(np.abs(error))),
        mean_rad=float(np.mean(error)),
        samples=len(error),
    )


@dataclass(frozen=True)
class Hysteresis:
    """Error against the velocity of the command, taken apart.

    ``error = constant - lag_s * velocity - half_width_rad * sign(velocity)``: a pure lag puts the error on
    a line through the origin, play or a dead band makes it jump by twice ``half_width_rad`` where the
    motion turns round. ``loop`` is the signed area that error and velocity enclose over the run, over the
    area of the ellipse with the same rms values: 0 on a line, +-1 where the error is a quarter of a cycle
    away from the velocity (an error of gain).
    """

    half_width_rad: float
    lag_s: float
    constant_rad: float
    loop: float
    explained: (
        float  # share of the error's variance that these three terms explain; below half they mean little
    )
    samples: int


UNKNOWN_HYSTERESIS = Hysteresis(math.nan, math.nan, math.nan, math.nan, math.nan, 0)


def hysteresis(
    t_s: Floats, measured_rad: Floats, command_rad: Floats, cycles: float = math.nan
) -> Hysteresis:
    """Fit the error of one joint against the velocity of its command; all arrays are (N,).

    ``cycles`` is how many cycles of a periodic motion the samples span; without it there is no ``loop``.

    Only the faster half of the motion is used: near a turning point play is being taken up, and the error
    there belongs to neither direction. All ``nan`` where the speed never varies (a triangle wave): lag and
    play are then one number.
    """
    velocity = rate(t_s, command_rad)
    error = measured_rad - command_rad
    known = np.isfinite(error) & np.isfinite(velocity)
    if known.sum() < 8:
        return UNKNOWN_HYSTERESIS
    # The 99th percentile, not the maximum: a command with steps has rates of any size.
    fastest = float(np.percentile(np.abs(velocity[known]), 99))
    moving = known & (np.abs(velocity) > 0.5 * fastest) & (np.abs(velocity) <= 1.5 * fastest)
    if fastest <= 0 or moving.sum() < 8:
        return UNKNOWN_HYSTERESIS
    v, e = velocity[moving], error[moving]
    design = np.stack([np.ones_like(v), -v, -np.sign(v)], axis=1)
    coefficients, _, rank, _ = np.linalg.lstsq(design, e, rcond=1e-9)
    if rank < 3 or float(np.std(np.abs(v))) < 0.05 * fastest:
        return UNKNOWN_HYSTERESIS
    constant, lag, half_width = (float(c) for c in coefficients)
    loop = _loop(velocity[known], error[known], cycles)
    left, total = float(np.var(e - design @ coefficients)), float(np.var(e))
    explained = 1 - left / total if total > 0 else math.nan
    return Hysteresis(half_width, lag, constant, loop, explained, int(moving.sum()))


def rate(t_s: Floats, angle_rad: Floats) -> Floats:
    """Central differences on irregular times, (N,); ``nan`` beside a lost sample."""
    out = np.full_like(angle_rad, np.nan, dtype=np.float64)
    if len(t_s) < 3:
        return out
    before, after = t_s[1:-1] - t_s[:-2], t_s[2:] - t_s[1:-1]
    slope_before = (angle_rad[1:-1] - angle_rad[:-2]) / before
    slope_after = (angle_rad[2:] - angle_rad[1:-1]) / after
    out[1:-1] = (slope_before * after + slope_after * before) / (before + after)
    return out


def _loop(velocity: Floats, error: Floats, cycles: float) -> float:
    error = error - error.mean()
    ellipse = 2 * math.pi * float(np.std(velocity) * np.std(error))  # pi E V, in terms of the two rms values
    if not (cycles > 0 and ellipse > 0):
        return math.nan
    area = 0.5 * float(np.sum(velocity * np.roll(error, -1) - np.roll(velocity, -1) * error))
    return area / (ellipse * cycles)
