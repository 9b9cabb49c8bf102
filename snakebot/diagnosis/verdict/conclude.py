"""Everything that is told beside the verdict: causes, closure, where the gap lies, and what the page draws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.gap import named_joints
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.predictor import Predictor
from snakebot.diagnosis.evidence.ticks import is_slow
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.trial import Trial, run_trial, trial_at
from snakebot.diagnosis.fit.uncertainty import standard_errors
from snakebot.diagnosis.options import Options, ProgressCallback
from snakebot.diagnosis.result import (
    BudgetEntry,
    Cause,
    Closure,
    ClosureStep,
    Details,
    Diagnosis,
    NextExperiment,
    RankingEntry,
    Regime,
    RunValues,
    StageShares,
    StatedNumber,
    Stretch,
    Unexplained,
    Where,
)
from snakebot.diagnosis.search.rounds import MOST_EFFECTS
from snakebot.diagnosis.search.search import SearchResult
from snakebot.diagnosis.sizes import HALF
from snakebot.diagnosis.verdict.budget import angle_budget, by_share, ground_budget, of_causes
from snakebot.diagnosis.verdict.causes import fit_entries, noise_cause, speed_closed, weigh_causes
from snakebot.diagnosis.verdict.closure import (
    NOT_HELD_OUT,
    Speeds,
    angle_closure,
    forward_speeds,
    ground_closure,
    joint_closures,
    speed_closure,
    speeds_by_run,
)
from snakebot.diagnosis.verdict.decision import Judgement
from snakebot.diagnosis.verdict.joints import joints_of
from snakebot.diagnosis.verdict.localise import shares
from snakebot.diagnosis.verdict.noise import noise_effect
from snakebot.diagnosis.verdict.probability import at_most
from snakebot.diagnosis.verdict.regime import regimes, sentence
from snakebot.diagnosis.verdict.rest import Rest
from snakebot.diagnosis.verdict.run_by_run import run_values
from snakebot.diagnosis.verdict.stated_numbers import stated_numbers
from snakebot.diagnosis.verdict.stretches import stretches
from snakebot.diagnosis.verdict.traces import traces
from snakebot.in_words import numbered
from snakebot.robot import robot_option

Steps = Sequence[tuple[Trial, Trial]]


@dataclass(frozen=True, eq=False)
class Conclusion:
    """A diagnosis but for the next experiment. ``open_rivals``: explanations that the data cannot tell apart, best
    first; none where there is no choice to be made. ``chosen_probability``: of the first of them.
    """

    judgement: Judgement
    where: Where
    causes: tuple[Cause, ...]
    chosen_probability: float
    open_rivals: tuple[Trial, ...]
    ranking: tuple[RankingEntry, ...]
    closure: Closure
    unexplained: Unexplained
    nominal: tuple[StatedNumber, ...]
    budget: tuple[BudgetEntry, ...]
    details: Details

    def diagnosis(
        self, experiment: NextExperiment | None, warnings: Sequence[str], timing_s: Mapping[str, float]
    ) -> Diagnosis:
        """The whole diagnosis."""
        return Diagnosis(
            verdict=self.judgement.verdict,
            where=self.where,
            causes=self.causes,
            ranking=self.ranking,
            closure=self.closure,
            unexplained=self.unexplained,
            next_experiment=experiment,
            warnings=tuple(dict.fromkeys(warnings)),
            nominal=self.nominal,
            budget=tuple(entry for entry in self.budget if entry.cause is not None),
            budget_rest=tuple(entry for entry in self.budget if entry.cause is None),
            details=self.details.model_copy(update={"timing_s": dict(timing_s)}),
        )


def conclude(
    evidence: Evidence,
    found: SearchResult,
    judgement: Judgement,
    unnamed: Sequence[str],
    options: Options,
    progress: ProgressCallback,
) -> Conclusion:
    """Causes with parameters and probabilities, closure, place of the gap; ``unnamed``: see ``Library``."""
    progress("parameters and their uncertainty", 0.82)
    errors = standard_errors(evidence, judgement.best, tolerances=not options.quick)
    progress("closure on held-out runs", 0.86)
    steps = _steps(evidence, found, judgement.best)
    speeds = forward_speeds(evidence, judgement.best)
    closure = _closure(evidence, found.nominal, judgement, steps, speeds, options.seed)
    of_terms = _budget(evidence, found.nominal, judgement, closure, options.seed)
    progress("how sure each cause is", 0.9)
    causes, rivals, ranking = weigh_causes(evidence, found, judgement, errors, of_terms, unnamed, options)
    if any(is_slow(run) for run in evidence.data.runs):
        causes, ranking = [at_most(c) for c in causes], tuple(at_most(r) for r in ranking)
    if judgement.verdict == "unexplained":  # a likelier cause would contradict it
        causes, ranking = [at_most(c, HALF) for c in causes], tuple(at_most(r, HALF) for r in ranking)
    if judgement.noise is not None:
        causes.append(noise_cause(noise_effect(), judgement.noise, evidence.data.joints))
    table = _regimes(evidence.angles, evidence.predictor, judgement)
    chosen = causes[0].probability if causes else 0.0
    told, budget = by_share(causes, of_causes(of_terms, _terms(evidence.angles, judgement.best, causes)))
    if evidence.split.scored:
        closure = closure.model_copy(update={"ground": ground_closure(budget)})
    return Conclusion(
        judgement=judgement,
        where=_where(
            judgement,
            shares(evidence, judgement.gap, found.nominal, steps),
            told,
            table,
            run_values(evidence, judgement.best),
            stretches(evidence, judgement.best, judgement.rest, judgement.runs),
        ),
        causes=told,
        chosen_probability=chosen,
        open_rivals=tuple(rivals),
        ranking=ranking,
        closure=closure,
        unexplained=_unexplained(judgement, table, budget),
        nominal=stated_numbers(evidence, judgement.best),
        budget=budget,
        details=_details(evidence, found, judgement, table, told, speeds, options),
    )


def _steps(evidence: Evidence, found: SearchResult, best: Trial) -> Steps:
    """The explanation as it grew, effect by effect, ending in ``best``."""
    if not best.hypothesis.terms:
        return []
    trials = [found.nominal]
    for count in range(1, len(best.hypothesis.terms)):
        part = Hypothesis(best.hypothesis.terms[:count])
        known = found.known(part)
        start = np.concatenate(best.hypothesis.split(best.theta)[:count])
        if (
            known is None and len(best.hypothesis.terms) > MOST_EFFECTS
        ):  # a share of many needs no fit of its own
            known = trial_at(evidence, part, start)
        trials.append(known or run_trial(evidence, part, [start]))
    trials.append(best)
    return list(pairwise(trials))


def _closure(
    evidence: Evidence, nominal: Trial, judgement: Judgement, steps: Steps, speeds: Speeds | None, seed: int
) -> Closure:
    unheard = judgement.unheard

    def step(after: Trial) -> ClosureStep:
        term, angle = after.hypothesis.terms[-1], angle_closure(evidence, nominal, after, seed)
        return ClosureStep(
            effect=term.effect,
            joints=joints_of(evidence.angles, term),
            joint_angle_closed=angle.closed,
            joint_angle_closed_beyond_tolerance=angle.closed_beyond_tolerance,
            forward_speed_closed=None if unheard else speed_closed(evidence, nominal, after, seed),
        )

    return Closure(
        held_out_runs=tuple(evidence.data.runs[i].name for i in evidence.split.scored),
        joint_angle=angle_closure(evidence, nominal, judgement.best, seed),
        forward_speed=speed_closure(evidence, nominal, speeds, seed, unheard=unheard),
        by_joint=joint_closures(evidence, nominal, judgement.best),
        steps=tuple(step(after) for _, after in steps),
    )


def _budget(
    evidence: Evidence, nominal: Trial, judgement: Judgement, closure: Closure, seed: int
) -> tuple[BudgetEntry, ...]:
    """Where there is a gap, what each term of the explanation carries of it."""
    best, entries = judgement.best, []
    if closure.joint_angle.closed is not None or closure.joint_angle.reason == NOT_HELD_OUT:
        entries += angle_budget(evidence, nominal, best, seed)
    if judgement.gap.ground_significant:
        entries += ground_budget(evidence, best, seed)
    return tuple(entries)


def _terms(angles: AngleEvidence, best: Trial, causes: Sequence[Cause]) -> list[int | None]:
    """For each cause its place in the hypothesis of ``best``; None where it has none."""
    return [
        next(
            (
                at
                for at, term in enumerate(best.hypothesis.terms)
                if term.effect == cause.effect and joints_of(angles, term) == cause.joints
            ),
            None,
        )
        for cause in causes
    ]


def _regimes(angles: AngleEvidence, predictor: Predictor, judgement: Judgement) -> tuple[Regime, ...]:
    joints = [int(j) for j in np.flatnonzero(judgement.gap.significant)]
    if not joints:
        return ()
    runs, nominal = judgement.runs, predictor.nominal
    loads = [predictor.simulator.load(i) for i in runs]
    known = [load for load in loads if load is not None]
    before, after = angles.residuals(nominal), angles.residuals(judgement.best.readings)
    return regimes(
        replace(angles.data, runs=tuple(angles.data.runs[i] for i in runs)),
        joints,
        [nominal[i] for i in runs],
        [before[i] for i in runs],
        [after[i] for i in runs],
        known if len(known) == len(runs) else None,
    )


def _where(
    judgement: Judgement,
    stage_shares: StageShares,
    causes: Sequence[Cause],
    table: Sequence[Regime],
    values: RunValues | None,
    times: tuple[Stretch, ...],
) -> Where:
    gap, explained = judgement.gap, judgement.verdict == "explained"
    stage = stage_shares.largest()
    if explained and causes:
        stage = causes[0].stage
    if judgement.verdict == "no_gap":
        stage = "none"
    angle_causes = [c for c in causes if c.stage != "body"]
    if explained and angle_causes:
        joints = tuple(sorted({j for c in angle_causes for j in c.joints}))
    else:
        joints = named_joints(gap)
    if stage == "body" and not angle_causes:
        joints = ()
    share = gap.joint_shares if gap.significant.any() else np.zeros(gap.significant.size)
    if not gap.any:
        regime = "no gap beyond noise and the tolerance of the nominal numbers"
    elif table:
        regime = judgement.place + sentence(table)
    else:
        regime = f"{judgement.place}joint angles are as predicted; the motion over ground is not"
    return Where(
        stage=stage,
        stage_shares=stage_shares,
        joints=joints,
        joint_shares=tuple(round(float(s), 4) for s in share),
        regime=regime,
        runs=() if values is None else values.unlike,
        values=values,
        times=times,
    )


def _unexplained(judgement: Judgement, table: Sequence[Regime], budget: Sequence[BudgetEntry]) -> Unexplained:
    """What is left: by the budget where there is one, so that no two shares are told; of the joint angles first."""
    share = judgement.rest.share if judgement.gap.any else 0.0
    rest = next((entry.share for entry in budget if entry.cause is None), share)
    return Unexplained(
        share=round(rest, 4),
        where=judgement.place + _rest_sentence(judgement.rest, table),
        significant=judgement.rest.significant,
    )


def _rest_sentence(rest: Rest, table: Sequence[Regime]) -> str:
    if not rest.significant:
        return "nothing beyond noise and the tolerance of the nominal numbers is left"
    parts = []
    joints = named_joints(rest.gap)
    if joints:
        parts.append(f"{numbered('joint', joints)}: {sentence(table, rest=True)}")
    if rest.bent:
        parts.append(
            f"{numbered('joint', rest.bent)}: the rest bends with the angle, and what is named is straight"
        )
    if rest.gap.ground_significant:
        parts.append("over ground, with the measured joint angles fed in")
    return "; ".join(parts) or sentence(table, rest=True)


def _details(
    evidence: Evidence,
    found: SearchResult,
    judgement: Judgement,
    table: tuple[Regime, ...],
    causes: Sequence[Cause],
    speeds: Speeds | None,
    options: Options,
) -> Details:
    return Details(
        floor_rad=tuple(float(f) for f in evidence.floor.rad),
        gap_rms_rad=_joint_rms(evidence.angles, found.nominal),
        rest_rms_rad=_joint_rms(evidence.angles, judgement.best),
        regimes=table,
        traces=traces(
            evidence,
            found.nominal,
            judgement.best,
            causes,
            _terms(evidence.angles, judgement.best, causes),
        ),
        speeds=() if speeds is None else speeds_by_run(evidence.data.runs, speeds),
        known=dict(options.known),
        seed=options.seed,
        fits=fit_entries(evidence.angles, evidence.scoring, found),
        slow_log=any(is_slow(run) for run in evidence.data.runs),
        robot_option=robot_option(evidence.data.robot),
    )


def _joint_rms(angles: AngleEvidence, trial: Trial) -> tuple[float, ...]:
    blocks = angles.blocks
    out = []
    for joint in range(angles.data.joints):
        rows = blocks.joint == joint
        size = blocks.samples[rows]
        square = trial.held_square[: blocks.count][rows]
        out.append(float(np.sqrt((square * size).sum() / size.sum())) if rows.any() else 0.0)
    return tuple(out)
