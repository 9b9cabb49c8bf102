"""Before anything is recorded: how far some motions would tell effects apart that may be there or not.

Every effect is simulated on every motion at a size that shows, and a step along each of its parameters. One of two is
taken to be there; the other turns its parameters, the same on all motions, to come as close as it can. What is left
between the two counts as it does for a proposal (``separation``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.fit.hypothesis import Box, Hypothesis
from snakebot.diagnosis.fit.least_squares import FEWEST_STEPS
from snakebot.diagnosis.proposal.separation import SimulatedMotion, block_means, block_numbers, bounded, shift
from snakebot.diagnosis.search.groups import TOO_FAR
from snakebot.diagnosis.sizes import CLEAR, LITTLE, MUCH, NEXT_TO_NOTHING
from snakebot.effects.spec import EffectSpec

PRIOR_STEP = MUCH  # share of the prior's spread by which a parameter is stepped


@dataclass(frozen=True, eq=False)
class Foreseen:
    """An effect at some values, as some motions would show it.

    Attributes:
        angle: readings (N, k) a motion; ground (3,) a motion, where it is measured.
        turns: of each parameter, the same for one standard deviation of its prior.
    """

    hypothesis: Hypothesis
    theta: Floats
    angle: tuple[Floats, ...]
    ground: tuple[Floats | None, ...]
    turns: tuple[tuple[tuple[Floats, Floats | None], ...], ...] = ()

    def joined(self, other: Foreseen) -> Foreseen:
        """The same effect at the same values on the motions of both."""
        turns = tuple((*a, *b) for a, b in zip(self.turns, other.turns, strict=True))
        return Foreseen(
            self.hypothesis, self.theta, (*self.angle, *other.angle), (*self.ground, *other.ground), turns
        )

    @property
    def name(self) -> str:
        return self.hypothesis.terms[0].effect if self.hypothesis.terms else "nominal"

    @property
    def specs(self) -> tuple[EffectSpec, ...]:
        return self.hypothesis.specs(self.theta)


def foresee(
    motions: Sequence[SimulatedMotion], hypothesis: Hypothesis, theta: Floats, *, turns: bool = True
) -> Foreseen:
    """Simulate an effect on motions; without ``turns`` only at these values."""
    shown = [motion.shown(hypothesis.specs(theta)) for motion in motions]
    made = Foreseen(hypothesis, theta, tuple(a for a, _ in shown), tuple(g for _, g in shown))
    return replace(made, turns=_turns_of(motions, made)) if turns else made


def _turns_of(
    motions: Sequence[SimulatedMotion], made: Foreseen
) -> tuple[tuple[tuple[Floats, Floats | None], ...], ...]:
    """Of each open parameter, what the motions show of one standard deviation of its prior."""
    hypothesis, theta, out = made.hypothesis, made.theta, []
    box = Box.of(hypothesis.parameters)
    for i, parameter in enumerate(hypothesis.parameters):
        size = PRIOR_STEP * parameter.spread * (abs(theta[i]) if parameter.scale == "log" else 1.0)
        step = size if theta[i] + size <= box.upper[i] else -min(size, theta[i] - box.lower[i])
        if step == 0.0:
            continue
        moved = theta.copy()
        moved[i] += step
        rows = []
        for motion, angle, ground in zip(motions, made.angle, made.ground, strict=True):
            other, over = motion.shown(hypothesis.specs(moved))
            scale = size / (PRIOR_STEP * step)
            way = None if over is None or ground is None else (over - ground) * scale
            rows.append(((other - angle) * scale, way))
        out.append(tuple(rows))
    return tuple(out)


def lead_over(motions: Sequence[SimulatedMotion], truth: Foreseen, rival: Foreseen) -> tuple[float, Foreseen]:
    """Mean score by which the truth would lead over a rival that has come as close as it can, and that rival."""
    # In standard deviations of its prior. Where it is off, slopes are others.
    share = _turned(motions, truth, rival)
    lead = _left(motions, truth, rival, share)
    for _ in range(FEWEST_STEPS):
        far = bool(np.any(np.abs(share) > CLEAR))
        if not (far or lead < TOO_FAR) or not np.any(np.abs(share) > NEXT_TO_NOTHING):
            break
        near = foresee(motions, rival.hypothesis, _moved(rival, share))
        share = _turned(motions, truth, near)
        closer = _left(motions, truth, near, share)
        if closer > (1 - LITTLE) * lead:  # of little use
            return min(closer, lead), near if closer < lead else rival
        lead, rival = closer, near
    return lead, rival


def shows(motions: Sequence[SimulatedMotion], effect: Foreseen, nominal: Foreseen) -> float:
    """Mean score by which an effect that is there would lead over a robot without it."""
    return _left(motions, effect, nominal, np.zeros(0))


def _moved(rival: Foreseen, share: Floats) -> Floats:
    parameters = rival.hypothesis.parameters
    lower, upper, log, _ = Box.of(parameters)
    spread = np.array([p.spread for p in parameters])
    straight = (
        rival.theta
        + share * np.where([p.scale == "log" for p in parameters], np.abs(rival.theta), 1.0) * spread
    )
    curved = rival.theta * np.exp(np.clip(share * spread, -2.0, 2.0))
    return np.asarray(np.clip(np.where(log, curved, straight), lower, upper))


def _turned(motions: Sequence[SimulatedMotion], truth: Foreseen, rival: Foreseen) -> Floats:
    """Standard deviations by which the rival's parameters are turned to come nearest on all motions together."""
    count = len(rival.turns)
    if not count or count != len(rival.hypothesis.parameters):
        return np.zeros(count)
    tables, wanted = [np.zeros((0, count))], [np.zeros(0)]
    for i, motion in enumerate(motions):
        apart = truth.angle[i] - rival.angle[i]
        _, _, allowed = motion.room
        numbers = block_numbers(apart.shape[0])
        size = np.bincount(numbers)  # a block counts once, as its samples repeat each other
        weight = 1 / np.sqrt(allowed + block_means(np.square(apart))) / np.sqrt(size)[:, None]
        weight = weight[numbers]
        tables.append(np.stack([(rival.turns[k][i][0] * weight).ravel() for k in range(count)], axis=1))
        wanted.append((apart * weight).ravel())
        ground, other = truth.ground[i], rival.ground[i]
        ways = [rival.turns[k][i][1] for k in range(count)]
        known = [way for way in ways if way is not None]
        if (
            ground is not None
            and other is not None
            and len(known) == count
            and motion.ground_room is not None
        ):
            room = np.sqrt(np.square(motion.ground_room) + np.square(ground - other))
            tables.append(np.stack(known, axis=1) / room[:, None])
            wanted.append((ground - other) / room)
    return bounded(np.nan_to_num(np.concatenate(tables)), np.nan_to_num(np.concatenate(wanted)))


def _left(motions: Sequence[SimulatedMotion], truth: Foreseen, rival: Foreseen, share: Floats) -> float:
    """Mean score that is left on the channel, angles or ground, that tells more."""
    gains, over_ground = [], []
    for i, motion in enumerate(motions):
        left = truth.angle[i] - rival.angle[i]
        for k, s in enumerate(share):
            left = left - s * rival.turns[k][i][0]
        _, rate, allowed = motion.room
        left = left - rate * shift(motion.angles, left, rate, allowed)
        gains.append(0.5 * np.log1p(block_means(np.square(left)) / allowed))
        ground, other = truth.ground[i], rival.ground[i]
        if ground is not None and other is not None and motion.ground_room is not None:
            way = ground - other
            for k, s in enumerate(share):
                turn = rival.turns[k][i][1]
                way = way if turn is None else way - s * turn
            if np.isfinite(way).all():
                over_ground.append(0.5 * np.log1p(np.square(way / motion.ground_room)))
    # joints that neither acts on say nothing either way
    by_joint = np.concatenate(gains).mean(axis=0)
    told = float(by_joint.max())
    return max(told, float(np.mean(over_ground))) if over_ground else told
