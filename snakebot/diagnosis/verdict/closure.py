"""How far the gap shrinks on runs that no parameter was fitted to: of the joint angles, and of the forward speed.

closed = (E_before^2 - E_after^2) / (E_before^2 - floor^2). Intervals are from a bootstrap over blocks of time
within each run (angles) or over runs (speeds). A mean square that is little beside the floor's is no gap; and closure
divides by no draw's own gap that is little beside the whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence import ground as ground_motion
from snakebot.diagnosis.evidence.blocks import resample
from snakebot.diagnosis.evidence.data import FEWEST_TO_COMPARE, PreparedRun
from snakebot.diagnosis.evidence.gap import certain_over_ground, gap_of
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.ground_evidence import GroundEvidence
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.result import (
    AngleClosure,
    BudgetEntry,
    GroundClosure,
    JointClosure,
    RunSpeed,
    SpeedClosure,
)
from snakebot.diagnosis.sizes import LITTLE, NEXT_TO_NOTHING
from snakebot.effects.spec import EffectSpec

DRAWS = 1000  # of the bootstrap; chosen: 2.5 % quantiles then rest on 25 draws
NOT_HELD_OUT = (
    "no run is held out, for one motion only may be fitted or shows it: before and after are of fitted runs"
)


def angle_closure(evidence: Evidence, nominal: Trial, best: Trial, seed: int) -> AngleClosure:
    """Closure over all joints of the scored runs; without those, before and after on the fitted ones, and why."""
    angles, split, scoring = evidence.angles, evidence.split, evidence.scoring
    blocks = angles.blocks
    rows = np.isin(blocks.run, split.shown)
    size = blocks.samples[rows]
    before, after = (angles.mean_square(trial.readings)[rows] for trial in (nominal, best))
    e2, a2 = _mean(before, size), _mean(after, size)
    before_within, within = (_mean(blocks.mean_square(trial.left)[rows], size) for trial in (nominal, best))
    joint = blocks.joint[rows]
    floor = evidence.floor
    f2 = _mean(np.square(floor.rad)[joint], size) if floor.known else 0.0
    bound = f2 if floor.known else _mean(np.square(floor.white_rad)[joint], size)
    closed, beyond, interval, reason = None, None, None, None
    shown = np.isin(scoring.run, split.shown)
    significant = gap_of(scoring, nominal.held_square).significant
    significant = significant | gap_of(scoring, nominal.held_square, shown).significant
    if e2 - bound <= LITTLE * bound or not significant.any():
        reason = "no gap beyond noise and tolerance to close"
        if floor.doubts:
            reason = "runs of the same motion are as far apart as they are off their prediction"
    elif not split.scored:
        reason = NOT_HELD_OUT
    else:
        closed = (e2 - a2) / (e2 - f2)
        if before_within - bound > LITTLE * bound:
            beyond = (before_within - within) / (before_within - f2)
        draw = resample(blocks.run[rows], np.random.default_rng(seed), DRAWS)
        weight = size[draw].sum(axis=1)
        eb = (before * size)[draw].sum(axis=1) / weight
        ab = (after * size)[draw].sum(axis=1) / weight
        interval = _interval((eb - ab) / np.maximum(eb - f2, LITTLE * (e2 - f2)))
        if not floor.known:
            reason = "no repeated runs: the floor is taken as zero"
    return AngleClosure(
        rms_before=float(np.sqrt(e2)),
        rms_after=float(np.sqrt(a2)),
        rms_before_within_tolerance=float(np.sqrt(before_within)),
        rms_within_tolerance=float(np.sqrt(within)),
        rms_floor=float(np.sqrt(f2)) if floor.known else None,
        closed=closed,
        closed_beyond_tolerance=beyond,
        ci95=interval,
        reason=reason,
    )


def doubt_about_floor(closure: AngleClosure) -> str | None:
    """A warning where runs are nearer to their prediction than repeats are to each other; None where they are not."""
    floor = closure.rms_floor
    if floor is None or closure.rms_after >= (1 - NEXT_TO_NOTHING) * floor:
        return None
    return (
        f"joint angles are {np.degrees(closure.rms_after):.3g} deg off, less than the noise floor of "
        f"{np.degrees(floor):.3g} deg: repeats are further apart than runs are from their prediction, so the floor is "
        "too high. Set-points that are lost now and then do that, and a repeat in which something differed"
    )


def joint_closures(evidence: Evidence, nominal: Trial, best: Trial) -> tuple[JointClosure, ...]:
    """Before and after of each joint that was read in the runs of ``angle_closure``."""
    angles, floor = evidence.angles, evidence.floor
    blocks = angles.blocks
    before, after = (angles.mean_square(trial.readings) for trial in (nominal, best))
    shown = np.isin(blocks.run, evidence.split.shown)
    made = []
    for joint in range(angles.data.joints):
        rows = shown & (blocks.joint == joint)
        if rows.any():
            size = blocks.samples[rows]
            made.append(
                JointClosure(
                    joint=joint + 1,
                    rms_before=float(np.sqrt(_mean(before[rows], size))),
                    rms_after=float(np.sqrt(_mean(after[rows], size))),
                    rms_floor=float(floor.rad[joint]) if floor.known else None,
                )
            )
    return tuple(made)


@dataclass(frozen=True, eq=False)
class Speeds:
    """Steady forward speed of runs (R,): measured, simulated without and with the effects. m/s."""

    run: tuple[int, ...]
    measured: Floats
    before: Floats
    after: Floats


def forward_speeds(evidence: Evidence, best: Trial) -> Speeds | None:
    """Speeds of the scored (or else fitted) runs from whole simulations, set-points to ground; None where none was
    measured.
    """
    data = evidence.data
    if data.robot.body is None:
        return None
    runs, measured, before, after = [], [], [], []
    for index in evidence.split.shown:
        run = data.runs[index]
        span = ground_motion.steady_span(run)
        window = ground_motion.Window(
            index, *span, run.pose is None, course=not ground_motion.has_heading(run.pose)
        )
        if run.forward_speed_m_s is not None:
            speed = run.forward_speed_m_s
        elif run.pose is not None:
            speed = float(ground_motion.window_features(run.t_s, run.pose, [window])[0, 0])
        else:
            continue
        if not np.isfinite(speed) or ground_motion.broken(run, *span):
            continue
        specs = best.hypothesis.specs(best.run_theta[index])
        runs.append(index)
        measured.append(speed)
        before.append(_simulated_speed(evidence.predictor.simulator, index, (), span))
        after.append(
            _simulated_speed(evidence.predictor.simulator, index, specs, span) if specs else before[-1]
        )
    if not runs:
        return None
    return Speeds(tuple(runs), np.array(measured), np.array(before), np.array(after))


def speeds_by_run(runs: Sequence[PreparedRun], speeds: Speeds) -> tuple[RunSpeed, ...]:
    """The same by the names of the runs."""
    return tuple(
        RunSpeed(
            run=runs[index].name,
            measured=round(float(measured), 6),
            before=round(float(before), 6),
            after=round(float(after), 6),
        )
        for index, measured, before, after in zip(
            speeds.run, speeds.measured, speeds.before, speeds.after, strict=True
        )
    )


def _simulated_speed(
    simulator: Simulator, index: int, specs: tuple[EffectSpec, ...], span: tuple[float, float]
) -> float:
    from snakebot.physics import replay

    run = simulator.data.runs[index]
    stages = simulator.stages(specs)
    assert stages.model is not None
    (angles,) = simulator.predict(specs, [index])
    heading = 0.0 if run.pose is None else float(ground_motion.start_pose(run.t_s, run.pose)[2])
    path = replay(stages.model, run.t_s, angles.angle_rad, heading_rad=heading)
    if run.pose is not None and run.forward_speed_m_s is None and not ground_motion.has_heading(run.pose):
        made = np.column_stack([path.com_m, path.heading_rad])
        window = ground_motion.Window(index, *span, speed_only=False, course=True)
        return float(ground_motion.window_features(run.t_s, made, [window])[0, 0])
    return path.forward_speed_m_s(*span)


def speed_closure(
    evidence: Evidence, nominal: Trial, speeds: Speeds | None, seed: int, *, unheard: str | None = None
) -> SpeedClosure | None:
    """Closure of the forward speed, root mean square over runs, as of the angles; None where no speed was measured.

    ``unheard``: why the readings do not tell the motion over ground, if they do not.
    """
    if speeds is None:
        return None
    ground, split, scoring = evidence.ground, evidence.split, evidence.scoring
    before = np.square(speeds.before - speeds.measured)
    after = np.square(speeds.after - speeds.measured)
    assert ground is not None
    features, floor = ground.features, None
    if features.from_repeats:
        rows = (features.kind == ground_motion.Feature.FORWARD) & np.isin(features.run, speeds.run)
        if rows.any():
            floor = float(np.sqrt(features.floor_square[rows].mean()))
    f2 = 0.0 if floor is None else floor**2
    allowed = float(np.mean([_speed_allowed(ground, run) for run in speeds.run]))
    e2, a2 = float(before.mean()), float(after.mean())
    closed, interval, reason = None, None, None
    shown = np.isin(scoring.run, split.shown)
    gaps = (gap_of(scoring, nominal.held_square, rows) for rows in (None, shown))
    if unheard is not None:
        reason = unheard
    elif e2 <= certain_over_ground(before.size) * max(f2, allowed) or not any(
        gap.ground_significant for gap in gaps
    ):
        reason = (
            "no gap above what noise, tolerance of friction and mass, and ripple between set-points allow"
        )
    elif not split.scored:
        reason = NOT_HELD_OUT
    else:
        closed = (e2 - a2) / (e2 - f2)
        if before.size >= FEWEST_TO_COMPARE:
            runs_alike = np.zeros(before.size, dtype=np.int64)  # each is one number: they are exchangeable
            draw = resample(runs_alike, np.random.default_rng(seed), DRAWS)
            eb, ab = before[draw].mean(axis=1), after[draw].mean(axis=1)
            interval = _interval((eb - ab) / np.maximum(eb - f2, LITTLE * (e2 - f2)))
        if floor is None:
            reason = "no repeated runs: the floor is taken as zero"
    return SpeedClosure(
        error_before=float(np.sqrt(e2)),
        error_after=float(np.sqrt(a2)),
        rms_measured=float(np.sqrt(np.square(speeds.measured).mean())),
        floor=floor,
        closed=closed,
        ci95=interval,
        reason=reason,
    )


def ground_closure(budget: Sequence[BudgetEntry]) -> GroundClosure | None:
    """Closure of the whole motion over ground: what the budget of its gap leaves to no rest. None without a budget."""
    rest = next((entry for entry in budget if entry.of == "ground" and entry.cause is None), None)
    if rest is None:
        return None
    ends = None if rest.ci95 is None else (1 - rest.ci95[1], 1 - rest.ci95[0])
    return GroundClosure(closed=1 - rest.share, ci95=ends)


def _speed_allowed(ground: GroundEvidence, run: int) -> float:
    rows = (ground.features.kind == ground_motion.Feature.FORWARD) & (ground.features.run == run)
    return float(ground.allowed_square[rows].mean()) if rows.any() else 0.0


def _mean(square: Floats, size: Floats) -> float:
    return float((square * size).sum() / size.sum()) if size.size else 0.0


def _interval(values: Floats) -> tuple[float, float]:
    low, high = ends_of_95_percent(values)
    return float(low), float(high)


def ends_of_95_percent(drawn: Floats) -> Floats:
    """(2, ...) ends of the interval in which 95 % of the draws (D, ...) lie; those that are nan do not count."""
    return np.asarray(np.nanquantile(drawn, (0.025, 0.975), axis=0))
