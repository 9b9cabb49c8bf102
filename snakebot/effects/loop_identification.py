"""Position loops read off a motion: the equation of motion of a joint is linear in their numbers.

With weight(t) = gravity sin(q - down) of what hangs on the joint, a loop obeys

    weight + inertia q'' = stiffness clip(error, limit) - damping q' - armature q''
                           - (coulomb + load_friction |weight|) sign(q')

so that for a given limit all its numbers follow at once, by least squares (Gautier and Khalil, "Direct calculation of
minimum set of inertial parameters of serial robots", 1990), none of them below zero. Differentiated readings are noisy,
and lags are left out: good enough to begin a fit with.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from snakebot.arrays import Floats
from snakebot.effects.observed import Observed, RunLike
from snakebot.effects.stages import filled
from snakebot.smoothing import smoothed

# Shares of the furthest error seen, at one of which the drive may give all it has; chosen: each .5 to .8 of the last.
LIMITED = (0.8, 0.6, 0.4, 0.3, 0.2, 0.15, 0.1, 0.05)
TURNING = 0.05  # share of the peak rate, over which dry friction turns with the motion; chosen


class Carried(NamedTuple):
    """What a joint carries: torque when it is level, angle at which it hangs, and inertia at the joint."""

    gravity_nm: float
    down_rad: float
    inertia_kg_m2: float


class Loop(NamedTuple):
    """A position loop that gives no more torque than at an error of ``limit_rad``."""

    stiffness_nm_rad: float
    damping_nm_s_rad: float
    armature_kg_m2: float
    coulomb_nm: float
    load_friction: float
    limit_rad: float


def loops(observed: Observed, joints: tuple[int, ...], carried: Carried) -> list[Loop]:
    """Loops of these joints (0-based) under power, one for each limit, best first; those that hold nothing left out."""
    from scipy.optimize import nnls

    parts = [
        _terms(observed, run, joint, carried) for run in observed.runs if len(run.t_s) > 2 for joint in joints
    ]
    if not parts:
        return []
    error, terms, pull = (np.concatenate(part) for part in zip(*parts, strict=True))
    if error.size <= terms.shape[1] + 1:
        return []
    furthest = observed.over(observed.furthest_error_rad, joints, 1.0)
    found = []
    for share in LIMITED:
        limit = share * furthest
        columns = np.column_stack([np.clip(error, -limit, limit), terms])
        size = np.maximum(np.sqrt(np.mean(np.square(columns), axis=0)), 1e-12)
        numbers, left = nnls(columns / size, pull)
        if numbers[0] > 0:
            stiffness, damping, armature, coulomb, load = (numbers / size).tolist()
            found.append((float(left), Loop(stiffness, damping, armature, coulomb, load, limit)))
    return [loop for _, loop in sorted(found)]


def _terms(observed: Observed, run: RunLike, joint: int, carried: Carried) -> tuple[Floats, Floats, Floats]:
    """Of the samples under power: errors (N,), what the other numbers but the stiffness are factors of (N, 4), and what
    the loop pulls (N,).
    """
    angle = smoothed(run.t_s, filled(run.measured_rad[:, [joint]]))[:, 0]
    rate = np.gradient(angle, run.t_s)
    acceleration = np.gradient(rate, run.t_s)
    error = run.command_rad[:, joint] - run.measured_rad[:, joint]
    weight = carried.gravity_nm * np.sin(angle - carried.down_rad)
    turning = np.tanh(rate / max(TURNING * float(observed.peak_rate_rad_s[joint]), 1e-6))
    terms = -np.column_stack([rate, acceleration, turning, np.abs(weight) * turning])
    pull = weight + carried.inertia_kg_m2 * acceleration
    use = np.isfinite(error)
    return error[use], terms[use], pull[use]
