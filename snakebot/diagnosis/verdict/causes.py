"""What speaks for each cause of the best explanation: its group, its probability, its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import Scoring
from snakebot.diagnosis.fit.hypothesis import Hypothesis, Term, fixed_by
from snakebot.diagnosis.fit.trial import Trial, run_trial, trial_at
from snakebot.diagnosis.fit.uncertainty import interval
from snakebot.diagnosis.options import Options
from snakebot.diagnosis.result import BudgetEntry, Cause, Estimate, FitEntry, JointEstimate, RankingEntry
from snakebot.diagnosis.search.acceptance import lead, touched
from snakebot.diagnosis.search.groups import degenerate, indistinguishable
from snakebot.diagnosis.search.rounds import MOST_EFFECTS
from snakebot.diagnosis.search.search import SearchResult, without_term
from snakebot.diagnosis.sizes import HALF, SURE
from snakebot.diagnosis.verdict.at_end import held_back
from snakebot.diagnosis.verdict.bend import less_sure
from snakebot.diagnosis.verdict.closure import angle_closure, forward_speeds, speed_closure
from snakebot.diagnosis.verdict.decision import Judgement
from snakebot.diagnosis.verdict.joints import joints_of
from snakebot.diagnosis.verdict.left_out import doubted_for_left_out
from snakebot.diagnosis.verdict.noise import EncoderScatter
from snakebot.diagnosis.verdict.probability import (
    MOST_BESIDE_GROUND_REST,
    CauseFeatures,
    at_most,
    probability,
)
from snakebot.diagnosis.verdict.ranking import ranked
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.effects.registry import find_effect
from snakebot.effects.spec import EffectSpec


def _named(angles: AngleEvidence, term: Term) -> Term:
    """A term as it is told: of joints that were never read nothing is claimed."""
    joints = joints_of(angles, term)
    if term.joints is not None or not find_effect(term.effect).per_joint or len(joints) == angles.data.joints:
        return term
    return replace(term, joints=joints)


@dataclass(frozen=True, eq=False)
class _Weighed:
    """One term of the best explanation with what speaks for it."""

    cause: Cause
    group: list[Trial]
    closes: float


@dataclass(frozen=True, eq=False)
class _Explanation:
    """What all terms of the best explanation are weighed with."""

    evidence: Evidence
    found: SearchResult
    judgement: Judgement
    budget: Sequence[BudgetEntry]
    unnamed: Sequence[str]
    options: Options

    @property
    def best(self) -> Trial:
        return self.judgement.best

    def rivals(self, index: int) -> Sequence[Trial]:
        """Explanations with another term in place of the one at ``index``."""
        return self.found.rivals[index] if index < len(self.found.rivals) else ()

    def share(self, index: int) -> float:
        """Of the gap, what the term at ``index`` carries: of the joint angles where it has a part in them, else over
        ground; all, where nothing is shared out.
        """
        return next((entry.share for entry in self.budget if entry.cause == index), 1.0)

    def without(self, index: int) -> Trial:
        """What is left of it without that term."""
        if len(self.best.hypothesis.terms) < 2:
            return self.found.nominal
        return (
            self.found.without[index] if self.found.without else without_term(self.evidence, self.best, index)
        )


def weigh_causes(
    evidence: Evidence,
    found: SearchResult,
    judgement: Judgement,
    errors: Floats,
    budget: Sequence[BudgetEntry],
    unnamed: Sequence[str],
    options: Options,
) -> tuple[list[Cause], list[Trial], tuple[RankingEntry, ...]]:
    """Causes in the order of what they close, the rivals still open (best first), and the ranking.

    Args:
        errors: (p,) standard errors of the parameters of the best explanation.
        budget: what each of its terms carries of the gap.
        unnamed: effects that may be there, but may not be named.
    """
    best = judgement.best
    explanation = _Explanation(evidence, found, judgement, budget, unnamed, options)
    weighed: list[_Weighed] = []
    at = 0
    for index, term in enumerate(best.hypothesis.terms):
        count = len(term.open)
        weighed.append(_weigh(explanation, index, errors[at : at + count]))
        at += count
    order = sorted(range(len(weighed)), key=lambda i: -weighed[i].closes)
    open_rivals = [best, *weighed[order[0]].group] if weighed and weighed[order[0]].group else []
    for i in order[1:]:
        if not open_rivals and weighed[i].group:
            open_rivals = [best, *weighed[i].group]
    ranking = ranked(evidence, found, best, [(weighed[i].cause.probability, weighed[i].group) for i in order])
    return [weighed[i].cause for i in order], open_rivals, ranking


def _weigh(explanation: _Explanation, index: int, errors: Floats) -> _Weighed:
    """The term at ``index``; ``errors``: standard errors of its open parameters."""
    evidence, found, best = explanation.evidence, explanation.found, explanation.best
    options, rivals, without = explanation.options, explanation.rivals(index), explanation.without(index)
    group = indistinguishable(evidence, best, rivals, options.seed)
    scoring = evidence.scoring
    term = best.hypothesis.terms[index]
    by_chance = found.seen_in_scatter and "scatter" in find_effect(term.effect).shows_in
    theta = best.hypothesis.split(best.theta)[index]
    alone = Hypothesis((term,))
    single = found.known(alone)
    if single is None and len(best.hypothesis.terms) > MOST_EFFECTS:
        single = trial_at(evidence, alone, theta)
    single = single or run_trial(evidence, alone, [theta])
    outside = [r for r in rivals if r not in group and not degenerate(best, r)]
    ahead = min((lead(scoring, best, r).mean for r in outside), default=lead(scoring, best, without).mean)
    rest, closed = _rest_and_closed(scoring, best, without, term)
    worn = any(t.own for t in best.hypothesis.terms)
    features = CauseFeatures(
        lead=round(ahead, 5),
        rest=round(rest, 4),
        closed=round(closed, 4),
        share=explanation.share(index),
        motions=1 if found.untested else len(evidence.data.motions),
        explained=explanation.judgement.verdict == "explained",
        own=term.own or (worn and find_effect(term.effect).everyday),
        worn=worn,
        together=len(best.hypothesis.terms),
    )
    seen = SURE if features.motions > 1 else HALF
    others = dict.fromkeys(t.hypothesis.terms[-1].effect if t.hypothesis.terms else "" for t in group)
    cause = Cause(
        effect=term.effect,
        joints=joints_of(evidence.angles, term),
        stage=term.stage,
        probability=seen if by_chance else round(probability(features), 3),
        parameters=_estimates(options.known, term, theta, errors),
        indistinguishable_from=tuple(name for name in others if name and name != term.effect),
        closure_alone=_closure_alone(evidence, found.nominal, single, term, options.seed),
        specification=str(_named(evidence.angles, term).told(theta.tolist())),
        evidence={} if by_chance else {name: float(value) for name, value in asdict(features).items()},
    )
    if find_effect(term.effect).lacks(evidence.data.robot) is not None:
        cause = at_most(cause)
    if term.stage == "body":
        if explanation.judgement.rest.gap.ground_significant:
            cause = at_most(cause, MOST_BESIDE_GROUND_REST)
    elif index in explanation.judgement.bends:
        cause = less_sure(cause, explanation.judgement.bends[index])
    cause = doubted_for_left_out(held_back(cause), evidence.usual, explanation.unnamed, options)
    return _Weighed(cause, group, lead(scoring, best, without).mean)


def _rest_and_closed(scoring: Scoring, best: Trial, without: Trial, term: Term) -> tuple[float, float]:
    """Where a term does something: the mean square left, over the allowed one, and the share of the gap it closes."""
    rows = touched(scoring, best, without)
    if not rows.any():
        rows = scoring.decides
    allowed = scoring.allowed_square[rows]
    before, after = without.held_square[rows], best.held_square[rows]
    if term.stage == "body":  # features of different units, each against what it is allowed
        before, after, allowed = before / allowed, after / allowed, np.ones_like(allowed)
    over, left = (float(np.maximum(square - allowed, 0).sum()) for square in (before, after))
    return float(np.mean(after) / np.mean(allowed)), 1 - left / over if over > 0 else 0.0


def _estimates(known: Mapping[str, float], term: Term, theta: Floats, errors: Floats) -> dict[str, Estimate]:
    """Parameters of a term: fitted (p,) with their standard errors (p,), and those that were held."""
    of_one = term.open_of_one
    table, off = (np.reshape(row, (len(term.alike), len(of_one))) for row in (theta, errors))
    out = {p.name: _estimate(p, table[:, i], off[:, i], term) for i, p in enumerate(of_one)}
    effect, fixed = find_effect(term.effect), dict(term.fixed)
    given = dict(fixed_by(known, term.effect))
    for name, value in fixed.items():
        if isinstance(value, tuple):
            continue
        parameter = effect.parameter(name)
        held_at_neutral = not parameter.integer and value == parameter.neutral
        if not held_at_neutral or name in given:
            out[name] = Estimate(estimate=float(value), ci95=None, unit=parameter.unit, fixed=True)
    return out


def _estimate(parameter: Parameter, values: Floats, errors: Floats, term: Term) -> Estimate:
    """One parameter, with a value (V,) and a standard error (V,) for all joints, or for each that has its own."""
    unknown = "the data do not constrain it"
    ends = [
        interval(parameter, float(value), float(error)) for value, error in zip(values, errors, strict=True)
    ]
    if not term.own:
        reason = None if ends[0] is not None else unknown
        return Estimate(estimate=float(values[0]), ci95=ends[0], unit=parameter.unit, reason=reason)
    assert term.joints is not None
    return Estimate(
        estimate=float(values.mean()),
        ci95=None,
        unit=parameter.unit,
        reason="each joint has its own",
        by_joint=tuple(
            JointEstimate(joint=joint, estimate=float(value), ci95=span)
            for joint, value, span in zip(term.joints, values, ends, strict=True)
        ),
    )


def speed_closed(evidence: Evidence, nominal: Trial, trial: Trial, seed: int) -> float | None:
    """Closure of the forward speed; None without one."""
    found = speed_closure(evidence, nominal, forward_speeds(evidence, trial), seed)
    return None if found is None else found.closed


def _closure_alone(evidence: Evidence, nominal: Trial, single: Trial, term: Term, seed: int) -> float | None:
    if term.stage == "body":
        return speed_closed(evidence, nominal, single, seed)
    return angle_closure(evidence, nominal, single, seed).closed


def noise_cause(effect: Effect, noise: EncoderScatter, joints: int) -> Cause:
    """Noisy encoders, of a robot with so many joints, as a cause: seen in the scatter, not weighed against others."""
    size = effect.parameters[0]
    every = len(noise.joints) == joints
    spec = EffectSpec(effect.name, {size.name: noise.std_deg}, None if every else noise.joints)
    return Cause(
        effect=effect.name,
        joints=noise.joints,
        stage=effect.stage,
        probability=SURE,
        parameters={size.name: Estimate(estimate=noise.std_deg, ci95=noise.ci95, unit=size.unit)},
        closure_alone=None,
        specification=str(spec),
    )


def fit_entries(angles: AngleEvidence, scoring: Scoring, found: SearchResult) -> tuple[FitEntry, ...]:
    """Every single effect as it was fitted, and none."""
    use = scoring.decides
    samples = scoring.samples[use]
    return tuple(
        FitEntry(
            effects=fit.hypothesis.names,
            joints=joints_of(angles, fit.hypothesis),
            parameters=fit.theta.size,
            cost=round(float(-(scoring.score(fit.fitted_square)[use] * samples).sum()), 3),
            samples=int(samples.sum()),
        )
        for fit in found.fits
    )
