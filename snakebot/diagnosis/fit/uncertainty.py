"""Intervals of parameters: from the scatter of the data, from the nominal numbers that are only known within a
tolerance, and from what a real effect differs in from the library's.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.parallel import in_parallel
from snakebot.diagnosis.fit.trial import Trial, run_trial
from snakebot.effects.parameter import Parameter
from snakebot.robot import Robot
from snakebot.robust import SIGMAS_95


def standard_errors(evidence: Evidence, trial: Trial, *, tolerances: bool = True) -> Floats:
    """(p,) standard errors of the parameters; inf where the data say nothing."""
    square = np.diag(trial.covariance).copy() if trial.theta.size else np.zeros(0)
    square = np.where(np.isnan(square), np.inf, square)
    neutral = np.array([p.neutral for p in trial.hypothesis.parameters])
    real_share = np.array([p.real_share for p in trial.hypothesis.parameters])
    square = square + np.square(real_share * (trial.theta - neutral))
    if not tolerances or not trial.theta.size:
        return np.asarray(np.sqrt(square))
    body = any(term.stage == "body" for term in trial.hypothesis.terms)
    for theta in in_parallel(partial(_fitted_with, evidence, trial), _off(evidence.data.robot, body)):
        square = square + np.square(theta - trial.theta)
    return np.asarray(np.sqrt(square))


def _fitted_with(evidence: Evidence, trial: Trial, robot: Robot) -> Floats:
    """Parameters (p,) of the same explanation, fitted again with other nominal numbers."""
    shifted = evidence.of_robot(robot)
    return run_trial(shifted, trial.hypothesis, [trial.theta], cross=False).theta


def _off(robot: Robot, body_too: bool) -> list[Robot]:
    """Robots with one nominal number off by one standard deviation of its tolerance."""
    servo = robot.servo
    slower = servo.model_copy(update={"time_constant_s": servo.time_constant_s + robot.lag_spread_s})
    out = [robot.model_copy(update={"servo": slower})]
    if body_too and robot.body is not None:
        body, friction = robot.body, robot.body.friction
        up = 1 + robot.tolerance.friction
        for names in (("ct", "ct0"), ("cn", "cn0")):
            changed = friction.model_copy(update={n: _times(getattr(friction, n), up) for n in names})
            out.append(robot.model_copy(update={"body": body.model_copy(update={"friction": changed})}))
        heavier = _times(body.link_mass_kg, 1 + robot.tolerance.mass)
        out.append(robot.model_copy(update={"body": body.model_copy(update={"link_mass_kg": heavier})}))
    return out


def _times(value: float | tuple[float, ...], factor: float) -> float | tuple[float, ...]:
    return tuple(v * factor for v in value) if isinstance(value, tuple) else value * factor


def interval(parameter: Parameter, value: float, error: float) -> tuple[float, float] | None:
    """95 % interval within the bounds, on the parameter's own scale; None where the data say nothing."""
    if not np.isfinite(error):
        return None
    if parameter.scale == "log" and value > 0:
        factor = float(np.exp(min(SIGMAS_95 * error / value, 50.0)))
        low, high = value / factor, value * factor
    else:
        low, high = value - SIGMAS_95 * error, value + SIGMAS_95 * error
    return max(low, parameter.lower), min(high, parameter.upper)
