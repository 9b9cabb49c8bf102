"""The verdict: explained, partly, no gap, or unexplained. It is decided here and nowhere else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from snakebot.diagnosis.evidence.gap import Gap, gap_of, hidden_gap
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.options import Options
from snakebot.diagnosis.result import Verdict
from snakebot.diagnosis.search.search import SearchResult
from snakebot.diagnosis.sizes import HALF
from snakebot.diagnosis.verdict.bend import bends_beside
from snakebot.diagnosis.verdict.joints import joints_of
from snakebot.diagnosis.verdict.noise import EncoderScatter, noise_effect, noisy_encoders
from snakebot.diagnosis.verdict.rest import Rest, brings_nearer, held_out_rest, rest_of, runs_with_gap


@dataclass(frozen=True, eq=False)
class VerdictFacts:
    """What the verdict is decided by.

    Attributes:
        gap: of the nominal robot.
        explanation: whether the search found one.
        rest: what it leaves over.
        noisy: whether the encoders scatter more than they should.
        in_scatter: the cause shows in how the readings scatter.
        in_scatter_alone: the cause shows in how the readings scatter, and the joint angles are right in the mean.
        floor_hides_gap: runs of the same motion are as far apart as they are off their prediction, or readings scatter
            as nothing that may be named explains.
        rest_held_out: what is left over in the runs that the user holds out, where it is a reason for a verdict.
    """

    gap: Gap
    explanation: bool
    rest: Rest
    noisy: bool
    in_scatter: bool
    in_scatter_alone: bool
    floor_hides_gap: bool
    rest_held_out: Rest | None


def decide(facts: VerdictFacts) -> Verdict:
    """The verdict."""
    if facts.in_scatter_alone:
        return "explained" if facts.explanation else "unexplained"
    if facts.rest_held_out is not None:
        return _partly(facts, facts.rest_held_out) if facts.gap.any else "unexplained"
    if not facts.gap.any:
        if facts.floor_hides_gap:
            return "unexplained"
        return "explained" if facts.noisy else "no_gap"
    if not facts.explanation or facts.rest.is_too_much:
        return _partly(facts, facts.rest)
    return "explained"


def _partly(facts: VerdictFacts, rest: Rest) -> Verdict:
    """The verdict where too much is left over: causes that close at least half of the gap explain it partly."""
    enough = rest.share <= HALF or facts.in_scatter  # what chance leaves over, no prediction closes
    return "partly" if facts.explanation and enough else "unexplained"


@dataclass(frozen=True, eq=False)
class Judgement:
    """The verdict, and what is told of the gap.

    Attributes:
        best: the explanation; the nominal robot if there is none.
        gap: of the nominal robot.
        rest: what ``best`` leaves over.
        runs: (indices) in which gap and rest are described.
        place: those runs as the beginning of a sentence; empty for all.
        bends: places of the terms of ``best`` that are straight lines of the angle beside a bend, and how large it is.
        noise: encoders that scatter more than they should.
        unheard: why the readings do not tell the motion over ground; None if they do.
        warnings: what a user should know beside the verdict.
    """

    verdict: Verdict
    best: Trial
    gap: Gap
    rest: Rest
    runs: tuple[int, ...]
    place: str
    bends: Mapping[int, float]
    noise: EncoderScatter | None
    unheard: str | None
    warnings: tuple[str, ...]


def judge(evidence: Evidence, found: SearchResult, options: Options) -> Judgement:
    """Weigh the gap, what the best explanation leaves of it, and the runs that the user holds out."""
    scoring = evidence.scoring
    warnings: list[str] = []
    gap = gap_of(scoring, found.nominal.held_square)
    # Where set-points are lost at random, servos jump from sample to sample: that scatter is no encoder's.
    scatter = None if found.seen_in_scatter else noisy_encoders(evidence.data, evidence.floor)
    noise = scatter if options.may_name(noise_effect().name) else None
    unnamed = {} if scatter is None or noise is not None else scatter.doubts
    doubts = {**unnamed, **evidence.floor.doubts}
    # the motion over ground is told from the readings: where they are not the motion, an effect of the body is a guess
    unheard = _why_no_ground(found, scatter) if not gap.significant.any() else None
    if unheard is not None and gap.ground_significant:
        gap = replace(gap, ground_significant=False)
        warnings.append(unheard)
    nothing = not gap.any and not found.seen_in_scatter
    best = found.nominal if nothing else found.best
    if found.untested and not nothing and not _shows_where_held_out(evidence, found.nominal):
        warnings.append(
            f"{best.hypothesis.in_words} shows in one motion only, so nothing tests it: record another like it"
        )
    held_out = held_out_rest(evidence, found.nominal, best)
    if held_out is not None and noise is not None and not held_out.gap.significant.any():
        held_out = None

    def rest_beside(trial: Trial) -> Rest:
        rest = rest_of(evidence, found.nominal, trial)
        return rest if unheard is None else replace(rest, gap=replace(rest.gap, ground_significant=False))

    bends = bends_beside(evidence, found.nominal, best)
    bent = {joint for at in bends for joint in joints_of(evidence.angles, best.hypothesis.terms[at])}
    rest = replace(rest_beside(best), bent=tuple(sorted(bent)))
    facts = VerdictFacts(
        gap=gap,
        explanation=bool(best.hypothesis.terms),
        rest=rest,
        noisy=noise is not None,
        in_scatter=found.seen_in_scatter,
        in_scatter_alone=found.seen_in_scatter and not gap.any,
        floor_hides_gap=bool(doubts),
        rest_held_out=held_out,
    )
    verdict = decide(facts)
    if facts.explanation and not found.seen_in_scatter and _is_no_cause(evidence, found, verdict, rest):
        best, bends = found.nominal, {}
        facts = replace(facts, explanation=False, rest=rest_beside(best))
        verdict = decide(facts)
    told = Judgement(
        verdict=verdict,
        best=best,
        gap=gap,
        rest=facts.rest,
        runs=tuple(range(len(evidence.data.runs))),
        place="",
        bends=bends,
        noise=noise,
        unheard=unheard,
        warnings=tuple(warnings),
    )
    if told.verdict not in ("partly", "unexplained"):
        return told
    if not gap.any and doubts and not facts.in_scatter_alone:
        hidden = hidden_gap(scoring, found.nominal.held_square, doubts)
        rest = replace(facts.rest, share=1.0, gap=hidden)
        return replace(told, gap=hidden, rest=rest, warnings=(*warnings, *doubts.values()))
    if held_out is None or decide(replace(facts, rest_held_out=None)) in ("partly", "unexplained"):
        return told
    return _in_held_out_runs(evidence, told, held_out)


def _is_no_cause(evidence: Evidence, found: SearchResult, verdict: Verdict, rest: Rest) -> bool:
    """Whether what was found takes nothing away on motions that it was not fitted to. ``partly`` has closed half."""
    left_open = verdict == "unexplained" and rest.is_too_much
    if verdict != "explained" and not left_open:
        return False
    if left_open and rest.share >= 1:
        return True
    return not found.untested and not brings_nearer(evidence, found.nominal, found.best, rest)


def _shows_where_held_out(evidence: Evidence, nominal: Trial) -> bool:
    """Whether there is a gap in the runs that the user holds out: then they test what one fitted motion alone shows."""
    rows = np.isin(evidence.scoring.run, evidence.split.held_out)
    return gap_of(evidence.scoring, nominal.held_square, rows).any


def _why_no_ground(found: SearchResult, scatter: EncoderScatter | None) -> str | None:
    """Why readings that are right in the mean do not tell the motion over ground, whatever may be named; None: they
    do.
    """
    if scatter is not None:
        why = "the encoders are too noisy"
    elif found.seen_in_scatter:
        why = "servos jump between samples too much, for set-points are lost,"
    else:
        return None
    return f"{why} to say anything about the motion over ground"


def _in_held_out_runs(evidence: Evidence, told: Judgement, rest: Rest) -> Judgement:
    """The judgement of an explanation that does not hold in the runs that the user holds out."""
    runs = runs_with_gap(evidence.scoring, evidence.split.shown, told.best)
    place = f"in {', '.join(evidence.data.runs[i].name for i in runs)}, held out: "
    if told.gap.any:
        warning = f"{place}{rest.share:.0%} of the gap is left, so it is not fully explained"
    else:
        warning = (
            f"{place}there is a gap, and none in the runs that may be fitted, so no cause can be named: fit such a "
            "motion too"
        )
    gap = told.gap if told.gap.any else rest.gap
    return replace(told, gap=gap, rest=rest, runs=runs, place=place, warnings=(*told.warnings, warning))
