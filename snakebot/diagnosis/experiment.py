"""The next experiment: of the motions that are safe, the one in which the explanations still open differ most.

Each rival is simulated on each motion, at its fit and at draws from the fit's uncertainty: a difference that
another value of a parameter would make as well separates nothing. Small slow gaits are probes (dead band, play,
friction), fast and wide ones tell lags, limits and delays apart, and a pose tells the joint from its reading.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import degrees, radians

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis.context import Context
from snakebot.diagnosis.data import BLOCK_S
from snakebot.diagnosis.groups import ALIKE
from snakebot.diagnosis.result import GaitDegrees, NextExperiment
from snakebot.diagnosis.trial import Trial
from snakebot.effects.prediction import servo_stage
from snakebot.effects.spec import EffectSpec
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, check_motion

Floats = NDArray[np.float64]

RATE_HZ = 100.0
DURATION_S = 10.0
RAMP_S = 2.0
LOOKED_AT = 4  # motions of the menu that are tried with the parameters' uncertainty
DRAWS = 2  # of each rival's parameters, beside the fit itself
MENU = tuple(
    (alpha, beta, omega, offset)
    for alpha, omega in ((2, 0.5), (2, 3.0), (6, 0.5), (6, 3.0), (15, 1.0), (15, 5.0), (30, 0.5), (30, 4.0),
                         (50, 1.0), (50, 3.0), (66, 2.0))
    for beta, offset in ((80, 0), (80, 15))
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Proposal:
    """What to do next, or why nothing helps."""

    experiment: NextExperiment | None
    channel: str | None  # a signal that would settle it where no motion does


def propose(context: Context, rivals: Sequence[Trial], probability: float) -> Proposal:
    """Find the motion that separates ``rivals`` (the best first).

    Args:
        probability: that one of them is right.
    """
    if len(rivals) < 2:
        return Proposal(None, None)
    names = tuple(tuple(dict.fromkeys(r.hypothesis.names)) for r in rivals)
    rng = np.random.default_rng(context.seed)
    variants = [_variants(trial, rng) for trial in rivals]
    menu = []
    for alpha, beta, omega, offset in MENU:
        gait = Gait(radians(alpha), radians(beta), omega, radians(offset))
        motion = GaitMotion(gait, context.data.joints, DURATION_S, RAMP_S)
        try:
            check_motion(motion, context.data.robot)
        except BadInputError:
            continue
        menu.append((_separation(context, motion, [v[:1] for v in variants]), gait, motion))
    menu.sort(key=lambda entry: -entry[0])
    best: tuple[float, Gait] | None = None
    for promise, gait, motion in menu[:LOOKED_AT]:
        apart = promise if promise < ALIKE else _separation(context, motion, variants)
        if best is None or apart > best[0] + 1e-9:
            best = (apart, gait)
    if best is None or best[0] < ALIKE:
        return Proposal(None, _channel(rivals, context.data.robot.body is None))
    apart, gait = best
    settled = 1 - 0.5 * float(np.exp(-apart / 0.1))
    shown = GaitDegrees(
        alpha_deg=round(degrees(gait.alpha_rad), 6),
        beta_deg=round(degrees(gait.beta_rad), 6),
        omega_rad_s=gait.omega_rad_s,
        offset_deg=round(degrees(gait.offset_rad), 6),
    )
    label = " and ".join(" + ".join(n) for n in names)
    kind = "a small, slow motion" if shown.alpha_deg <= 6 else "this gait"
    return Proposal(
        NextExperiment(
            gait=shown,
            motion=f"alpha {shown.alpha_deg:g} deg, beta {shown.beta_deg:g} deg, omega {shown.omega_rad_s:g} rad/s, "
            f"offset {shown.offset_deg:g} deg, {DURATION_S:g} s",
            separates=(tuple(" + ".join(n) for n in names),),
            expected_probability_after=round(min(probability * settled, 0.99), 3),
            reason=f"in {kind} the predictions of {label} differ by {_times(apart)} the noise, "
            "whatever their parameters",
            command=_command(shown),
        ),
        None,
    )


def _times(apart: float) -> str:
    return f"{np.sqrt(np.expm1(2 * apart)):.2g} times"


def _command(gait: GaitDegrees) -> str:
    offset = f" --offset {gait.offset_deg:g}" if gait.offset_deg else ""
    return (
        f"snakebot run --alpha {gait.alpha_deg:g} --beta {gait.beta_deg:g} --omega {gait.omega_rad_s:g}{offset} "
        f"--duration {DURATION_S:g} --ramp {RAMP_S:g}"
    )


def _variants(trial: Trial, rng: np.random.Generator) -> list[tuple[EffectSpec, ...]]:
    """The explanation at its fit and at draws from its uncertainty."""
    out = [trial.specs]
    covariance = np.nan_to_num(trial.covariance, nan=0.0, posinf=0.0)
    if trial.theta.size and np.any(covariance):
        root = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        draws = rng.normal(size=(DRAWS, root.size))
        out.extend(trial.hypothesis.specs(trial.theta + root * draw) for draw in draws)
    return out


def _separation(
    context: Context, motion: GaitMotion, variants: Sequence[Sequence[tuple[EffectSpec, ...]]]
) -> float:
    """Expected score by which the right one of the nearest two rivals would lead, over their parameters."""
    t = np.arange(int(DURATION_S * RATE_HZ)) / RATE_HZ
    command = motion.sampled(t)
    later = t > RAMP_S  # the start depends on where the joints stood
    readings = [[_reading(context, t, command, specs) for specs in group] for group in variants]
    allowed = np.square(context.floor.rad)
    tolerance = _tolerance(context, t, command)
    blocks = ((t[later] - t[later][0]) / BLOCK_S).astype(np.int64)
    size = np.bincount(blocks)
    smallest = np.inf
    for a, b in combinations(range(len(readings)), 2):
        for x in readings[a]:
            for y in readings[b]:
                apart = 0.0
                for joint in range(command.shape[1]):
                    square = (
                        np.bincount(blocks, weights=np.square(x[0][later, joint] - y[0][later, joint])) / size
                    )
                    room = (
                        np.bincount(blocks, weights=np.square(tolerance[later, joint])) / size
                        + allowed[joint]
                    )
                    apart = max(apart, float(np.mean(0.5 * np.log1p(square / room))))
                apart = max(apart, _ground_apart(context, x[1], y[1]))
                smallest = min(smallest, apart)
    return smallest


def _reading(
    context: Context, t: Floats, command: Floats, specs: Sequence[EffectSpec]
) -> tuple[Floats, Floats | None]:
    """Readings (N, k) and, where the session has a pose, forward speed, lateral speed and turn rate."""
    stages = context.simulator.stages(specs)
    track = stages.link(t, command)
    angle = servo_stage(stages, track, t, initial_rad=command[0]).joint_angle_rad
    reading, _ = stages.sensor(t, angle)
    has_pose = context.ground is not None and any(run.pose is not None for run in context.data.runs)
    if not has_pose or stages.model is None:
        return reading, None
    from snakebot.diagnosis.ground import Window, window_features
    from snakebot.physics import replay

    path = replay(stages.model, t, angle)
    pose = np.column_stack([path.com_m, path.heading_rad])
    return reading, np.array(window_features(t, pose, Window(0, t[-1] / 3, t[-1] - RAMP_S, False)))


def _tolerance(context: Context, t: Floats, command: Floats) -> Floats:
    """How far the nominal reading moves within the tolerance of the servo's lag, (N, k)."""
    from snakebot.diagnosis.score import LAG_TOLERANCE

    stages = context.simulator.stages(())
    angle = servo_stage(stages, stages.link(t, command), t, initial_rad=command[0]).joint_angle_rad
    rate = np.gradient(angle, t, axis=0)
    return np.asarray(rate * context.data.robot.servo.time_constant_s * LAG_TOLERANCE)


def _ground_apart(context: Context, x: Floats | None, y: Floats | None) -> float:
    if x is None or y is None or context.ground is None:
        return 0.0
    kind = context.ground.kind
    room = np.array(
        [
            np.median(context.ground_allowed_square[kind == i]) if np.any(kind == i) else np.inf
            for i in range(3)
        ]
    )
    return float(np.max(0.5 * np.log1p(np.square(x - y) / room)))


def _channel(rivals: Sequence[Trial], on_bench: bool) -> str:
    """The signal that would settle what no motion does."""
    terms = [trial.hypothesis.terms[-1] for trial in rivals]
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
