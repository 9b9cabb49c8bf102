"""How far a motion that nobody has run yet would tell explanations apart, given what is known of their parameters.

Each explanation is simulated at its fit and a standard deviation along each direction of its parameters. One of two is
taken to be true; the other may then turn its parameters, within what the data so far leave open, to come as close to it
as it can. What is left between the two counts, against the noise and the tolerances of the nominal numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats, Ints
from snakebot.clock import RATE_HZ
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.data import BLOCK_S
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.ground import Feature
from snakebot.diagnosis.evidence.ground_evidence import GroundEvidence
from snakebot.diagnosis.evidence.tolerance import StackedTimes, shift_limit_s
from snakebot.diagnosis.evidence.within_bounds import minimum_within
from snakebot.diagnosis.fit.hypothesis import Box, Hypothesis
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.proposal.menu import MenuMotion
from snakebot.diagnosis.proposal.motions import RAMP_S
from snakebot.diagnosis.sizes import BEYOND_CHANCE
from snakebot.effects.prediction import JointRun, joint_run
from snakebot.effects.servo_stage import ServoRun
from snakebot.effects.spec import EffectSpec
from snakebot.effects.stages import Stages, assemble
from snakebot.lifted import lifted


@dataclass(frozen=True, eq=False)
class Shown:
    """What an explanation predicts of a motion.

    Attributes:
        angle: (N, k) readings.
        ground: (3,) forward and lateral velocity and turn rate, where they are measured and not lifted.
        turns: the same for each direction of the parameters, less that at the fit.
    """

    angle: Floats
    ground: Floats | None
    turns: tuple[tuple[Floats, Floats | None], ...] = ()


class SimulatedMotion:
    """One motion, ready to be simulated under any explanation.

    ``over_ground``: as far as the session measures it, the motion over ground counts too.
    """

    def __init__(self, evidence: Evidence, option: MenuMotion, *, over_ground: bool) -> None:
        self.angles, self.ground = evidence.angles, evidence.ground
        self.floor_rad = evidence.floor.rad
        self.option = option
        self.robot = lifted(evidence.data.robot) if option.lifted else evidence.data.robot
        self.t_s = np.arange(int(option.duration_s * RATE_HZ)) / RATE_HZ
        self.command = option.motion.sampled(self.t_s)
        self.measures_ground = over_ground and self.ground is not None and not option.lifted
        self._room: tuple[Floats, Floats, Floats] | None = None

    @property
    def ground_room(self) -> Floats | None:
        """(3,) what each feature of the motion over ground may be off by; None where it is not measured."""
        if self.ground is None or not self.measures_ground:
            return None
        allowed = self.ground.allowed_square + self.ground.tolerance_square
        kinds = self.ground.features.kind
        return np.array(
            [np.sqrt(np.median(allowed[kinds == i])) if np.any(kinds == i) else np.inf for i in Feature]
        )

    @property
    def room(self) -> tuple[Floats, Floats, Floats]:
        """Times from the end of the ramp; rate (N, k) of the nominal reading; allowed squares (blocks, k)."""
        if self._room is None:
            nominal, _ = self.shown(())
            rate = StackedTimes.of([self.t_s], 0.0).rates(nominal)
            spread = self.robot.servo.time_constant_s * self.robot.tolerance.lag_shape * rate
            allowed = block_means(np.square(spread)) + np.square(self.floor_rad)
            self._room = (self.t_s, rate, allowed)
        return self._room

    def shown(self, specs: Sequence[EffectSpec]) -> tuple[Floats, Floats | None]:
        """Readings (N, k) and the motion over ground (3,), if it is measured."""
        stages, made = self._made(specs)
        return made.reading_rad, self._ground(stages, made.angle_rad) if self.measures_ground else None

    def _made(self, specs: Sequence[EffectSpec]) -> tuple[Stages, JointRun]:
        if self.option.lifted:
            specs = [s for s in specs if s.effect.stage != "body"]  # what the ground does to it is gone
        stages = assemble(self.robot, specs)
        return stages, joint_run(stages, ServoRun(self.t_s, stages.link(self.t_s, self.command)))

    def _ground(self, stages: Stages, angle: Floats) -> Floats | None:
        from snakebot.diagnosis.evidence.ground import Window, window_features
        from snakebot.physics import replayed_pose

        if stages.model is None:
            return None
        pose = replayed_pose(stages.model, self.t_s, angle)
        end_s = self.option.duration_s - RAMP_S
        window = Window(0, end_s / 3, end_s, False)
        features: Floats = window_features(self.t_s, pose, [window])[0]
        return features

    def at_fit(self, trial: Trial) -> Shown:
        return Shown(*self.shown(trial.specs))

    def with_turns(self, trial: Trial, fit: Shown) -> Shown:
        """The same with every direction in which the parameters may be off."""
        if any(term.own for term in trial.hypothesis.terms):
            return Shown(fit.angle, fit.ground, self._turns_of_many(trial))
        turns = []
        for step in directions(trial):
            theta, share = _moved(trial, step)
            if share == 0.0:
                continue
            angle, ground = self.shown(trial.hypothesis.specs(theta))
            over_ground = None if ground is None or fit.ground is None else (ground - fit.ground) / share
            turns.append(((angle - fit.angle) / share, over_ground))
        return Shown(fit.angle, fit.ground, tuple(turns))

    def _turns_of_many(self, trial: Trial) -> tuple[tuple[Floats, Floats | None], ...]:
        """The turns of an explanation in which joints have values of their own: sums of the changes by each parameter.

        A value of its own on every joint is changed on all of them at once, and a joint's change is taken for what its
        own value does: what it does to other joints by their loads is little beside that.
        """
        hypothesis, theta = trial.hypothesis, trial.theta
        lower, upper, _, _ = Box.of(hypothesis.parameters)
        steps = directions(trial)
        size = np.sqrt(np.sum(np.square(steps), axis=0)) if steps else np.zeros(theta.size)
        size = np.where(theta + size <= upper, size, -np.minimum(size, theta - lower))
        stages, base = self._made(trial.specs)
        angle = np.zeros((theta.size, *base.reading_rad.shape))
        ground = np.zeros((theta.size, 3)) if self.measures_ground else None
        start = self._ground(stages, base.angle_rad) if self.measures_ground else None
        touches = hypothesis.touches(base.reading_rad.shape[1])
        for together in hypothesis.side_by_side:
            moved = theta.copy()
            moved[together] += size[together]
            stages, made = self._made(hypothesis.specs(moved))
            for i in (i for i in together if size[i] != 0.0):
                mine = touches[i] if len(together) > 1 else np.ones_like(touches[i])
                angle[i][:, mine] = (made.reading_rad - base.reading_rad)[:, mine] / size[i]
                if ground is not None and start is not None:
                    true = base.angle_rad.copy()
                    true[:, mine] = made.angle_rad[:, mine]
                    other = self._ground(stages, true)
                    ground[i] = 0.0 if other is None else (other - start) / size[i]
        return tuple(
            (np.tensordot(step, angle, axes=1), None if start is None or ground is None else step @ ground)
            for step in steps
        )


def lead_of(
    motion: SimulatedMotion, a: Shown, b: Shown, joints: Sequence[int], *, over_ground: bool
) -> float:
    """Mean score by which the true one of two explanations would lead over all runs, this one with them.

    Args:
        joints: 0-based, that either of them acts on.
        over_ground: whether the measured joint angles leave them different ways over ground.
    """
    ground = _less(a.ground, b.ground) if over_ground else None
    one_way = _lead(motion, a.angle - b.angle, ground, b.turns, joints)
    return min(
        one_way, _lead(motion, b.angle - a.angle, None if ground is None else -ground, a.turns, joints)
    )


def times_noise(motion: SimulatedMotion, a: Shown, b: Shown, joints: Sequence[int]) -> float:
    """Largest ratio, over joints, of the rms difference at the fits to what is allowed."""
    _, _, allowed = motion.room
    ratio = block_means(np.square(a.angle - b.angle)).mean(axis=0) / allowed.mean(axis=0)
    return float(np.sqrt(ratio[list(joints)].max())) if joints else 0.0


def _less(a: Floats | None, b: Floats | None) -> Floats | None:
    return None if a is None or b is None else a - b


def _lead(
    motion: SimulatedMotion,
    apart: Floats,
    ground: Floats | None,
    turns: Sequence[tuple[Floats, Floats | None]],
    joints: Sequence[int],
) -> float:
    """The lead after the wrong one has turned its parameters by what chance may reach, and shifted in time."""
    angles, measured = motion.angles, motion.ground
    columns = list(joints)
    _, rate, allowed = motion.room
    best = 0.0
    if columns:
        share = _turned(motion, apart, [t for t, _ in turns], columns)
        left = apart[:, columns] - sum(
            (s * t[:, columns] for s, (t, _) in zip(share, turns, strict=True)), np.zeros(1)
        )
        left = left - rate[:, columns] * shift(angles, left, rate[:, columns], allowed[:, columns])
        gain = 0.5 * np.log1p(block_means(np.square(left)) / allowed[:, columns])
        held = int(np.isin(angles.blocks.joint, columns).sum())
        best = float(gain.sum() / (held + gain.size))
    if ground is not None and measured is not None:
        best = max(best, _ground_lead(measured, ground, [g for _, g in turns]))
    return best


def _turned(motion: SimulatedMotion, apart: Floats, turns: Sequence[Floats], columns: list[int]) -> Floats:
    """Standard deviations by which the parameters are turned: weighed by blocks, against leaving the fit so far."""
    if not turns:
        return np.zeros(0)
    _, _, allowed = motion.room
    # blocks with large residuals weigh less, as in the score; a block counts once, as its samples repeat each other
    size = np.bincount(block_numbers(apart.shape[0]))
    weight = 1 / np.sqrt(allowed + block_means(np.square(apart)))[:, columns] / np.sqrt(size)[:, None]
    by_sample = weight[block_numbers(apart.shape[0])]
    table = np.stack([(t[:, columns] * by_sample).ravel() for t in turns], axis=1)
    wanted = (apart[:, columns] * by_sample).ravel()
    return bounded(table, wanted)


def shift(angles: AngleEvidence, left: Floats, rate: Floats, allowed: Floats) -> Floats:
    """(k,) advance of each joint that takes most off, within the tolerance of the nominal lag and latency."""
    limit = shift_limit_s(angles.data.robot)
    weight = 1 / (allowed + block_means(np.square(left)))[block_numbers(left.shape[0])]
    power = (weight * rate * rate).sum(axis=0)
    found = np.divide((weight * left * rate).sum(axis=0), power, out=np.zeros_like(power), where=power > 0)
    return np.asarray(np.clip(found, -limit, limit))


def _ground_lead(ground: GroundEvidence, apart: Floats, turns: Sequence[Floats | None]) -> float:
    features = ground.features
    kinds = [i for i in Feature if np.any(features.kind == i)]
    allowed = [
        float(np.median((ground.allowed_square + ground.tolerance_square)[features.kind == i])) for i in kinds
    ]
    room = np.sqrt(allowed)
    left = apart[kinds]
    known = [t[kinds] for t in turns if t is not None]
    if not np.isfinite(left).all():
        return 0.0
    if known:
        table = np.nan_to_num(np.stack(known, axis=1))
        weight = 1 / np.sqrt(np.square(room) + np.square(left))
        left = left - table @ bounded(table * weight[:, None], left * weight)
    fresh = features.count / max(len(np.unique(features.run)), 1)  # values that one more run brings
    gain = float(np.mean(0.5 * np.log1p(np.square(left / room))))
    return gain * fresh / (features.count + fresh)


def bounded(table: Floats, wanted: Floats) -> Floats:
    """Turns (m,) in standard deviations that take most off ``wanted`` (N,) by ``table`` (N, m): one unit of cost for
    each that is turned by one, as the data so far want it where it is.
    """
    count = table.shape[1]
    if not count:
        return np.zeros(0)
    far, curvature = np.full(count, BEYOND_CHANCE), table.T @ table + np.eye(count)
    return minimum_within(curvature, table.T @ wanted, -far, far, np.zeros(count))


def block_numbers(samples: int) -> Ints:
    """(N,) block of each sample of a motion; the ramp up is one with what follows."""
    return (np.arange(samples) / (RATE_HZ * BLOCK_S)).astype(np.int64)


def block_means(values: Floats) -> Floats:
    """(blocks, k) means of (N, k)."""
    block = block_numbers(values.shape[0])
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    return np.asarray(np.add.reduceat(values, starts, axis=0) / np.bincount(block)[:, None])


def acts_over_ground(hypothesis: Hypothesis) -> bool:
    """Whether the same readings go another way over ground under it: the ground is predicted from them."""
    return any(term.stage in ("sensor", "body") for term in hypothesis.terms)


def acted_joints(hypothesis: Hypothesis, count: int) -> tuple[int, ...]:
    """0-based joints whose readings an explanation changes."""
    return tuple(joint - 1 for joint in hypothesis.joints(count))


def directions(trial: Trial) -> list[Floats]:
    """Steps (p,) of one standard deviation along each direction of the parameters, no wider than the prior."""
    parameters = trial.hypothesis.parameters
    if not parameters:
        return []
    prior = np.array(
        [
            p.spread * (abs(value) if p.scale == "log" else 1.0)
            for p, value in zip(parameters, trial.theta, strict=True)
        ]
    )
    covariance = np.asarray(trial.covariance, dtype=np.float64)
    sigma = (
        np.sqrt(np.diag(covariance)) if covariance.shape == (prior.size,) * 2 else np.full(prior.size, np.nan)
    )
    if np.isfinite(covariance).all() and np.all(sigma <= prior):
        values, vectors = np.linalg.eigh(covariance)
        return [np.sqrt(max(v, 0.0)) * vectors[:, i] for i, v in enumerate(values) if v > 0]
    sigma = np.where(np.isfinite(sigma), np.minimum(sigma, prior), prior)
    return [np.eye(prior.size)[i] * s for i, s in enumerate(sigma) if s > 0]


def _moved(trial: Trial, step: Floats) -> tuple[Floats, float]:
    """Parameters a step off the fit, and the share of it that the bounds allow; backwards where that is more."""
    lower, upper, _, _ = Box.of(trial.hypothesis.parameters)
    best, share = trial.theta, 0.0
    for sign in (1.0, -1.0):
        end = np.where(sign * step > 0, upper, lower)
        with np.errstate(divide="ignore", invalid="ignore"):
            room = (end - trial.theta) / (sign * step)
        allowed = min(1.0, float(np.nanmin(np.where(step == 0, np.inf, room))))
        if allowed > abs(share):
            best, share = trial.theta + sign * allowed * step, sign * allowed
    return best, share
