"""What no lagging, rubbing chain explains of a healthy robot: the best of that family is fitted to a run of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from blind_wheels.body import Floats
from blind_wheels.cases import drawn_motions, rms, ticks
from blind_wheels.described import foretold
from blind_wheels.lab import Description, measured
from blind_wheels.robot import healthy_robot

FIRST_SEED = 800_000_000  # of robots that no set holds
SECONDS = 6.0


@dataclass(frozen=True)
class Side:
    """RMS of the noise (rad or m); with the lab's numbers, and with the best ones: over the noise."""

    noise: float
    measured: float
    best: float


@dataclass(frozen=True)
class Misfit:
    links: int
    angles: Side
    path: Side


def misfit_of(seed: int, number: int) -> Misfit:
    rng = np.random.default_rng([FIRST_SEED + seed, number])
    robot = healthy_robot(rng)
    about = measured(robot, rng)
    motion = drawn_motions(rng, robot.joint_count)[0]
    t = ticks(robot, SECONDS)
    command = motion.command(t, robot.joint_count)
    first, second = (robot.run(t, command, rng) for _ in range(2))
    angle, pose = foretold(about, t, command)
    fitted = np.column_stack(
        [_joint(t, command[:, j], first.encoder_rad[:, j], about.lag_s) for j in range(robot.joint_count)]
    )
    is_m = first.pose[:, :2]
    ground = _ground(about, t, command, is_m)

    def side(one: Floats, other: Floats, as_measured: Floats, best: Floats) -> Side:
        noise = rms(one - other) / 2**0.5
        return Side(noise, rms(as_measured - one) / noise, rms(best - one) / noise)

    return Misfit(
        robot.body.links,
        side(first.encoder_rad, second.encoder_rad, angle, fitted),
        side(is_m, second.pose[:, :2], pose[:, :2], ground),
    )


def lagged(t_s: Floats, command_rad: Floats, lag_s: float, delay_s: float) -> Floats:
    """(T,) after a delay and a first-order lag; a command holds until the next one comes."""
    out, q = np.zeros_like(command_rad), 0.0
    before = 0.0
    for i in range(1, t_s.size):
        step = t_s[i] - t_s[i - 1]
        late = min(delay_s, step)
        q = before + (q - before) * np.exp(-late / lag_s)
        q = command_rad[i - 1] + (q - command_rad[i - 1]) * np.exp(-(step - late) / lag_s)
        before = command_rad[i - 1]
        out[i] = q
    return out


def _joint(t_s: Floats, command: Floats, reading: Floats, lag_s: float) -> Floats:
    """The best delay, lag, gain and offset of one joint."""

    def made(x: Floats) -> Floats:
        return np.asarray(x[2] * lagged(t_s, command, float(x[0]), float(x[1])) + x[3])

    found = least_squares(
        lambda x: made(x) - reading, [lag_s, 0.002, 1.0, 0.0], x_scale=[0.01, 0.002, 0.01, 0.01],
        bounds=([1e-4, 0.0, 0.5, -0.5], [1.0, 0.02, 1.5, 0.5]), max_nfev=30,
    )  # fmt: skip
    return made(found.x)


def _ground(about: Description, t_s: Floats, command: Floats, is_m: Floats) -> Floats:
    """The path with the best factors on friction, mass and lag."""

    def made(x: Floats) -> Floats:
        ct, cn, ct0, cn0, mass, lag = np.exp(x)
        changed = replace(
            about, ct=about.ct * ct, cn=about.cn * cn, ct0=about.ct0 * ct0, cn0=about.cn0 * cn0,
            mass_kg=about.mass_kg * mass, lag_s=about.lag_s * lag,
        )  # fmt: skip
        return foretold(changed, t_s, command)[1][:, :2]

    found = least_squares(
        lambda x: (made(x) - is_m).ravel(), np.zeros(6), diff_step=0.02, bounds=(-3.0, 3.0), max_nfev=25
    )
    return made(found.x)
