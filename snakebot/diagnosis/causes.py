"""What speaks for each cause of the best explanation: its group, its probability, its parameters; and the ranking."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.closure import angle_closure, forward_speeds, speed_closure
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.groups import degenerate, indistinguishable
from snakebot.diagnosis.hypothesis import Hypothesis, Term
from snakebot.diagnosis.merit import lead, touched
from snakebot.diagnosis.noise import Noise
from snakebot.diagnosis.probability import ONE_MOTION_AT_MOST, Evidence, probability, shared
from snakebot.diagnosis.result import Cause, Estimate, FitEntry, RankingEntry
from snakebot.diagnosis.search import Found, without_term
from snakebot.diagnosis.trial import Trial, run_trial
from snakebot.diagnosis.uncertainty import interval
from snakebot.effects.registry import find_effect
from snakebot.effects.spec import EffectSpec

Floats = NDArray[np.float64]

RANKED = 12
SEEN = 0.9  # probability of a cause that is seen in the scatter, not weighed against others


def joints_of(context: Context, said: Term | Hypothesis) -> tuple[int, ...]:
    """1-based joints that an effect, or an explanation, acts on and that were read in some run; none for the body."""
    whole = Hypothesis((said,)) if isinstance(said, Term) else said
    read = {int(j) + 1 for j in np.unique(context.angle_blocks.joint)}
    return tuple(j for j in whole.joints(context.data.joints) if j in read)


def _named(context: Context, term: Term) -> Term:
    """A term as it is told: of joints that were never read nothing is claimed."""
    joints = joints_of(context, term)
    if (
        term.joints is not None
        or not find_effect(term.effect).per_joint
        or len(joints) == context.data.joints
    ):
        return term
    return replace(term, joints=joints)


@dataclass(frozen=True, eq=False)
class _Weighed:
    """One term of the best explanation with what speaks for it."""

    cause: Cause
    group: list[Trial]
    closes: float


def weigh_causes(
    context: Context, found: Found, best: Trial, explained: bool, errors: Floats
) -> tuple[list[Cause], list[Trial], tuple[RankingEntry, ...]]:
    """Causes in the order of what they close, the rivals still open (best first), and the ranking."""
    weighed: list[_Weighed] = []
    at = 0
    for index, term in enumerate(best.hypothesis.terms):
        count = len(term.open)
        rivals = found.rivals[index] if index < len(found.rivals) else ()
        group = indistinguishable(context, best, rivals)
        weighed.append(_weigh(context, found, best, index, group, rivals, errors[at : at + count], explained))
        at += count
    order = sorted(range(len(weighed)), key=lambda i: -weighed[i].closes)
    open_rivals = [best, *weighed[order[0]].group] if weighed and weighed[order[0]].group else []
    for i in order[1:]:
        if not open_rivals and weighed[i].group:
            open_rivals = [best, *weighed[i].group]
    ranking = _ranking(context, found, best, [weighed[i] for i in order])
    return [weighed[i].cause for i in order], open_rivals[:4], ranking


def _weigh(
    context: Context,
    found: Found,
    best: Trial,
    index: int,
    group: list[Trial],
    rivals: Sequence[Trial],
    errors: Floats,
    explained: bool,
) -> _Weighed:
    term = best.hypothesis.terms[index]
    by_chance = found.by_chance and term.effect == "command_loss"
    theta = best.hypothesis.split(best.theta)[index]
    alone = Hypothesis((term,))
    single = next((t for t in found.singles if t.hypothesis == alone), None) or run_trial(
        context, alone, [theta]
    )
    without = found.nominal
    if len(best.hypothesis.terms) > 1:
        without = found.without[index] if found.without else without_term(context, best, index)
    outside = [r for r in rivals if r not in group and not degenerate(best, r)]
    ahead = min((lead(context, best, r).mean for r in outside), default=lead(context, best, without).mean)
    rest, closed = _rest_and_closed(context, best, without, term)
    evidence = Evidence(
        lead=round(ahead, 5),
        rest=round(rest, 4),
        closed=round(closed, 4),
        rivals=len(group),
        motions=1 if found.untested else len(context.data.motions),
        explained=explained,
    )
    seen = SEEN if evidence.motions > 1 else ONE_MOTION_AT_MOST
    others = dict.fromkeys(t.hypothesis.terms[-1].effect if t.hypothesis.terms else "" for t in group)
    cause = Cause(
        effect=term.effect,
        joints=joints_of(context, term),
        stage=term.stage,
        probability=seen if by_chance else round(probability(evidence), 3),
        parameters=_estimates(context, term, theta, errors),
        indistinguishable_from=tuple(name for name in others if name and name != term.effect),
        closure_alone=_closure_alone(
            context, found.nominal, found.predicted if found.untested else single, term
        ),
        specification=str(_named(context, term).spec([float(v) for v in theta])),
        evidence={} if by_chance else {name: float(value) for name, value in asdict(evidence).items()},
    )
    return _Weighed(cause, group, lead(context, best, without).mean)


def _rest_and_closed(context: Context, best: Trial, without: Trial, term: Term) -> tuple[float, float]:
    """Where a term does something: the mean square left, over the allowed one, and the share of the gap it closes."""
    rows = touched(context, best, without)
    if not rows.any():
        rows = context.selects
    allowed = context.allowed_square[rows]
    before, after = without.held_square[rows], best.held_square[rows]
    if term.stage == "body":  # features of different units, each against what it is allowed
        before, after, allowed = before / allowed, after / allowed, np.ones_like(allowed)
    over, left = (float(np.maximum(square - allowed, 0).sum()) for square in (before, after))
    return float(np.mean(after) / np.mean(allowed)), 1 - left / over if over > 0 else 0.0


def _estimates(context: Context, term: Term, theta: Floats, errors: Floats) -> dict[str, Estimate]:
    """Parameters of a term: fitted (p,) with their standard errors (p,), and those that were held."""
    out: dict[str, Estimate] = {}
    for parameter, value, error in zip(term.open, theta, errors, strict=True):
        ends = interval(parameter, float(value), float(error))
        out[parameter.name] = Estimate(
            estimate=float(value),
            ci95=ends,
            unit=parameter.unit,
            reason=None if ends is not None else "the data do not constrain it",
        )
    effect, fixed = find_effect(term.effect), dict(term.fixed)
    for name, value in term.spec([float(v) for v in theta]).values.items():
        if name in out or isinstance(value, tuple):
            continue
        as_nominal = effect.name == "ground_friction" and value == 1.0 and name in fixed
        if not as_nominal or name in context.known:
            out[name] = Estimate(
                estimate=float(value), ci95=None, unit=effect.parameter(name).unit, fixed=True
            )
    return out


def speed_closed(context: Context, trial: Trial) -> float | None:
    """Closure of the forward speed; None without one."""
    found = speed_closure(context, forward_speeds(context, trial))
    return None if found is None else found.closed


def _closure_alone(context: Context, nominal: Trial, single: Trial, term: Term) -> float | None:
    if term.stage == "body":
        return speed_closed(context, single)
    return angle_closure(context, nominal, single).closed


def noise_cause(context: Context, noise: Noise) -> Cause:
    """Noisy encoders as a cause: seen in the scatter, not weighed against others."""
    spec = EffectSpec(
        "encoder_noise",
        {"std_deg": noise.std_deg},
        None if len(noise.joints) == context.data.joints else noise.joints,
    )
    return Cause(
        effect="encoder_noise",
        joints=noise.joints,
        stage="sensor",
        probability=SEEN,
        parameters={"std_deg": Estimate(estimate=noise.std_deg, ci95=noise.ci95, unit="deg")},
        closure_alone=None,
        specification=str(spec),
    )


def _ranking(
    context: Context, found: Found, best: Trial, weighed: Sequence[_Weighed]
) -> tuple[RankingEntry, ...]:
    """Explanations tried, best first. Probabilities: of the best, that all its causes are right, shared in
    its group.
    """
    top = float(np.prod([w.cause.probability for w in weighed])) if weighed else 0.0
    group = [best, *(t for w in weighed for t in w.group)]
    parts = shared(top, [t.score(context) for t in group]) if weighed else []
    entries: dict[Hypothesis, RankingEntry] = {}
    listed = [
        best,
        *(t for w in weighed for t in w.group),
        *found.singles,
        *(t for r in found.rivals for t in r),
        found.nominal,
    ]
    for trial in listed:
        if trial.hypothesis in entries:
            continue
        behind = context.gain(best.held_square, trial.held_square)
        own = next((p for t, p in zip(group, parts, strict=False) if t is trial), None)
        entries[trial.hypothesis] = RankingEntry(
            effects=trial.hypothesis.names,
            joints=joints_of(context, trial.hypothesis),
            held_out_score=round(trial.score(context), 5),
            delta=round(behind.mean, 5),
            delta_se=round(behind.se, 5) if np.isfinite(behind.se) else 0.0,
            probability=round(own, 3) if own is not None else 0.0,
        )
    rest = max(0.0, 1 - sum(e.probability for e in entries.values()))
    others = [h for h, e in entries.items() if e.probability == 0.0]
    if others and weighed:
        small = shared(0.5 * rest, [entries[h].held_out_score for h in others])
        for h, p in zip(others, small, strict=True):
            entries[h] = entries[h].model_copy(update={"probability": round(p, 3)})
    return tuple(sorted(entries.values(), key=lambda e: -e.held_out_score))[:RANKED]


def fit_entries(context: Context, found: Found) -> tuple[FitEntry, ...]:
    """Every single effect as it was fitted, and none."""
    use = context.selects
    samples = context.block_samples[use]
    return tuple(
        FitEntry(
            effects=fit.hypothesis.names,
            joints=joints_of(context, fit.hypothesis),
            parameters=fit.theta.size,
            cost=round(float(-(context.score(fit.fitted_square)[use] * samples).sum()), 3),
            samples=int(samples.sum()),
        )
        for fit in found.fits
    )
