"""Where the gap lies: measured signals are fed in at each boundary, and what vanishes with them lies before it.

set-point -> [link] -> applied -> [servo, sensor] -> reading -> [body] -> motion over ground. The angle's part and the ground's
part are made comparable as shares of the motion itself. Between servo and sensor no signal is measured: there the
effects that were found decide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis import ground as ground_motion
from snakebot.diagnosis.blocks import mean_difference
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.result import StageShares
from snakebot.diagnosis.trial import Trial

Floats = NDArray[np.float64]

GAP_SE = 3.0
GAP_SIZE = 1.0  # mean square over the allowed one, above which a gap is one
LEAST_SHARE = 0.05  # of the gap, for a joint to be named


@dataclass(frozen=True, eq=False)
class Gap:
    """The gap of one trial.

    Attributes:
        joint_square: (k,) mean squares above the floor, rad^2.
        significant: (k,) whether they are beyond noise and tolerance.
        ground_ratio: mean square of the ground's features over what is allowed; nan without a ground.
        ground_significant: the same for the ground.
    """

    joint_square: Floats
    significant: NDArray[np.bool_]
    ground_ratio: float
    ground_significant: bool

    @property
    def any(self) -> bool:
        return bool(self.significant.any()) or self.ground_significant

    @property
    def joint_shares(self) -> Floats:
        """(k,) adding up to one; zeros without a gap."""
        total = self.joint_square.sum()
        return self.joint_square / total if total > 0 else np.zeros_like(self.joint_square)


def gap_of(context: Context, trial: Trial) -> Gap:
    """What a trial leaves over, joint by joint and over ground."""
    k = context.data.joints
    square, significant = np.zeros(k), np.zeros(k, dtype=bool)
    for joint in range(k):
        rows = (context.block_joint == joint) & context.selects
        if not rows.any():
            continue
        held, allowed = trial.held_square[rows], context.allowed_square[rows]
        square[joint] = max(float(held.mean()) - float(context.floor.rad[joint] ** 2), 0.0)
        significant[joint] = _beyond(held, allowed, context.block_run[rows])
    rows = (context.block_joint == -1) & context.selects
    ratio, ground = float("nan"), False
    if rows.any():
        ratio = float(np.mean(trial.held_square[rows] / context.allowed_square[rows]))
        ground = _ground_beyond(context, trial)
    return Gap(square, significant, ratio, ground)


def _ground_beyond(context: Context, trial: Trial) -> bool:
    """Whether speed or turning is off beyond what is allowed, over all windows."""
    ground = context.ground
    assert ground is not None
    first = context.angle_blocks.count
    held, allowed = trial.held_square[first:], context.ground_allowed_square
    use = context.selects[first:]
    for kind in (ground_motion.FORWARD, ground_motion.LATERAL, ground_motion.TURN):
        rows = (ground.kind == kind) & use
        if rows.sum() >= 2 and np.mean(held[rows] / allowed[rows]) > 2.0 * GAP_SIZE:
            return True
        if rows.sum() >= 8 and _beyond(held[rows], allowed[rows], ground.run[rows]):
            return True
    return False


def _beyond(square: Floats, allowed: Floats, run: NDArray[np.int64]) -> bool:
    excess = mean_difference(np.log1p(square / allowed) - np.log(1 + GAP_SIZE), run)
    overall = float(square.mean() / allowed.mean())
    return (excess.z > GAP_SE and excess.mean > 0) or overall > 2.5 * GAP_SIZE


def shares(context: Context, nominal: Trial, steps: Sequence[tuple[Trial, Trial]]) -> StageShares:
    """Share of each stage; ``steps`` are pairs (before, after) of the explanation as it grew, one effect each."""
    gap = gap_of(context, nominal)
    if not gap.any:
        return StageShares()
    angle = _relative_angle(context, gap)
    body = _relative_ground(context, nominal)
    link = _link_share(context, nominal)
    parts = {"link": 0.0, "servo": 0.0, "sensor": 0.0}
    closed_by: dict[str, float] = dict.fromkeys(parts, 0.0)
    count = context.angle_blocks.count
    for before, after in steps:
        stage = after.hypothesis.terms[-1].stage
        fell = float(before.held_square[:count].mean() - after.held_square[:count].mean())
        if stage in closed_by:
            closed_by[stage] += max(fell, 0.0)
    total = sum(closed_by.values())
    if link is not None:
        parts["link"] = link
        rest = {s: closed_by[s] for s in ("servo", "sensor")}
        inner = sum(rest.values())
        for s in rest:
            parts[s] = (1 - link) * (rest[s] / inner if inner > 0 else float(s == "servo"))
    elif total > 0:
        whole = max(float((gap.joint_square).mean()), 1e-300)
        known = min(total / max(whole, total), 1.0)
        for s in parts:
            parts[s] = known * closed_by[s] / total
        parts["servo"] += 1 - known  # what no effect explains before the ground is put down to the servos
    else:
        parts["servo"] = 1.0
    both = angle + body
    if both <= 0:
        return StageShares()
    return StageShares(
        link=_clean(parts["link"] * angle / both),
        servo=_clean(parts["servo"] * angle / both),
        sensor=_clean(parts["sensor"] * angle / both),
        body=_clean(body / both),
    )


def _clean(share: float) -> float:
    return round(min(max(share, 0.0), 1.0), 4)


def _relative_angle(context: Context, gap: Gap) -> float:
    """Gap of the angles, mean square over that of the motion. Nothing where it is not significant."""
    if not gap.significant.any():
        return 0.0
    motion = np.concatenate([run.measured_rad[run.use] for run in context.data.runs if run.use.any()])
    told = np.concatenate([run.command_rad[run.use] for run in context.data.runs if run.use.any()])
    size = max(float(np.var(motion)), float(np.var(told)), 1e-12)
    return float(gap.joint_square[gap.significant].sum()) / context.data.joints / size


def _relative_ground(context: Context, nominal: Trial) -> float:
    """Gap of the ground under *measured* joint angles, mean square over that of the speed."""
    ground = context.ground
    if ground is None or not _ground_beyond(context, nominal):
        return 0.0
    first = context.angle_blocks.count
    held = nominal.held_square[first:]
    planar = ground.kind != ground_motion.TURN
    excess = np.maximum(held - context.ground_allowed_square, 0.0)
    speed = float(np.mean(np.square(ground.value[planar]))) + 1e-6
    turning = float(np.mean(excess[~planar])) * 0.05**2 if (~planar).any() else 0.0
    return (float(np.mean(excess[planar])) + turning) / speed


def _link_share(context: Context, nominal: Trial) -> float | None:
    """Share of the angle's gap that vanishes when the set-points that the board applied are fed in; None if unknown."""
    from snakebot.effects.effect import Track

    if any(run.applied_rad is None or not np.isfinite(run.applied_rad).any() for run in context.data.runs):
        return None
    simulator = context.simulator
    stages = simulator.stages(())
    readings = []
    for index, run in enumerate(context.data.runs):
        assert run.applied_rad is not None
        applied = np.where(np.isfinite(run.command_rad), run.applied_rad, np.nan)
        applied = np.where(np.isfinite(applied) | ~np.isfinite(run.command_rad), applied, run.command_rad)
        readings.append(simulator.servo(stages, index, run, Track(run.t_s, applied)))
    blocks = context.angle_blocks
    square = blocks.mean_square(context.residuals(readings))
    floor = context.scale.floor_square
    whole = float(np.mean(nominal.held_square[: blocks.count] - floor))
    left = float(np.mean(square - floor))
    # what the half tick between board and log does is not the link's doing
    if whole <= float(np.mean(context.scale.tolerance_square)):
        return 0.0
    share = 1 - max(left, 0.0) / whole
    return share if share > 0.05 else 0.0


def named_joints(gap: Gap) -> tuple[int, ...]:
    """1-based joints with a gap worth naming."""
    share = gap.joint_shares
    return tuple(j + 1 for j in range(share.size) if gap.significant[j] and share[j] >= LEAST_SHARE / share.size)
