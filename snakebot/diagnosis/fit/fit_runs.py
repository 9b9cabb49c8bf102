"""One explanation fitted to some runs: parameters of the body to the motion over ground, all others to the angles.

Each side sees the other's effects at their fitted values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from snakebot.arrays import Bools, Floats, Ints
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.ground_evidence import GroundEvidence
from snakebot.diagnosis.evidence.predictor import Predictor
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.diagnosis.evidence.tolerance import ShiftLimits, StackedTimes, shifts_s
from snakebot.diagnosis.fit.hypothesis import Box, Hypothesis
from snakebot.diagnosis.fit.least_squares import Fit, Linearised, approach, minimise, multi_start
from snakebot.diagnosis.fit.step import Problem, sharing
from snakebot.effects.spec import EffectSpec

# Parameters of an explanation that are many: their slopes are what a fit takes its time for; chosen, fewer than a
# position loop has.
MANY_PARAMETERS = 8

Specs = Callable[[Floats], tuple[EffectSpec, ...]]


def ground_residuals(
    ground: GroundEvidence | None,
    predictor: Predictor,
    specs: Sequence[EffectSpec],
    fitted: Sequence[int],
    runs: Sequence[int] | None = None,
) -> Floats:
    """(G,) residuals of the motion over ground under some effects, with the tolerances that suit the ``fitted`` runs;
    nan for runs not asked for; empty where nothing was measured.
    """
    if ground is None:
        return np.zeros(0)
    predicted = predictor.ground_features(specs, runs)
    set_by_effect = any("friction" in s.effect.covers for s in specs)
    return ground.residuals(predicted, fitted, friction_is_set=set_by_effect)


def specs_from(hypothesis: Hypothesis, base: Floats, mine: Bools) -> Specs:
    """The effects as a function of those parameters that are ``mine``, the others as in ``base`` (p,)."""

    def specs(part: Floats) -> tuple[EffectSpec, ...]:
        full = base.copy()
        full[mine] = part
        return hypothesis.specs(full)

    return specs


def of_body(hypothesis: Hypothesis) -> Bools:
    """(p,) which parameters are those of the body."""
    return np.array([term.stage == "body" for term in hypothesis.terms for _ in term.open], dtype=bool)


class Fitted(NamedTuple):
    """Parameters ``theta`` (p,), their ``covariance`` (p, p), nan where nothing was fitted, and the ``information``
    (p,) of the runs on each: see ``Fit``; zero where none of the runs shows its side, nan where it was not fitted.
    ``angles``: the fit of the angles as a problem, and that about ``theta``; where all were fitted, with a covariance.
    """

    theta: Floats
    covariance: Floats
    information: Floats
    angles: tuple[Problem, Linearised] | None = None


def fit_runs(
    evidence: Evidence,
    hypothesis: Hypothesis,
    starts: Sequence[Floats],
    runs: Sequence[int],
    steps: int,
    keep: int = 1,
    *,
    covariance: bool = False,
    rough: bool = False,
    sides: Sequence[bool] = (True, False),
    only: Bools | None = None,
    loads_of: Floats | None = None,
) -> Fitted:
    """Fit an explanation to some runs from each of ``starts`` (p,).

    ``sides``: parameters of the body (True), all others (False). The body comes first: angles hardly know of it, but it
    knows of the load. ``only``: (p,) the parameters that are fitted, all if None. ``loads_of``: (p,) parameters near
    by, whose motion's torques the servos are taken to bear, where that keeps joints apart.
    """
    count = len(hypothesis.parameters)
    best = np.array(starts[0], dtype=np.float64) if len(starts) else np.zeros(0)
    spread, information = np.full((count, count), np.nan), np.full(count, np.nan)
    box = Box.of(hypothesis.parameters)
    body, angles = of_body(hypothesis), None
    for side in sides:
        mine = body if side else ~body
        if only is not None:
            mine = mine & only
        if not mine.any():
            continue
        specs, mine_in = specs_from(hypothesis, best, mine), box.among(mine)
        if side:
            problem = ground_problem(evidence.ground, evidence.predictor, specs, runs, mine_in)
        else:
            problem = angle_problem(
                evidence.angles,
                evidence.predictor.simulator,
                hypothesis,
                specs,
                runs,
                mine_in,
                rough=rough,
                mine=mine,
                at=best,
            )
            if loads_of is not None:
                problem = _under_loads_of(
                    evidence.predictor.simulator, hypothesis, problem, best, loads_of[mine]
                )
        if problem is None:
            information[mine] = 0.0
            continue
        begin = [problem.for_each(np.asarray(start, dtype=np.float64)[mine]) for start in starts]
        if mine.sum() > MANY_PARAMETERS:
            begin = [approach(problem, start) for start in begin]
        fit: Fit = (
            multi_start(problem, begin, keep, steps, covariance=covariance)
            if len(begin) > 1
            else minimise(problem, begin[0], steps, covariance=covariance)
        )
        best = best.copy()
        best[mine] = problem.of_all(fit.theta)
        spread[np.ix_(mine, mine)] = problem.of_all(fit.covariance)
        information[mine] = problem.of_all(fit.information)
        if not side and only is None and fit.about is not None:
            angles = problem, fit.about
    return Fitted(best, spread, information, angles)


def _under_loads_of(
    simulator: Simulator, hypothesis: Hypothesis, problem: Problem | None, at: Floats, part: Floats
) -> Problem | None:
    """A problem under the torques that the motion at its parameters ``part`` bears, if they bear any. Where some joint
    goes where the others take it, a parameter changes what is left there by what it changes under those torques.
    """
    if problem is None or problem.near is None:
        return problem
    there = problem.for_each(part)
    if simulator.always_needs_body(hypothesis.specs(at)):
        return problem.about(there) if np.all(problem.near_for) else problem
    return problem.near(there)


def angle_problem(
    angles: AngleEvidence,
    simulator: Simulator,
    hypothesis: Hypothesis,
    specs: Specs,
    runs: Sequence[int],
    box: Box,
    *,
    rough: bool,
    mine: Bools,
    at: Floats,
) -> Problem | None:
    """``specs`` of the open parameters, with these bounds, against the joint angles; None where none is used. Joints
    that share no parameter are units of their own, unless they disturb each other.

    ``mine``: (p,) which parameters of the hypothesis these are; ``at``: (p,) where they begin.
    """
    joints = [j - 1 for j in hypothesis.joints(angles.data.joints)]
    meet = simulator.joints_meet(hypothesis.specs(at), rough=rough)
    if not meet:
        near = joints_sharing(hypothesis, angles.data.joints, mine)
        joints = [j for j in joints if near[j]]
    stacked = StackedAngles.of(angles, joints, runs, shift_limits(angles, hypothesis))
    if not stacked.use.any():
        return None

    known: dict[bytes, list[Floats]] = {}  # of the last motion: parameters, and torques on the servos

    def of_some(theta: Floats, some: StackedAngles, loads_nm: Sequence[Floats] | None = None) -> Floats:
        columns = some.columns.tolist()
        made = simulator.predict(
            specs(problem.of_all(theta)), runs, rough=rough, columns=columns, loads_nm=loads_nm
        )
        if problem.near is not None and loads_nm is None:
            known.clear()
            known[theta.tobytes()] = [p.servos.load_nm for p in made]
        return some.residual([p.reading_rad for p in made])

    def under_loads_of(theta: Floats) -> Problem:
        """The same with the torques of one motion on the servos: joints stay apart, and no body is simulated."""
        if theta.tobytes() not in known:
            problem.residual(theta)
        under = partial(of_some, loads_nm=known[theta.tobytes()])
        return replace(
            problem,
            residual=lambda theta: under(theta, stacked),
            touches=touches,
            some=stacked.spread(under),
            near=None,
        )

    touches = hypothesis.touches(angles.data.joints)[mine][:, joints]
    bears = bears_loads(simulator, hypothesis, at)[mine]
    # Under given torques slopes are exact, but others need those of the whole body beside: for a few parameters the
    # second simulation costs more than it saves.
    cheap = meet and not rough and bears.sum() > (0 if bears.all() else MANY_PARAMETERS)
    problem = Problem(
        lambda theta: of_some(theta, stacked),
        np.zeros(len(joints), dtype=np.int64) if meet else sharing(touches),
        stacked.block,
        angles.fitted_square,
        *box,
        touches=None if meet else touches,
        some=stacked.spread(of_some),
        secant=meet and not cheap,
        near=under_loads_of if cheap else None,
        near_for=bears if cheap else None,
    )
    return problem


def bears_loads(simulator: Simulator, hypothesis: Hypothesis, theta: Floats) -> Bools:
    """(p,) parameters whose slopes are the same, or nearly, with the torques on the servos given: those of effects that
    do not make a joint go where the others take it. None where a joint is free or driven by another's set-points.
    """
    if simulator.others_drive(hypothesis.specs(theta)):
        return np.zeros(theta.size, dtype=bool)
    found = []
    for term, values in zip(hypothesis.terms, hypothesis.split(theta), strict=True):
        found += [not simulator.always_needs_body(term.specs(values.tolist()))] * len(term.open)
    return np.array(found, dtype=bool)


def joints_sharing(hypothesis: Hypothesis, count: int, mine: Bools, stay: Bools | bool = False) -> Bools:
    """(count,) joints that some parameters of servos and sensors, ``mine`` (p,), act on, and joints that share any
    parameter with those, directly or by way of others; but for parameters that ``stay`` (p,) as they are.
    """
    touches, moving = hypothesis.touches(count), ~of_body(hypothesis) & np.logical_not(stay)
    units = sharing(touches[moving])
    return np.isin(units, units[touches[mine & moving].any(axis=0)])


def shift_limits(angles: AngleEvidence, hypothesis: Hypothesis) -> ShiftLimits:
    """How much less than stated each joint may lag beside an explanation: not where it sets the delay itself."""
    return ShiftLimits.of(angles.data.robot, hypothesis.sets("delay", angles.data.joints))


@dataclass(frozen=True, eq=False)
class StackedAngles:
    """Some joints (c of them) in some runs, one run below the other (N samples in all).

    Attributes:
        columns: (c,) 0-based joints.
        measured: (N, c) angles, rad.
        block: (N, c) number of each sample's block, -1 where it is not used.
        times: of the samples.
        allowed_square: (B,) squared spread of all blocks that a fit reckons with.
        limits: how much less than stated each joint may lag.
    """

    columns: Ints
    measured: Floats
    block: Ints
    times: StackedTimes
    allowed_square: Floats
    limits: ShiftLimits

    @staticmethod
    def of(
        angles: AngleEvidence, joints: Sequence[int], runs: Sequence[int], limits: ShiftLimits | None
    ) -> StackedAngles:
        """``limits``: of all joints; None: they lag as stated."""
        if limits is None:
            limits = ShiftLimits.none(angles.data.joints)
        columns = np.array(joints, dtype=np.int64)
        return StackedAngles(
            columns,
            np.nan_to_num(np.concatenate([angles.data.runs[i].measured_rad[:, columns] for i in runs])),
            np.concatenate([angles.blocks.of_sample[i][:, columns] for i in runs]),
            angles.times_of(runs),
            angles.fitted_square,
            limits.of_joints(columns),
        )

    def among(self, wanted: Bools) -> StackedAngles:
        """Those of the columns that are ``wanted`` (c,)."""
        return replace(
            self,
            columns=self.columns[wanted],
            measured=self.measured[:, wanted],
            block=self.block[:, wanted],
            limits=self.limits.of_joints(np.flatnonzero(wanted)),
        )

    def spread(
        self, residual: Callable[[Floats, StackedAngles], Floats]
    ) -> Callable[[Floats, Bools], Floats]:
        """``residual`` of those columns alone that are wanted (c,), zeros (N, c) elsewhere."""
        parts: dict[bytes, StackedAngles] = {}

        def some(theta: Floats, wanted: Bools) -> Floats:
            key = wanted.tobytes()
            part = parts.get(key) or parts.setdefault(key, self.among(wanted))
            out = np.zeros(self.block.shape)
            out[:, wanted] = residual(theta, part)
            return out

        return some

    @property
    def use(self) -> Bools:
        """(N, c) samples that are compared."""
        return self.block >= 0

    def residual(self, readings: Sequence[Floats]) -> Floats:
        """(N, c) residuals of predicted readings (n, k) of each run, with lags as far off as is credible."""
        made = np.concatenate(readings)[:, self.columns]
        use = self.use
        residual = np.where(use, self.measured - made, 0.0)
        if self.limits.any:
            mark = np.where(use, self.times.lag_marks(made), 0.0)
            residual -= mark * shifts_s(residual, mark, self.block, self.allowed_square, self.limits)
        return residual


def ground_problem(
    ground: GroundEvidence | None,
    predictor: Predictor,
    specs: Specs,
    runs: Sequence[int],
    box: Box,
) -> Problem | None:
    """``specs`` of the open parameters, with these bounds, against the motion over ground; None where none is known."""
    if ground is None:
        return None
    rows = np.isin(ground.features.run, list(runs))
    if not rows.any():
        return None
    block = np.where(rows, np.arange(ground.features.count), -1)[:, None]

    def residual(theta: Floats) -> Floats:
        left = ground_residuals(ground, predictor, specs(theta[0]), runs, runs)
        return np.where(rows, np.nan_to_num(left), 0.0)[:, None]

    return Problem(residual, np.zeros(1, dtype=np.int64), block, ground.allowed_square, *box)
