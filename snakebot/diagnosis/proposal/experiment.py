"""The next experiment: the safe motion after which the right explanation is most likely the only one left.

The menu holds gaits, and probes of the joints in question (``menu``). Every motion is simulated under every rival; the
most promising are looked at again with what the data leave open of the parameters (``separation``): a difference that
another value of a parameter would make as well separates nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from snakebot.diagnosis.evidence.data import Data
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import ALIKE
from snakebot.diagnosis.fit.hypothesis import Hypothesis
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.proposal.menu import MenuMotion, menu, motion_of
from snakebot.diagnosis.proposal.motions import DURATION_S, RAMP_S
from snakebot.diagnosis.proposal.separation import (
    Shown,
    SimulatedMotion,
    acted_joints,
    acts_over_ground,
    lead_of,
    times_noise,
)
from snakebot.diagnosis.result import NextExperiment
from snakebot.diagnosis.search.rounds import LOOKED_AT
from snakebot.diagnosis.sizes import LOWEST, NEXT_TO_NOTHING, SOME
from snakebot.runlog.matching.motion import CommandedMotion, same_motion

__all__ = ["Proposal", "motion_of", "propose"]


RivalPair = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Proposal:
    """What to do next, or why nothing helps."""

    experiment: NextExperiment | None
    channel: str | None  # a signal that would settle what no motion does


@dataclass(frozen=True, eq=False)
class _Look:
    """A motion with what it would show.

    Attributes:
        lead: of the right one over the other, for each pair of rivals.
        settled: probability of the right one after it, if one of the rivals is right and all were equally likely.
    """

    motion: SimulatedMotion
    fits: tuple[Shown, ...]
    lead: dict[RivalPair, float]
    settled: float


def propose(evidence: Evidence, rivals: Sequence[Trial], probability: float) -> Proposal:
    """Find the motion that separates ``rivals`` (the best first).

    Args:
        probability: that one of them is right.
    """
    rivals = rivals[:SOME]
    if len(rivals) < 2:
        return Proposal(None, None)
    acted = {j + 1 for r in rivals for j in acted_joints(r.hypothesis, evidence.data.joints)}
    loads = any(evidence.predictor.simulator.stages(r.specs).feels_load for r in rivals)
    options = menu(evidence.data.robot, sorted(acted), loads=loads)
    over_ground = any(acts_over_ground(r.hypothesis) for r in rivals)
    looks = [
        _first_look(SimulatedMotion(evidence, option, over_ground=over_ground), rivals) for option in options
    ]
    looks = [look for look in looks if not _has_been_run(evidence.data, look.motion)]
    looks.sort(key=_value, reverse=True)
    on_bench = evidence.data.robot.body is None
    channel = _channel_for(looks, rivals, on_bench) if looks else None
    closer = [_closer_look(look, rivals) for look in looks[:LOOKED_AT]]
    best = max(closer, key=_value, default=None)
    told = [] if best is None else [pair for pair, lead in best.lead.items() if lead >= ALIKE]
    if best is None or not told:
        return Proposal(None, channel or channel_told([r.hypothesis for r in rivals], on_bench))
    return Proposal(_described(evidence.data.joints, best, rivals, told, probability), channel)


def _value(look: _Look) -> tuple[float, float]:
    """To sort by: what will be known, less the trouble; among equals, the clearer.

    To lift the robot, or to wait long, for next to nothing is not worth the trouble.
    """
    option = look.motion.option
    trouble = NEXT_TO_NOTHING * (option.lifted + (option.duration_s > DURATION_S))
    return round(look.settled - trouble, 3), min(look.lead.values())


def _first_look(motion: SimulatedMotion, rivals: Sequence[Trial]) -> _Look:
    return _look(motion, rivals, tuple(motion.at_fit(trial) for trial in rivals))


def _closer_look(look: _Look, rivals: Sequence[Trial]) -> _Look:
    pairs = zip(rivals, look.fits, strict=True)
    return _look(look.motion, rivals, tuple(look.motion.with_turns(trial, fit) for trial, fit in pairs))


def _look(motion: SimulatedMotion, rivals: Sequence[Trial], shown: tuple[Shown, ...]) -> _Look:
    count = motion.robot.joints
    lead: dict[RivalPair, float] = {}
    for a, b in combinations(range(len(rivals)), 2):
        joints = {*acted_joints(rivals[a].hypothesis, count), *acted_joints(rivals[b].hypothesis, count)}
        over_ground = acts_over_ground(rivals[a].hypothesis) or acts_over_ground(rivals[b].hypothesis)
        lead[a, b] = lead_of(motion, shown[a], shown[b], sorted(joints), over_ground=over_ground)
    return _Look(motion, shown, lead, _settled(lead, len(rivals)))


def _settled(lead: dict[RivalPair, float], count: int) -> float:
    """A lead of ``ALIKE`` makes the wrong one e times less likely than the right one."""
    weight = np.eye(count)
    for (a, b), value in lead.items():
        weight[a, b] = weight[b, a] = np.exp(-value / ALIKE)
    return float(np.mean(1 / weight.sum(axis=1)))


def _has_been_run(data: Data, motion: SimulatedMotion) -> bool:
    """Whether a run of the session was commanded just this."""
    wanted = CommandedMotion(motion.t_s, motion.command, motion.option.lifted)
    return any(same_motion(wanted, run.commanded) is not None for run in data.runs)


def _described(
    joints: int, best: _Look, rivals: Sequence[Trial], told: Sequence[RivalPair], probability: float
) -> NextExperiment:
    option: MenuMotion = best.motion.option
    names = [" + ".join(dict.fromkeys(r.hypothesis.names)) for r in rivals]
    in_question = {name for pair in told for name in (names[pair[0]], names[pair[1]])}
    least = min(
        times_noise(best.motion, best.fits[a], best.fits[b], sorted(
            {*acted_joints(rivals[a].hypothesis, joints), *acted_joints(rivals[b].hypothesis, joints)}
        ))
        for a, b in told
    )  # fmt: skip
    where = (
        f"differ by {least:.2g} times the noise"
        if least >= 1
        else "differ over ground by more than the noise"
    )
    return NextExperiment(
        gait=option.shown_gait,
        probe=None if option.probe is None else str(option.probe),
        lifted=option.lifted,
        duration_s=option.duration_s,
        ramp_s=RAMP_S,
        motion=str(option),
        separates=tuple((names[a], names[b]) for a, b in told),
        expected_probability_after=round(min(probability * best.settled, 1 - LOWEST), 3),
        reason=f"the predictions of {' and '.join(sorted(in_question, key=names.index))} {where} there, and no "
        "values of their parameters that fit the runs so far make up for it",
        command=option.command,
    )


def _channel_for(looks: Sequence[_Look], rivals: Sequence[Trial], on_bench: bool) -> str | None:
    """What would settle those which no motion of the menu tells apart, even at their fits."""
    advice: list[str] = []
    hopeless: set[int] = set()
    for a, b in combinations(range(len(rivals)), 2):
        if any(look.lead[a, b] >= ALIKE for look in looks):
            continue
        plain, rich = sorted((rivals[a], rivals[b]), key=lambda r: r.theta.size)
        if plain.theta.size < rich.theta.size:
            names = (trial.hypothesis.terms[-1].effect for trial in (rich, plain))
            advice.append("{}, with the numbers found, moves like {} in every safe motion".format(*names))
        else:
            hopeless |= {a, b}
    if hopeless:
        advice.append(channel_told([rivals[i].hypothesis for i in sorted(hopeless)], on_bench))
    return "; ".join(advice) or None


def channel_told(rivals: Sequence[Hypothesis], on_bench: bool) -> str:
    """The signal that would settle what no motion does."""
    terms = [rival.terms[-1] for rival in rivals]
    stages = {term.stage for term in terms}
    names = ", ".join(dict.fromkeys(term.effect for term in terms))
    unable = f"no motion separates {names} on these channels"
    if "sensor" in stages and len(stages) > 1 and not on_bench:
        return f"{unable}; a pose of the robot (x_m, y_m, heading_rad) would"
    if stages == {"body"}:
        return f"{unable}; weighing the links or pulling the robot by a balance would"
    if on_bench and "sensor" in stages:
        return f"{unable}; a second look at the joint's angle (a protractor, a camera) would"
    if "link" in stages:
        return f"{unable}; the set-point that the board applied (applied_i_rad) would"
    return f"{unable}; the motors' current, or another load, would"
