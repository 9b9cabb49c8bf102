"""``diagnose``: from a session to a verdict. The other files of this room are its steps, in the order called here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.causes import fit_entries, joints_of, noise_cause, speed_closed, weigh_causes
from snakebot.diagnosis.chance import earned, random_delay, unsteady
from snakebot.diagnosis.closure import angle_closure, forward_speeds, speed_closure
from snakebot.diagnosis.context import Context, make_context
from snakebot.diagnosis.data import link_is_clean, prepare
from snakebot.diagnosis.experiment import Proposal, propose
from snakebot.diagnosis.gap import Gap, gap_of, hidden_gap, named_joints
from snakebot.diagnosis.hypothesis import Hypothesis, Term
from snakebot.diagnosis.localise import shares
from snakebot.diagnosis.noise import noisy_encoders
from snakebot.diagnosis.regime import regimes, sentence
from snakebot.diagnosis.result import (
    Cause,
    Closure,
    ClosureStep,
    Details,
    Diagnosis,
    Regime,
    StageShares,
    Unexplained,
    Where,
)
from snakebot.diagnosis.sanity import check_data, check_session
from snakebot.diagnosis.search import MOST_EFFECTS, Found, search
from snakebot.diagnosis.slow_logs import less_sure, less_sure_ranking, slow_warning, with_ticks
from snakebot.diagnosis.ticks import is_slow
from snakebot.diagnosis.traces import traces
from snakebot.diagnosis.trial import Trial, run_trial
from snakebot.diagnosis.uncertainty import interval, standard_errors
from snakebot.diagnosis.verdict import Rest, decide, held_out_rest, rest_of, runs_with_gap
from snakebot.effects.registry import effects, find_effect
from snakebot.errors import BadInputError
from snakebot.runlog import Session

Floats = NDArray[np.float64]
Progress = Callable[[str, float], None]

LOOKS_LIKE_DELAY = frozenset({"command_delay", "servo_lag", "second_order", "command_loss"})


def _quiet(text: str, share: float) -> None:
    """No progress is shown."""


def diagnose(
    session: Session,
    *,
    exclude: Sequence[str] = (),
    only: Sequence[str] = (),
    known: Mapping[str, float] | None = None,
    seed: int = 0,
    quick: bool = False,
    progress: Progress = _quiet,
) -> Diagnosis:
    """Find out where robot and simulation part, which effect causes it, and how far the gap shrinks with it.

    Args:
        session: runs of one robot with the nominal robot description.
        exclude, only: effects that may not, or alone may, be named.
        known: parameters that the user has measured, ``{"limit_rad_s": 1.6}`` or ``{"rate_limit.limit_rad_s": 1.6}``;
            they are not fitted.
        seed: of the bootstrap and of drawn noise. The same session and seed give the same answer.
        quick: at most two effects, no proposal, intervals from scatter alone.
        progress: called with what is being done and the share that is done.

    Raises:
        BadInputError: the session cannot be diagnosed, or an option names no effect or parameter.
    """
    started = perf_counter()
    known = dict(known or {})
    _check_options(exclude, only, known)
    progress("reading the session", 0.0)
    warnings = [*session.warnings, *check_session(session)]
    data = prepare(session)
    warnings += check_data(data)
    context = make_context(data, known, seed)
    if not context.selects[: context.angle_blocks.count].any():
        which = "run that may be fitted" if any(run.hold_out for run in data.runs) else "run"
        raise BadInputError(f"no sample of any {which} has both a command and a reading: nothing to compare")
    guessed = with_ticks(context)
    if guessed is not None:
        context = make_context(guessed, known, seed)
    if any(is_slow(run) for run in context.data.runs):
        warnings.append(slow_warning(context.data, guessed is not None))
    warnings += context.floor.warnings
    timing = {"prepare": perf_counter() - started}
    mark = perf_counter()
    found = search(
        context, only=only, exclude=exclude, quick=quick, progress=lambda t, s: progress(t, 0.05 + 0.7 * s)
    )
    found = _by_chance(context, found, only, exclude, quick)
    timing["search"] = perf_counter() - mark
    mark = perf_counter()
    progress("what is left over", 0.78)
    result = _conclude(context, found, warnings, only, exclude, quick, progress)
    timing["conclude"] = perf_counter() - mark
    timing["total"] = perf_counter() - started
    progress("done", 1.0)
    assert result.details is not None
    return result.model_copy(update={"details": result.details.model_copy(update={"timing_s": timing})})


def _check_options(exclude: Sequence[str], only: Sequence[str], known: Mapping[str, float]) -> None:
    for name in (*exclude, *only):
        find_effect(name)
    if only and not set(only) - set(exclude):
        raise BadInputError("--only and --exclude leave no effect to try")
    for key in known:
        owner, dot, name = key.rpartition(".")
        owners = [find_effect(owner)] if dot else list(effects().values())
        if not any(p.name == name for effect in owners for p in effect.parameters):
            raise BadInputError(f"--known {key}: no effect has a parameter of that name")
        for effect in owners:
            for parameter in effect.parameters:
                if parameter.name == name and dot and not parameter.contains(known[key]):
                    raise BadInputError(
                        f"--known {key}={known[key]:g}: out of bounds ({parameter.bounds_text})"
                    )


def _by_chance(
    context: Context, found: Found, only: Sequence[str], exclude: Sequence[str], quick: bool
) -> Found:
    """Lost set-points in the place of a delay, where what is left over shows them and they earn their place.

    They shake the body between the samples, which no replay of samples sees: an effect of the body goes with the delay.
    """
    name = "command_loss"
    if link_is_clean(context.data):
        return found
    if not gap_of(context, found.nominal).significant.any() and not unsteady(context):
        return found
    if not random_delay(context, found.best).evident:
        return found
    if not _may_be(name, only, exclude):
        return found if found.best.hypothesis.terms else replace(found, by_chance=True)
    terms = found.best.hypothesis.terms
    stays = [i for i, t in enumerate(terms) if t.effect not in LOOKS_LIKE_DELAY and t.stage != "body"]
    if len(stays) == MOST_EFFECTS:
        return found
    parts = found.best.hypothesis.split(found.best.theta)
    kept = Hypothesis(tuple(terms[i] for i in stays))
    theta = np.concatenate([np.zeros(0), *(parts[i] for i in stays)])
    starts = [np.append(theta, p) for p in (0.1, 0.3, 0.6)]
    loss = run_trial(context, kept.plus(Term(name, None)), starts)
    base = run_trial(context, kept, [theta]) if stays else found.nominal
    error = standard_errors(context, loss, tolerances=not quick)[-1]
    ends = interval(loss.hypothesis.parameters[-1], float(loss.theta[-1]), float(error))
    if ends is None or ends[0] <= 0 or not earned(context, loss, base):
        return found
    rivals = tuple(t for t in found.singles if t.hypothesis.names != (name,))
    return replace(
        found,
        best=loss,
        predicted=loss,
        singles=found.singles if stays else (loss, *rivals),
        rivals=(*(found.rivals[i] for i in stays if i < len(found.rivals)), ()),
        path=(found.nominal, base, loss) if stays else (found.nominal, loss),
        without=(),
        untested=False,
        by_chance=True,
    )


def _conclude(
    context: Context,
    found: Found,
    warnings: list[str],
    only: Sequence[str],
    exclude: Sequence[str],
    quick: bool,
    progress: Progress,
) -> Diagnosis:
    nominal, best, predicted = found.nominal, found.best, found.predicted
    gap = gap_of(context, nominal)
    noise = noisy_encoders(context) if _may_be("encoder_noise", only, exclude) else None
    if noise is not None and gap.ground_significant and not gap.significant.any():
        # the motion over ground is told from the readings, and these shake: an effect of the body would be a guess
        gap = replace(gap, ground_significant=False)
        warnings.append("the encoders are too noisy to say anything about the motion over ground")
    rest = rest_of(context, nominal, best)
    if not gap.any and not found.by_chance:
        best = predicted = nominal
        rest = rest_of(context, nominal, nominal)
    by_chance = found.by_chance and not gap.significant.any()
    untested = found.untested and bool(best.hypothesis.terms)
    if untested:
        warnings.append(
            f"{best.hypothesis} shows in one motion only, so nothing tests it: record another motion like it"
        )
    verdict = decide(gap, best, rest, noise is not None)
    if by_chance:
        verdict = "explained" if best.hypothesis.terms else "unexplained"
    if not gap.any and not by_chance and context.floor.doubts:
        verdict, gap = "unexplained", hidden_gap(context, nominal)
        rest = replace(rest, share=1.0, gap=gap)
        warnings += context.floor.doubts.values()
    place, runs = "", tuple(range(len(context.data.runs)))
    apart = None if by_chance or verdict == "unexplained" else held_out_rest(context, nominal, best)
    if apart is not None and (noise is None or apart.gap.significant.any()):
        verdict, rest = "unexplained", apart
        runs = runs_with_gap(context, best)
        place = f"in {', '.join(context.data.runs[i].name for i in runs)}, held out: "
        if gap.any:
            warnings.append(f"{place}{rest.share:.0%} of the gap is left, so it is not explained")
        else:
            gap = apart.gap
            warnings.append(
                f"{place}there is a gap, and none in the runs that may be fitted, so no cause can be named: fit such a "
                "motion too"
            )
    progress("parameters and their uncertainty", 0.82)
    errors = standard_errors(context, best, tolerances=not quick)
    causes, open_rivals, ranking = weigh_causes(context, found, best, verdict == "explained", errors)
    if any(is_slow(run) for run in context.data.runs):
        causes, ranking = less_sure(causes), less_sure_ranking(ranking)
    if noise is not None:
        causes.append(noise_cause(context, noise))
    progress("closure on held-out runs", 0.9)
    speeds = forward_speeds(context, predicted)
    steps = _steps(context, found, best)
    closure = Closure(
        held_out_runs=tuple(context.data.runs[i].name for i in context.scored_runs),
        joint_angle=angle_closure(context, nominal, predicted),
        forward_speed=speed_closure(context, speeds),
        steps=tuple(
            ClosureStep(
                effect=after.hypothesis.terms[-1].effect,
                joints=joints_of(context, after.hypothesis.terms[-1]),
                joint_angle_closed=angle_closure(context, nominal, after).closed,
                forward_speed_closed=speed_closed(context, after),
            )
            for after in (predicted if after is best else after for _, after in steps)
        ),
    )
    stage_shares = shares(context, gap, nominal, steps)
    table = _regimes(context, gap, best, runs)
    proposal = Proposal(None, None)
    if not quick and open_rivals:
        progress("the next experiment", 0.94)
        proposal = propose(context, open_rivals, causes[0].probability if causes else 0.0)
    if proposal.channel is not None:
        warnings.append(proposal.channel)
    if not context.floor.known:
        what = "no repeat tells the noise" if context.floor.warnings else "no run is repeated"
        warnings.append(f"{what}: the noise floor is that of the encoders alone; repeat one motion")
    return Diagnosis(
        verdict=verdict,
        where=_where(context, gap, stage_shares, causes, verdict, table, place),
        causes=tuple(causes),
        ranking=ranking,
        closure=closure,
        unexplained=Unexplained(
            share=round(rest.share, 4) if gap.any else 0.0,
            where=place + _rest_sentence(rest, table),
            significant=rest.significant,
        ),
        next_experiment=proposal.experiment,
        warnings=tuple(dict.fromkeys(warnings)),
        details=Details(
            floor_rad=tuple(float(f) for f in context.floor.rad),
            gap_rms_rad=_joint_rms(context, nominal),
            rest_rms_rad=_joint_rms(context, predicted),
            regimes=table,
            traces=traces(context, nominal, predicted),
            known=dict(context.known),
            seed=context.seed,
            fits=fit_entries(context, found),
        ),
    )


def _may_be(name: str, only: Sequence[str], exclude: Sequence[str]) -> bool:
    return name not in exclude and (not only or name in only)


def _steps(context: Context, found: Found, best: Trial) -> list[tuple[Trial, Trial]]:
    """The explanation as it grew, effect by effect, ending in ``best``."""
    if not best.hypothesis.terms:
        return []
    trials = [found.nominal]
    for count in range(1, len(best.hypothesis.terms)):
        part = Hypothesis(best.hypothesis.terms[:count])
        known = next((t for t in (*found.path, *found.singles) if t.hypothesis == part), None)
        start = np.concatenate(best.hypothesis.split(best.theta)[:count])
        trials.append(known or run_trial(context, part, [start]))
    trials.append(best)
    return list(pairwise(trials))


def _joint_rms(context: Context, trial: Trial) -> tuple[float, ...]:
    blocks = context.angle_blocks
    out = []
    for joint in range(context.data.joints):
        rows = blocks.joint == joint
        size = blocks.samples[rows]
        square = trial.held_square[: blocks.count][rows]
        out.append(float(np.sqrt((square * size).sum() / size.sum())) if rows.any() else 0.0)
    return tuple(out)


def _regimes(context: Context, gap: Gap, best: Trial, runs: Sequence[int]) -> tuple[Regime, ...]:
    joints = [j for j in range(context.data.joints) if gap.significant[j]]
    if not joints:
        return ()
    known = [load for i in runs if (load := context.simulator.load(i)) is not None]
    before, after = context.residuals(context.nominal), context.residuals(best.readings)
    return regimes(
        replace(context.data, runs=tuple(context.data.runs[i] for i in runs)),
        joints,
        [context.nominal[i] for i in runs],
        [before[i] for i in runs],
        [after[i] for i in runs],
        known if len(known) == len(runs) else None,
    )


def _where(
    context: Context,
    gap: Gap,
    stage_shares: StageShares,
    causes: Sequence[Cause],
    verdict: str,
    table: Sequence[Regime],
    place: str,
) -> Where:
    stage = stage_shares.largest()
    if verdict == "explained" and causes:
        stage = causes[0].stage
    if verdict == "no_gap":
        stage = "none"
    angle_causes = [c for c in causes if c.stage != "body"]
    if verdict == "explained" and angle_causes:
        joints = tuple(sorted({j for c in angle_causes for j in c.joints}))
    else:
        joints = named_joints(gap)
    if stage == "body" and not angle_causes:
        joints = ()
    share = gap.joint_shares if gap.significant.any() else np.zeros(context.data.joints)
    if not gap.any:
        regime = "no gap beyond noise and the tolerance of the nominal numbers"
    elif table:
        regime = place + sentence(table)
    else:
        regime = f"{place}joint angles are as predicted; the motion over ground is not"
    return Where(
        stage=stage,
        stage_shares=stage_shares,
        joints=joints,
        joint_shares=tuple(round(float(s), 4) for s in share),
        regime=regime,
    )


def _rest_sentence(rest: Rest, table: Sequence[Regime]) -> str:
    if not rest.significant:
        return "nothing beyond noise and the tolerance of the nominal numbers is left"
    parts = []
    joints = named_joints(rest.gap)
    if joints:
        which = "joint" if len(joints) == 1 else "joints"
        parts.append(f"{which} {', '.join(map(str, joints))}: {sentence(table, rest=True)}")
    if rest.gap.ground_significant:
        parts.append("over ground, with the measured joint angles fed in")
    return "; ".join(parts) or sentence(table, rest=True)
