"""Ways to a fast gait of a blind robot: by trying gaits out on it, and by trying all of them."""

from __future__ import annotations

from itertools import product

import numpy as np

from blind.chain import Floats
from blind.gait_robots import GaitRobot, measured_speed, true_speeds
from blind.robot import Robot
from snakebot.optimise.space import Space

SHORTEST = 1 / 8  # of the grid's spacing: the last step of the refinement


def tried_out(robot: GaitRobot, space: Space, runs: int, seed: int) -> Floats:
    """The gait (3,) that was measured to be the fastest in so many runs chosen by a Bayesian optimiser."""
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    body, rng = Robot(robot.parameters), np.random.default_rng([seed, robot.number])
    made: list[tuple[float, Floats]] = []

    def run(trial: optuna.Trial) -> float:
        share = np.array([trial.suggest_float(name, 0.0, 1.0) for name in ("alpha", "beta", "omega")])
        gait = in_space(space, share)
        made.append((measured_speed(body, gait, rng), gait))
        return made[-1][0]

    sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=max(2, runs // 2), multivariate=True)
    optuna.create_study(direction="maximize", sampler=sampler).optimize(run, n_trials=runs)
    return max(made, key=lambda pair: pair[0])[1]


def in_space(space: Space, share: Floats) -> Floats:
    """A gait from three shares: of the ranges, and of the omega that limits leave at that amplitude."""
    alpha = space.alpha_rad[0] + share[0] * (space.alpha_most_rad - space.alpha_rad[0])
    beta = space.beta_rad[0] + share[1] * (space.beta_rad[1] - space.beta_rad[0])
    most = float(space.omega_most(np.array(alpha)))
    return np.array([alpha, beta, space.omega_rad_s[0] + share[2] * (most - space.omega_rad_s[0])])


def brute_force(
    robot: GaitRobot, space: Space, grid: tuple[int, int, int], others: Floats
) -> tuple[Floats, float]:
    """The fastest gait of the robot itself: a grid, and from its best place and the best of ``others`` uphill."""
    axes = [np.linspace(0, 1, count) for count in grid]
    table = np.array([in_space(space, np.array(shares)) for shares in product(*axes)])
    speeds = true_speeds(robot.parameters, table)
    starts = [table[np.argmax(speeds)]]
    if len(others):
        starts.append(others[np.argmax(true_speeds(robot.parameters, others))])
    return max((_uphill(robot, space, start, grid) for start in starts), key=lambda pair: pair[1])


def _uphill(
    robot: GaitRobot, space: Space, start: Floats, grid: tuple[int, int, int]
) -> tuple[Floats, float]:
    low = np.array([space.alpha_rad[0], space.beta_rad[0], space.omega_rad_s[0]])
    high = np.array([space.alpha_most_rad, space.beta_rad[1], space.omega_rad_s[1]])
    spacing = (high - low) / np.maximum(np.array(grid) - 1, 1)
    best, speed, step = start, float(true_speeds(robot.parameters, start[None, :])[0]), 0.5
    while step >= SHORTEST:
        around = space.nearest(best + step * spacing * np.concatenate([np.eye(3), -np.eye(3)]))
        speeds = true_speeds(robot.parameters, around)
        if speeds.max() > speed * (1 + 1e-6):
            best, speed = around[np.argmax(speeds)], float(speeds.max())
        else:
            step /= 2
    return best, speed
