"""An explanation fitted to each fold's runs alone; and what it is taken for where those say nothing of it.

A fold's fit begins at the fit to all runs, which is near and cheap. But a limit that only the held-out run reaches
moves nothing in the others: the search would stay where it began, and the held-out run be predicted from itself. So
where a fold's runs say next to nothing of a parameter, the effect is absent in that fold if it does nothing there, and
the parameter has the value that it has where none is given if that does nothing there (a drive is not limited). Else it
is taken for its usual value, and where that changes anything (it was a dead band so wide that nothing moved) the search
begins there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from snakebot.arrays import Bools, Floats
from snakebot.diagnosis.evidence.folds import Fold
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.fit_runs import (
    Fitted,
    angle_problem,
    bears_loads,
    fit_runs,
    joints_sharing,
    of_body,
    shift_limits,
    specs_from,
)
from snakebot.diagnosis.fit.hypothesis import Box, Hypothesis
from snakebot.diagnosis.fit.least_squares import FEWEST_STEPS, FULL_STEPS, SOME_STEPS, refit
from snakebot.diagnosis.sizes import CLEAR, LITTLE


def fold_thetas(evidence: Evidence, hypothesis: Hypothesis, of_all: Fitted) -> list[Floats]:
    """Parameters (p,) fitted to each fold's runs, from those that were fitted to all; nan for an effect that those runs
    say nothing of. They say something of a parameter if it differs from its usual value, or could, by ``CLEAR``
    standard errors.
    """
    theta = of_all.theta
    known = _near(evidence, hypothesis, of_all)
    size = _sizes(hypothesis, theta)
    return [
        _without_uninformed(
            evidence,
            hypothesis,
            fit.theta,
            fit.information * np.square(size) < CLEAR**2,
            fold,
            theta,
        )
        for fit, fold in zip(known, evidence.split.folds, strict=True)
    ]


def _sizes(hypothesis: Hypothesis, theta: Floats) -> Floats:
    """(p,) distance of each parameter from its usual value, at least its prior's spread; on the fitted scale."""
    usual, believed = np.array([(p.typical, p.spread) for p in hypothesis.parameters]).T
    box = Box.of(hypothesis.parameters)
    inside = np.clip(theta, box.lower, box.upper)
    ratio = np.divide(inside, usual, out=np.ones_like(usual), where=box.logarithmic)
    return np.asarray(np.maximum(believed, np.abs(np.where(box.logarithmic, np.log(ratio), inside - usual))))


def _near(evidence: Evidence, hypothesis: Hypothesis, of_all: Fitted) -> list[Fitted]:
    """Fits to each fold's runs from the one to all. Where the whole body must be simulated, or joints have values of
    their own, parameters of what comes before the ground take one step from there: what a run more or less changes is
    little.
    """
    theta = of_all.theta
    costly = evidence.predictor.simulator.needs_body(hypothesis.specs(theta))
    costly |= any(term.own for term in hypothesis.terms)
    sides = (True,) if costly else (True, False)
    found = [
        fit_runs(evidence, hypothesis, [theta], fold.fit, SOME_STEPS, sides=sides)
        for fold in evidence.split.folds
    ]
    mine = ~of_body(hypothesis)
    if not (costly and mine.any()):
        return found

    problem, about = of_all.angles or (None, None)
    if problem is None:
        problem = angle_problem(
            evidence.angles,
            evidence.predictor.simulator,
            hypothesis,
            specs_from(hypothesis, theta, mine),
            evidence.split.free,
            Box.of(hypothesis.parameters).among(mine),
            rough=False,
            mine=mine,
            at=theta,
        )
    if problem is None:
        return found
    uses = [
        np.isin(evidence.scoring.run, fold.fit)[problem.block] & (problem.block >= 0)
        for fold in evidence.split.folds
    ]
    near = refit(problem, problem.for_each(theta[mine]), uses, about)
    for fit, part in zip(found, near, strict=True):
        fit.theta[mine] = problem.of_all(part.theta)
        fit.information[mine] = problem.of_all(part.information)
    return found


