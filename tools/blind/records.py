"""What a lab records of its robot: how many motions, for how long, and what of the way that it goes.

Half of the labs do as those of the first sets did; of the others each does as it likes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blind.robot import Recording

AS_FIRST = 0.5  # share of the labs
MOTIONS_FROM_TO = (3, 8)  # beside the repeat of the first one
DURATIONS_S = (6.0, 20.0)  # of a run, whole seconds
SPEED_ALONE = 0.2  # share of those others with a treadmill's speed in place of a pose
SPEED_NOISE = 0.005  # of a treadmill: relative
SPEED_NOISE_M_S = 0.001  # ... and beside that


@dataclass(frozen=True)
class Records:
    """``pose``: of the centre of mass, at every tick; else one forward speed a run."""

    motions: int = 5
    duration_s: float = 10.0
    pose: bool = True


def records_of(seed: int, number: int) -> Records:
    """What is recorded of the n-th robot of a seed. Drawn apart: what is recorded changes no robot."""
    rng = np.random.default_rng([seed, number, 1])
    if rng.random() < AS_FIRST:
        return Records()
    motions = int(rng.integers(MOTIONS_FROM_TO[0], MOTIONS_FROM_TO[1] + 1))
    duration_s = float(rng.integers(int(DURATIONS_S[0]), int(DURATIONS_S[1]) + 1))
    return Records(motions, duration_s, pose=bool(rng.random() >= SPEED_ALONE))


def forward_speed(run: Recording, rng: np.random.Generator) -> float:
    """m/s along the way, as a treadmill tells it."""
    return speed_along(run) * (1 + SPEED_NOISE * float(rng.normal())) + SPEED_NOISE_M_S * float(rng.normal())


def speed_along(run: Recording) -> float:
    """m/s of the second half of a run, the way that the robot faces there."""
    t, (x, y, heading) = run.t_s[run.t_s.size // 2 :], run.pose[run.t_s.size // 2 :].T
    ahead = np.array([np.cos(heading.mean()), np.sin(heading.mean())])
    return float(ahead @ [x[-1] - x[0], y[-1] - y[0]] / (t[-1] - t[0]))
