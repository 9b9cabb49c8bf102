"""What the nominal model makes of a run: ideal tracking, the sines the joints really made, the angles they
really made.

Fig. 21 sets measured speed against the ideal prediction. Where the servos no longer follow, the paper
repeats the simulation with the least-squares sines of the measured angles: what is left then is not the
servos' doing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from snakebot.analysis.sine import SineFit
from snakebot.arrays import Floats

if TYPE_CHECKING:
    from snakebot.gait import Gait
    from snakebot.physics.model import ChainModel

CYCLES, AVERAGED_CYCLES, STEPS_PER_CYCLE = 8, 4, 200  # "8 cycles, average the last 4"


@dataclass(frozen=True)
class SteadyPrediction:
    """Steady speed along the mean heading and mean powers of one simulated motion."""

    speed_m_s: float
    power_in_w: float
    power_dissipated_w: float


def predict_gait(
    model: ChainModel,
    gait: Gait,
    free_joints: Iterable[int] = (),
    rigid_angle_rad: Mapping[int, float] | None = None,
) -> SteadyPrediction:
    """The gait tracked ideally, from rest, by the paper's protocol; with joints that are free or stuck
    straight."""
    from snakebot.physics import simulate_gaits

    row = [[gait.alpha_rad, gait.beta_rad, gait.omega_rad_s, gait.offset_rad]]
    found = simulate_gaits(
        model,
        row,
        free_joints=tuple(free_joints),
        rigid_joints=rigid_angle_rad or {},
        shares=gait.shares,
    )
    return SteadyPrediction(
        float(found.speed_m_s[0]), float(found.power_in_w[0]), float(found.power_dissipated_w[0])
    )


def predict_fits(model: ChainModel, fits: Sequence[SineFit]) -> SteadyPrediction:
    """Joints that move as fitted (one fit a joint, all at one frequency), from rest, by the same protocol."""
    from snakebot.physics import replay

    omega = fits[0].omega_rad_s
    period = 2 * math.pi / omega
    t = np.linspace(0, CYCLES * period, CYCLES * STEPS_PER_CYCLE + 1)
    s = np.clip(t / period, 0, 1)
    ramp = s**3 * (10 + s * (6 * s - 15))  # amplitude comes in over the first cycle, without a jerk
    angle = ramp[:, None] * np.stack([fit.evaluate(t) for fit in fits], axis=1)
    moved = replay(model, t, angle)
    start = (CYCLES - AVERAGED_CYCLES) * period
    steady = t >= start - 1e-9
    return SteadyPrediction(
        moved.forward_speed_m_s(start - 1e-9),
        float(np.mean(moved.power_in_w[steady][1:])),
        float(np.mean(moved.power_dissipated_w[steady][1:])),
    )


def predict_angles(
    model: ChainModel, t_s: Floats, joint_angle_rad: Floats, start_s: float, end_s: float
) -> float:
    """Speed in m/s over a window, of a body whose joints go through these angles (N, joints), gaps filled;
    ``nan`` if it cannot be told."""
    from snakebot.physics import replay

    filled = fill_gaps(t_s, joint_angle_rad)
    if filled is None:
        return math.nan
    return replay(model, t_s, filled).forward_speed_m_s(start_s - 1e-9, end_s + 1e-9)


def fill_gaps(t_s: Floats, angle_rad: Floats, most: float = 0.5) -> Floats | None:
    """Angles (N, k) with lost samples interpolated; ``None`` where a joint lost more than this share of
    them."""
    known = np.isfinite(angle_rad)
    if len(t_s) < 3 or (known.mean(axis=0) < 1 - most).any():
        return None
    columns = [
        np.interp(t_s, t_s[good], column[good]) for column, good in zip(angle_rad.T, known.T, strict=True)
    ]
    return np.stack(columns, axis=1)
