"""An explanation fitted to each fold's runs alone; and what it is taken for where those say nothing of it.

A fold's fit begins at the fit to all runs, which is near and cheap. But a limit that only the held-out run reaches
moves nothing in the others: the search would stay where it began, and the held-out run be predicted from itself. So
where a fold's runs say next to nothing of a parameter, the effect is absent in that fold if it does nothing there;
else (a dead band so wide that nothing moves) the search begins at the usual value.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.context import Context
from snakebot.diagnosis.fit import refit
from snakebot.diagnosis.fitting import (
    Bools,
    Fitted,
    angle_problem,
    fit_runs,
    of_body,
    predicted_readings,
    specs_from,
)
from snakebot.diagnosis.folds import Fold
from snakebot.diagnosis.hypothesis import Hypothesis, bounds
from snakebot.diagnosis.score import CHANGED

Floats = NDArray[np.float64]

FOLD_STEPS = 8
TOLD_SE = (
    2.0  # standard errors that a parameter must stand off its usual value, or could, for runs to tell of it
)
AFRESH_STEPS = 20  # from the usual value, which may be far


def fold_thetas(context: Context, hypothesis: Hypothesis, theta: Floats) -> list[Floats]:
    """Parameters (p,) fitted to each fold's runs, from ``theta``, which was fitted to all; nan for an effect that those
    runs say nothing of.
    """
    known = _near(context, hypothesis, theta)
    size = _sizes(hypothesis, theta)
    return [
        _settled(context, hypothesis, fit.theta, fit.told * np.square(size) < TOLD_SE**2, fold)
        for fit, fold in zip(known, context.folds, strict=True)
    ]


def _sizes(hypothesis: Hypothesis, theta: Floats) -> Floats:
    """(p,) how far each parameter stands off its usual value, or is believed to before any run; on the fitted scale."""
    usual, believed = np.array([(p.typical, p.spread) for p in hypothesis.parameters]).T
    lower, upper, log = bounds(hypothesis.parameters)
    inside = np.clip(theta, lower, upper)
    ratio = np.divide(inside, usual, out=np.ones_like(usual), where=log)
    return np.asarray(np.maximum(believed, np.abs(np.where(log, np.log(ratio), inside - usual))))


def _near(context: Context, hypothesis: Hypothesis, theta: Floats) -> list[Fitted]:
    """Fits to each fold's runs from ``theta``. Where the whole body must be simulated, parameters of what comes before
    the ground take one step from there: what a run more or less changes is little.
    """
    coupled = context.simulator.coupled(hypothesis.specs(theta))
    sides = (True,) if coupled else (True, False)
    found = [
        fit_runs(context, hypothesis, [theta], fold.fit, FOLD_STEPS, sides=sides) for fold in context.folds
    ]
    mine = ~of_body(hypothesis)
    if not (coupled and mine.any()):
        return found

    lower, upper, log = bounds(hypothesis.parameters)
    box = (lower[mine], upper[mine], log[mine])
    whole = specs_from(hypothesis, theta, mine)
    problem = angle_problem(context, hypothesis, whole, context.free_runs, *box, rough=False)
    if problem is None:
        return found
    uses = [
        np.isin(context.block_run, fold.fit)[problem.block] & (problem.block >= 0) for fold in context.folds
    ]
    for fit, part in zip(found, refit(problem, theta[mine], uses), strict=True):
        fit.theta[mine], fit.told[mine] = part.theta, part.told
    return found


def _settled(context: Context, hypothesis: Hypothesis, theta: Floats, blind: Bools, fold: Fold) -> Floats:
    """``theta`` (p,) of a fold whose runs say nothing of some parameters: ``blind`` (p,)."""
    if not blind.any():
        return theta
    out, at = theta.copy(), 0
    for term in hypothesis.terms:
        own = slice(at, at + len(term.open))
        at = own.stop
        if term.open and blind[own].all():
            without = out.copy()
            without[own] = np.nan
            if not _shows(context, hypothesis, out, without, fold.fit):
                out = without
    absent = np.isnan(out)
    if not (blind & ~absent).any():
        return out
    usual = np.array([p.typical for p in hypothesis.parameters])
    start = np.where(blind & ~absent, usual, out)
    return fit_runs(context, hypothesis, [start], fold.fit, AFRESH_STEPS, only=~absent).theta


def _shows(
    context: Context, hypothesis: Hypothesis, one: Floats, other: Floats, runs: tuple[int, ...]
) -> bool:
    """Whether two values of the parameters (p,) make a difference in some runs that noise and tolerance do not hide."""
    specs = [hypothesis.specs(theta) for theta in (one, other)]
    a, b = (predicted_readings(context, s, runs) for s in specs)
    change = [np.zeros_like(nominal) for nominal in context.nominal]
    for index, x, y in zip(runs, a, b, strict=True):
        change[index] = x - y
    if np.any(context.angle_blocks.mean_square(change) > CHANGED * context.scale.square):
        return True
    if context.ground is None:
        return False
    moved = np.subtract(*(context.ground_features(s, runs) for s in specs))
    return bool(np.any(np.square(np.nan_to_num(moved)) > CHANGED * context.ground_allowed_square))
