"""How far the gap shrinks on runs that no parameter was fitted to: of the joint angles, and of the forward speed.

closed = (E_before^2 - E_after^2) / (E_before^2 - floor^2). Intervals are from a bootstrap over blocks of time
within each run (angles) or over runs (speeds).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from snakebot.diagnosis import ground as ground_motion
from snakebot.diagnosis.blocks import resample
from snakebot.diagnosis.context import Context
from snakebot.diagnosis.gap import gap_of
from snakebot.diagnosis.result import AngleClosure, SpeedClosure
from snakebot.diagnosis.trial import Trial

Floats = NDArray[np.float64]

DRAWS = 1000
NOT_HELD_OUT = (
    "only one motion may be fitted, so no run is held out: before and after are of the runs that were fitted"
)
NO_GAP = 0.1  # a gap whose mean square above the floor is under this share of the floor's is none


def angle_closure(context: Context, nominal: Trial, best: Trial) -> AngleClosure:
    """Closure over all joints of the scored runs; without those, before and after on the fitted ones, and why."""
    blocks = context.angle_blocks
    rows = np.isin(blocks.run, context.shown_runs)
    size = blocks.samples[rows]
    before, after = (blocks.mean_square(context.residuals(trial.readings))[rows] for trial in (nominal, best))
    e2, a2 = _mean(before, size), _mean(after, size)
    joint = blocks.joint[rows]
    floor = context.floor
    f2 = _mean(np.square(floor.rad)[joint], size) if floor.known else 0.0
    bound = f2 if floor.known else _mean(np.square(floor.white_rad)[joint], size)
    closed, interval, reason = None, None, None
    significant = gap_of(context, nominal).significant | gap_of(context, nominal, context.shown).significant
    if e2 - bound <= NO_GAP * bound or not significant.any():
        reason = "no gap beyond noise and tolerance to close"
        if floor.doubts:
            reason = "runs of the same motion are as far apart as they are off their prediction"
    elif not context.scored_runs:
        reason = NOT_HELD_OUT
    else:
        closed = (e2 - a2) / (e2 - f2)
        draw = resample(blocks.run[rows], np.random.default_rng(context.seed), DRAWS)
        weight = size[draw].sum(axis=1)
        eb = (before * size)[draw].sum(axis=1) / weight
        ab = (after * size)[draw].sum(axis=1) / weight
        interval = _interval((eb - ab) / np.maximum(eb - f2, 0.1 * (e2 - f2)))
        if not floor.known:
            reason = "no repeated runs: the floor is taken as zero"
    return AngleClosure(
        rms_before=float(np.sqrt(e2)),
        rms_after=float(np.sqrt(a2)),
        rms_floor=float(np.sqrt(f2)) if floor.known else None,
        closed=closed,
        ci95=interval,
        reason=reason,
    )


@dataclass(frozen=True, eq=False)
class Speeds:
    """Steady forward speed of runs (R,): measured, simulated without and with the effects. m/s."""

    run: tuple[int, ...]
    measured: Floats
    before: Floats
    after: Floats


def forward_speeds(context: Context, best: Trial) -> Speeds | None:
    """Speeds of the scored (or else fitted) runs from whole simulations, set-points to ground; None where none was
    measured.
    """
    data = context.data
    if data.robot.body is None:
        return None
    runs, measured, before, after = [], [], [], []
    for index in context.shown_runs:
        run = data.runs[index]
        span = ground_motion.steady_span(run)
        window = ground_motion.Window(index, *span, run.pose is None)
        if run.forward_speed_m_s is not None:
            speed = run.forward_speed_m_s
        elif run.pose is not None:
            speed = ground_motion.window_features(run.t_s, run.pose, window)[0]
        else:
            continue
        if not np.isfinite(speed) or ground_motion.broken(run, *span):
            continue
        specs = best.hypothesis.specs(best.run_theta[index])
        runs.append(index)
        measured.append(speed)
        before.append(_simulated_speed(context, index, (), span))
        after.append(_simulated_speed(context, index, specs, span) if specs else before[-1])
    if not runs:
        return None
    return Speeds(tuple(runs), np.array(measured), np.array(before), np.array(after))


def _simulated_speed(
    context: Context, index: int, specs: tuple[object, ...], span: tuple[float, float]
) -> float:
    from snakebot.physics import replay

    run = context.data.runs[index]
    stages = context.simulator.stages(specs)  # type: ignore[arg-type]
    assert stages.model is not None
    (angles,) = context.simulator.predict(specs, [index])  # type: ignore[arg-type]
    heading = 0.0
    if run.pose is not None:
        known = run.pose[:, 2][np.isfinite(run.pose[:, 2])]
        heading = float(known[0]) if known.size else 0.0
    path = replay(stages.model, run.t_s, angles.angle_rad, heading_rad=heading)
    return path.forward_speed_m_s(*span)


def speed_closure(context: Context, speeds: Speeds | None) -> SpeedClosure | None:
    """Closure of the forward speed, root mean square over runs, as of the angles; None where no speed was measured."""
    if speeds is None:
        return None
    before = np.square(speeds.before - speeds.measured)
    after = np.square(speeds.after - speeds.measured)
    ground = context.ground
    floor = None
    if ground is not None and ground.from_repeats:
        rows = (ground.kind == ground_motion.FORWARD) & np.isin(ground.run, speeds.run)
        if rows.any():
            floor = float(np.sqrt(ground.floor_square[rows].mean()))
    f2 = 0.0 if floor is None else floor**2
    allowed = float(np.mean([_speed_allowed(context, run) for run in speeds.run]))
    e2, a2 = float(before.mean()), float(after.mean())
    closed, interval, reason = None, None, None
    if e2 <= max(f2, allowed):
        reason = "no gap above what noise and the tolerance of friction and mass allow"
    elif not context.scored_runs:
        reason = NOT_HELD_OUT
    else:
        closed = (e2 - a2) / (e2 - f2)
        if before.size >= 3:
            draw = np.random.default_rng(context.seed).integers(0, before.size, size=(DRAWS, before.size))
            eb, ab = before[draw].mean(axis=1), after[draw].mean(axis=1)
            interval = _interval((eb - ab) / np.maximum(eb - f2, 0.1 * (e2 - f2)))
        if floor is None:
            reason = "no repeated runs: the floor is taken as zero"
    return SpeedClosure(
        error_before=float(np.sqrt(e2)),
        error_after=float(np.sqrt(a2)),
        floor=floor,
        closed=closed,
        ci95=interval,
        reason=reason,
    )


def _speed_allowed(context: Context, run: int) -> float:
    ground = context.ground
    assert ground is not None
    rows = (ground.kind == ground_motion.FORWARD) & (ground.run == run)
    return float(context.ground_allowed_square[rows].mean()) if rows.any() else 0.0


def _mean(square: Floats, size: Floats) -> float:
    return float((square * size).sum() / size.sum()) if size.size else 0.0


def _interval(values: Floats) -> tuple[float, float]:
    low, high = np.quantile(values, [0.025, 0.975])
    return float(low), float(high)
