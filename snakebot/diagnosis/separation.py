"""How far a motion that nobody has run yet would tell explanations apart, given what is known of their parameters.

Each explanation is simulated at its fit and a standard deviation along each direction of its parameters. One of two is
taken to be true; the other may then turn its parameters, within what the data so far leave open, to come as close to it
as it can. What is left between the two counts, against the noise and the tolerances of the nominal numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.allowance import rate_of
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.data import BLOCK_S
from snakebot.diagnosis.hypothesis import Hypothesis, bounds
from snakebot.diagnosis.menu import RAMP_S, Option
from snakebot.diagnosis.score import SHAPE_TOLERANCE
from snakebot.diagnosis.trial import Trial
from snakebot.effects.prediction import servo_stage
from snakebot.effects.spec import EffectSpec
from snakebot.effects.stages import Stages, assemble
from snakebot.lifted import lifted

Floats = NDArray[np.float64]

RATE_HZ = 100.0
FARTHEST = 3.0  # standard deviations that a parameter may be turned by


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


class Stage:
    """One motion, ready to be simulated under any explanation.

    ``over_ground``: as far as the session measures it, the motion over ground counts too.
    """

    def __init__(self, context: Context, option: Option, *, over_ground: bool) -> None:
        self.context = context
        self.option = option
        self.robot = lifted(context.data.robot) if option.lifted else context.data.robot
        self.t_s = np.arange(int(option.duration_s * RATE_HZ)) / RATE_HZ
        self.command = option.motion.sampled(self.t_s)
        self.measures_ground = over_ground and context.ground is not None and not option.lifted
        self._room: tuple[Floats, Floats, Floats] | None = None

    @property
    def room(self) -> tuple[Floats, Floats, Floats]:
        """Times from the end of the ramp; rate (N, k) of the nominal reading; allowed squares (blocks, k)."""
        if self._room is None:
            nominal, _ = self.shown(())
            rate = rate_of(nominal, self.t_s)
            spread = self.context.data.robot.servo.time_constant_s * SHAPE_TOLERANCE * rate
            allowed = block_means(np.square(spread)) + np.square(self.context.floor.rad)
            self._room = (self.t_s, rate, allowed)
        return self._room

    def shown(self, specs: Sequence[EffectSpec]) -> tuple[Floats, Floats | None]:
        """Readings (N, k) and the motion over ground (3,), if it is measured."""
        if self.option.lifted:
            specs = [s for s in specs if s.effect.stage != "body"]  # what the ground does to it is gone
        stages = assemble(self.robot, specs)
        track = stages.link(self.t_s, self.command)
        made = servo_stage(stages, track, self.t_s)
        reading, _ = stages.sensor(self.t_s, made.joint_angle_rad)
        return reading, self._ground(stages, made.joint_angle_rad) if self.measures_ground else None

    def _ground(self, stages: Stages, angle: Floats) -> Floats | None:
        from snakebot.diagnosis.ground import MAX_STEP_S, Window, window_features
        from snakebot.physics import replay

        if stages.model is None:
            return None
        path = replay(stages.model, self.t_s, angle, max_step_s=MAX_STEP_S)
        pose = np.column_stack([path.com_m, path.heading_rad])
        end_s = self.option.duration_s - RAMP_S
        window = Window(0, end_s / 3, end_s, False)
        return np.array(window_features(self.t_s, pose, window))

    def at_fit(self, trial: Trial) -> Shown:
        return Shown(*self.shown(trial.specs))

    def with_turns(self, trial: Trial, fit: Shown) -> Shown:
        """The same with every direction in which the parameters may be off."""
        turns = []
        for step in directions(trial):
            theta, share = _moved(trial, step)
            if share == 0.0:
                continue
            angle, ground = self.shown(trial.hypothesis.specs(theta))
            over_ground = None if ground is None or fit.ground is None else (ground - fit.ground) / share
            turns.append(((angle - fit.angle) / share, over_ground))
        return Shown(fit.angle, fit.ground, tuple(turns))


def lead_of(stage: Stage, a: Shown, b: Shown, joints: Sequence[int], *, over_ground: bool) -> float:
    """Mean score by which the true one of two explanations would lead over all runs, this one with them.

    Args:
        joints: 0-based, that either of them acts on.
        over_ground: whether the measured joint angles leave them different ways over ground.
    """
    ground = _less(a.ground, b.ground) if over_ground else None
    one_way = _lead(stage, a.angle - b.angle, ground, b.turns, joints)
    return min(one_way, _lead(stage, b.angle - a.angle, None if ground is None else -ground, a.turns, joints))


def times_noise(stage: Stage, a: Shown, b: Shown, joints: Sequence[int]) -> float:
    """Largest ratio, over joints, of the rms difference at the fits to what is allowed."""
    _, _, allowed = stage.room
    ratio = block_means(np.square(a.angle - b.angle)).mean(axis=0) / allowed.mean(axis=0)
    return float(np.sqrt(ratio[list(joints)].max())) if joints else 0.0


def _less(a: Floats | None, b: Floats | None) -> Floats | None:
    return None if a is None or b is None else a - b


def _lead(
    stage: Stage,
    apart: Floats,
    ground: Floats | None,
    turns: Sequence[tuple[Floats, Floats | None]],
    joints: Sequence[int],
) -> float:
    """The lead after the wrong one has turned its parameters by at most ``FARTHEST``, and shifted in time."""
    context = stage.context
    columns = list(joints)
    _, rate, allowed = stage.room
    best = 0.0
    if columns:
        share = _turned(stage, apart, [t for t, _ in turns], columns)
        left = apart[:, columns] - sum(
            (s * t[:, columns] for s, (t, _) in zip(share, turns, strict=True)), np.zeros(1)
        )
        left = left - rate[:, columns] * _shift(context, left, rate[:, columns], allowed[:, columns])
        gain = 0.5 * np.log1p(block_means(np.square(left)) / allowed[:, columns])
        held = int(np.isin(context.angle_blocks.joint, columns).sum())
        best = float(gain.sum() / (held + gain.size))
    if ground is not None and context.ground is not None:
        best = max(best, _ground_lead(context, ground, [g for _, g in turns]))
    return best


def _turned(stage: Stage, apart: Floats, turns: Sequence[Floats], columns: list[int]) -> Floats:
    """Standard deviations by which the parameters are turned: weighed by blocks, against leaving the fit so far."""
    if not turns:
        return np.zeros(0)
    _, _, allowed = stage.room
    # blocks that stand out weigh less, as in the score; a block counts once, as its samples repeat each other
    size = np.bincount(block_numbers(apart.shape[0]))
    weight = 1 / np.sqrt(allowed + block_means(np.square(apart)))[:, columns] / np.sqrt(size)[:, None]
    by_sample = weight[block_numbers(apart.shape[0])]
    table = np.stack([(t[:, columns] * by_sample).ravel() for t in turns], axis=1)
    wanted = (apart[:, columns] * by_sample).ravel()
    return _bounded(table, wanted)


def _shift(context: Context, left: Floats, rate: Floats, allowed: Floats) -> Floats:
    """(k,) advance of each joint that takes most off, within the tolerance of the nominal lag and latency."""
    from snakebot.diagnosis.allowance import shift_limit_s

    limit = shift_limit_s(context.data.robot.servo.time_constant_s)
    weight = 1 / (allowed + block_means(np.square(left)))[block_numbers(left.shape[0])]
    power = (weight * rate * rate).sum(axis=0)
    found = np.divide((weight * left * rate).sum(axis=0), power, out=np.zeros_like(power), where=power > 0)
    return np.asarray(np.clip(found, -limit, limit))


def _ground_lead(context: Context, apart: Floats, turns: Sequence[Floats | None]) -> float:
    ground = context.ground
    assert ground is not None
    kinds = [i for i in range(3) if np.any(ground.kind == i)]
    tolerance = np.square(context.ground_marks).sum(axis=1)
    allowed = [float(np.median((context.ground_allowed_square + tolerance)[ground.kind == i])) for i in kinds]
    room = np.sqrt(allowed)
    left = apart[kinds]
    known = [t[kinds] for t in turns if t is not None]
    if not np.isfinite(left).all():
        return 0.0
    if known:
        table = np.nan_to_num(np.stack(known, axis=1))
        weight = 1 / np.sqrt(np.square(room) + np.square(left))
        left = left - table @ _bounded(table * weight[:, None], left * weight)
    fresh = ground.count / max(len(np.unique(ground.run)), 1)  # values that one more run brings
    gain = float(np.mean(0.5 * np.log1p(np.square(left / room))))
    return gain * fresh / (ground.count + fresh)


def _bounded(table: Floats, wanted: Floats) -> Floats:
    """Turns (m,) in standard deviations that take most off ``wanted`` (N,) by ``table`` (N, m): one unit of cost for
    each that is turned by one, as the data so far want it where it is.
    """
    from scipy.optimize import lsq_linear

    if not table.shape[1]:
        return np.zeros(0)
    root = np.linalg.cholesky(table.T @ table + np.eye(table.shape[1]))
    goal = np.linalg.solve(root, table.T @ wanted)
    return np.asarray(lsq_linear(root.T, goal, (-FARTHEST, FARTHEST), method="bvls").x)


def block_numbers(samples: int) -> NDArray[np.int64]:
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
    lower, upper, _ = bounds(trial.hypothesis.parameters)
    best, share = trial.theta, 0.0
    for sign in (1.0, -1.0):
        end = np.where(sign * step > 0, upper, lower)
        with np.errstate(divide="ignore", invalid="ignore"):
            room = (end - trial.theta) / (sign * step)
        allowed = min(1.0, float(np.nanmin(np.where(step == 0, np.inf, room))))
        if allowed > abs(share):
            best, share = trial.theta + sign * allowed * step, sign * allowed
    return best, share