def _without_uninformed(
    evidence: Evidence,
    hypothesis: Hypothesis,
    theta: Floats,
    uninformed: Bools,
    fold: Fold,
    of_all_runs: Floats,
) -> Floats:
    """``theta`` (p,) of a fold whose runs say nothing of some parameters: ``uninformed`` (p,). Servos bear the torques
    of the motion that the fit ``of_all_runs`` (p,) makes.
    """
    if not uninformed.any():
        return theta
    out = _without_idle(
        hypothesis, theta, uninformed, lambda a, b: not _shows(evidence, hypothesis, a, b, fold.fit)
    )
    absent = np.isnan(out)
    out, left_out = _with_defaults(evidence, hypothesis, out, uninformed & ~absent, fold)
    far = uninformed & ~absent & ~left_out
    if not far.any():
        return out
    usual = np.array([p.typical for p in hypothesis.parameters])
    start = np.where(far, usual, out)
    simulator = evidence.predictor.simulator
    bears = bears_loads(simulator, hypothesis, start)
    meet = simulator.joints_meet(hypothesis.specs(start), rough=True)
    given = meet and bool(bears[far].all())
    # Under given torques a fit takes less time than to look whether it is called for.
    if not given and not _shows(evidence, hypothesis, out, start, fold.fit):
        return start
    only, steps = ~absent, FULL_STEPS
    if given or not meet:
        # What shares no joint with those is as well fitted as it was; over ground all go together. Under given torques
        # what goes along with the body stays, so that none needs to be simulated.
        stay = ~bears if given else np.zeros_like(bears)
        near = joints_sharing(hypothesis, evidence.data.joints, far, stay)
        body = of_body(hypothesis)
        shared = hypothesis.touches(evidence.data.joints)[:, near].any(axis=1) & ~body
        only &= ~stay & (shared | (body & (far & body).any()))
    if not given and simulator.always_needs_body(hypothesis.specs(start)):
        # Each slope takes a body: what those runs say of the others is known from the fit near by.
        only, steps = far, FEWEST_STEPS
    found = fit_runs(evidence, hypothesis, [start], fold.fit, steps, only=only, loads_of=of_all_runs).theta
    if given:
        # Those torques are of another motion: with a play that the load takes up they may lead anywhere.
        before, after = (_cost(evidence, hypothesis, theta, fold.fit) for theta in (start, found))
        if after > before:
            found = fit_runs(evidence, hypothesis, [start], fold.fit, FEWEST_STEPS, only=far).theta
    return _without_unmet(evidence, hypothesis, found, far, fold.fit)


def _with_defaults(
    evidence: Evidence, hypothesis: Hypothesis, theta: Floats, asked: Bools, fold: Fold
) -> tuple[Floats, Bools]:
    """``theta`` (p,) where those parameters that are ``asked`` about (p,) and need not be given are not, if that does
    nothing in the fold's runs; and which these are (p,).
    """
    default = np.array([np.nan if p.default is None else p.default for p in hypothesis.parameters])
    spare = asked & np.isfinite(default)
    without = np.where(spare, default, theta)
    if not spare.any() or _shows(evidence, hypothesis, theta, without, fold.fit):
        return theta, np.zeros_like(spare)
    return without, spare


def _without_unmet(
    evidence: Evidence, hypothesis: Hypothesis, theta: Floats, searched: Bools, runs: tuple[int, ...]
) -> Floats:
    """``theta`` (p,), nan for effects all of whose parameters were ``searched`` for (p,), and without which the joint
    angles of the runs are not clearly less likely: a limit that they never meet ends where they would just not meet it.
    """

    def is_unmet(there: Floats, gone: Floats) -> bool:
        with_it, without = (_cost(evidence, hypothesis, some, runs, rough=True) for some in (there, gone))
        return without - with_it < CLEAR**2  # twice the logarithm of a likelihood ratio

    return _without_idle(hypothesis, theta, searched & ~of_body(hypothesis), is_unmet)


def _without_idle(
    hypothesis: Hypothesis, theta: Floats, asked: Bools, is_idle: Callable[[Floats, Floats], bool]
) -> Floats:
    """``theta`` (p,), nan for the effects all of whose parameters are ``asked`` about (p,) and which are idle: that is
    said of the parameters with the effect, and without it.
    """
    out = theta.copy()
    for own in hypothesis.alike:
        if asked[own].all():
            without = out.copy()
            without[own] = np.nan
            if is_idle(out, without):
                out = without
    return out


def _cost(
    evidence: Evidence,
    hypothesis: Hypothesis,
    theta: Floats,
    runs: tuple[int, ...],
    *,
    rough: bool = False,
) -> float:
    """What parameters (p,) leave of the angles in some runs: the loss of a fit, each block weighing the same."""
    angles, made = evidence.angles, list(evidence.predictor.nominal)
    readings = evidence.predictor.readings(hypothesis.specs(theta), runs, rough=rough)
    for index, reading in zip(runs, readings, strict=True):
        made[index] = reading
    left = angles.residuals(made, angles.shifts_s(made, runs, shift_limits(angles, hypothesis)))
    rows = np.isin(angles.blocks.run, runs)
    return float(np.log1p(angles.blocks.mean_square(left) / angles.fitted_square)[rows].sum())


def _shows(
    evidence: Evidence, hypothesis: Hypothesis, one: Floats, other: Floats, runs: tuple[int, ...]
) -> bool:
    """Whether two values of the parameters (p,) make a difference in some runs that noise and tolerance do not hide:
    under the torques of the measured motion, where servos bear any.
    """
    specs = [hypothesis.specs(theta) for theta in (one, other)]
    a, b = (evidence.predictor.readings(s, runs, rough=True) for s in specs)
    change = [np.zeros_like(nominal) for nominal in evidence.predictor.nominal]
    for index, x, y in zip(runs, a, b, strict=True):
        change[index] = x - y
    if np.any(evidence.angles.blocks.mean_square(change) > LITTLE * evidence.angles.allowed_square):
        return True
    if evidence.ground is None:
        return False
    moved = np.subtract(*(evidence.predictor.ground_features(s, runs) for s in specs))
    return bool(np.any(np.square(np.nan_to_num(moved)) > LITTLE * evidence.ground.allowed_square))
