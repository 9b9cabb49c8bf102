"""Robots as they may well be, for a gait's promise: draws of a description, apart from their effects."""

from __future__ import annotations

import numpy as np

from snakebot.arrays import Floats
from snakebot.calibrated.spread import drawn, known_numbers
from snakebot.effects import EffectSpec, robot_effects
from snakebot.robot import Robot


def draws(robot: Robot, count: int, seed: int = 0) -> list[tuple[Robot, tuple[EffectSpec, ...]]]:
    """Robots without effects of their own, each with the effects drawn for it.

    Raises:
        BadInputError: the description's effects do not fit it.
    """
    rng, numbers = np.random.default_rng(seed), known_numbers(robot)
    made = [drawn(robot, numbers, rng) for _ in range(count)]
    return [(one.model_copy(update={"effects": ()}), robot_effects(one)) for one in made]


def is_known(robot: Robot) -> bool:
    """Whether the description has an interval of every effect that came from a fit."""
    known = {found.number.split(".")[1] for found in robot.intervals if found.ci95 is not None}
    fitted = {
        key.split(".")[1].partition(":")[0]
        for key, note in robot.provenance.items()
        if key.startswith("effects.") and note.status == "fitted"
    }
    return fitted <= known


def interval(values: Floats, extra: float, seed: int = 0) -> tuple[float, float]:
    """The 95 % interval of draws, with an error of this standard deviation on top."""
    if extra > 0:
        noise = np.random.default_rng(seed).normal(size=(200, len(values)))
        values = (values + extra * noise).ravel()
    low, high = np.quantile(values, (0.025, 0.975))
    return float(low), float(high)
