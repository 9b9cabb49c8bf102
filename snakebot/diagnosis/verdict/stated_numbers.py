"""What the recordings say of the numbers that the robot's description states: lags of the servos, friction, mass.

Each is believed to be within its tolerance of the stated one (``Robot.tolerance``). What the readings that an
explanation leaves over say beside that narrows it down: the posterior of a linear model with normal errors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.fit_runs import StackedAngles, ground_residuals, shift_limits
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.result import StatedNumber
from snakebot.diagnosis.sizes import NEARLY_ALL
from snakebot.robot import SERVO_LAG
from snakebot.robust import SIGMAS_95

TOLD_BY_DATA = NEARLY_ALL  # of the tolerance: a standard deviation below which the recordings say something
GROUND_NUMBERS = ("friction.ct", "friction.cn", "link_mass_kg")  # as ``ground.tolerance_marks`` has them


def stated_numbers(evidence: Evidence, best: Trial) -> tuple[StatedNumber, ...]:
    """The stated numbers that ``best`` does not set itself, as far as the runs say anything of them."""
    return (*_lags(evidence.angles, evidence.split.free, best), *_of_ground(evidence, best))


def _lags(angles: AngleEvidence, runs: Sequence[int], best: Trial) -> list[StatedNumber]:
    """Time constants, joint by joint; the wire is taken to be as fast as stated."""
    robot = angles.data.robot
    limits, spread_s = shift_limits(angles, best.hypothesis), robot.lag_spread_s
    every = range(angles.data.joints)
    stacked = StackedAngles.of(angles, every, runs, None)
    readings = [best.readings[i] for i in runs]
    left = stacked.residual(readings)
    mark = stacked.times.lag_marks(np.concatenate(readings))
    out = []
    for joint in every:
        use = stacked.use[:, joint]
        if limits.each_s[joint] == 0 or limits.group[joint] >= 0 or not spread_s or not use.any():
            continue
        r, v, block = left[use, joint], mark[use, joint], stacked.block[use, joint]
        size = np.bincount(block)
        square = np.bincount(block, weights=r * r) / np.maximum(size, 1)
        weight = 1 / (angles.allowed_square[: size.size] + square)[block]
        power = float(weight @ (v * v))
        if power <= 0:
            continue
        found = float(weight @ (r * v)) / power
        # sandwich estimate: residuals within a block may be correlated
        pulls = np.bincount(block, weights=weight * v * (r - found * v))
        error = math.sqrt(float(pulls @ pulls)) / power
        out += _told(SERVO_LAG, (joint + 1,), robot.servo.time_constant_s, spread_s, -found, error)
    return out


def _of_ground(evidence: Evidence, best: Trial) -> list[StatedNumber]:
    ground, body = evidence.ground, evidence.data.robot.body
    if ground is None or body is None:
        return []
    specs = best.hypothesis.specs(best.theta)
    if any("friction" in spec.effect.covers for spec in specs):
        return []
    left = ground.features.value - evidence.predictor.ground_features(
        [s for s in specs if s.effect.stage in ("body", "sensor")], evidence.split.free
    )
    use = np.isfinite(left) & np.isin(ground.features.run, evidence.split.free)
    if not use.any():
        return []
    marks = ground.tolerance.marks[use]
    after = ground_residuals(evidence.ground, evidence.predictor, specs, evidence.split.free)[use]
    weight = 1 / (ground.allowed_square[use] + np.square(after))
    precision = marks.T @ (marks * weight[:, None]) + np.diag(1 / np.square(ground.tolerance.spread))
    covariance = np.linalg.inv(precision)
    share = covariance @ (marks.T @ (weight * left[use]))
    error = np.sqrt(np.diag(covariance))
    stated = (body.friction.ct, body.friction.cn, body.link_mass_kg)
    tolerance = evidence.data.robot.tolerance
    relative = (tolerance.friction, tolerance.friction, tolerance.mass)
    out = []
    for i, name in enumerate(GROUND_NUMBERS):
        number = float(np.mean(stated[i]))
        spread = relative[i] * number
        if number > 0 and spread > 0 and error[i] < TOLD_BY_DATA:
            out.append(
                _row(name, (), number, spread, number + spread * float(share[i]), spread * float(error[i]))
            )
    return out


def _told(
    name: str, joints: tuple[int, ...], stated: float, tolerance: float, off: float, error: float
) -> list[StatedNumber]:
    """What was believed and what was seen (``off`` with its standard error), together; none where that is as before."""
    precision = 1 / tolerance**2 + 1 / max(error, 1e-9) ** 2
    spread = 1 / math.sqrt(precision)
    if spread > TOLD_BY_DATA * tolerance:
        return []
    mean = stated + off / max(error, 1e-9) ** 2 / precision
    return [_row(name, joints, stated, tolerance, mean, spread)]


def _row(
    name: str, joints: tuple[int, ...], stated: float, tolerance: float, mean: float, spread: float
) -> StatedNumber:
    return StatedNumber(
        number=name,
        joints=joints,
        stated=stated,
        tolerance=tolerance,
        estimate=mean,
        ci95=(mean - SIGMAS_95 * spread, mean + SIGMAS_95 * spread),
    )
