"""Where the gap lies: measured signals are fed in at each boundary, and what vanishes with them lies before it.

set-point -> [link] -> applied -> [servo, sensor] -> reading -> [body] -> motion over ground. The angle's part
and the ground's part are made comparable by what noise and tolerance allow of each: a robot that rubs otherwise than
stated goes some per cent less far, a fault at a joint is a hundredth of its swing. Between servo and sensor no signal
is measured: there the effects that were found decide.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snakebot.arrays import Bools
from snakebot.diagnosis.evidence.angles import AngleEvidence
from snakebot.diagnosis.evidence.gap import Gap
from snakebot.diagnosis.evidence.gather import Evidence
from snakebot.diagnosis.evidence.score import Scoring
from snakebot.diagnosis.evidence.simulator import Simulator
from snakebot.diagnosis.fit.trial import Trial
from snakebot.diagnosis.result import StageShares
from snakebot.diagnosis.sizes import NEXT_TO_NOTHING


def shares(evidence: Evidence, gap: Gap, nominal: Trial, steps: Sequence[tuple[Trial, Trial]]) -> StageShares:
    """Share of each stage in the gap of ``nominal``; ``steps`` are pairs (before, after) of the explanation as it grew,
    one effect each.
    """
    if not gap.any:
        return StageShares()
    angle, body = beyond_allowed(evidence.scoring, gap, nominal, evidence.scoring.decides)
    link = _link_share(evidence.angles, evidence.predictor.simulator, nominal)
    parts = {"link": 0.0, "servo": 0.0, "sensor": 0.0}
    closed_by: dict[str, float] = dict.fromkeys(parts, 0.0)
    count = evidence.angles.blocks.count
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


def beyond_allowed(scoring: Scoring, gap: Gap, trial: Trial, rows: Bools) -> tuple[float, float]:
    """How far mean squares in some blocks (B,) are above the allowed ones, as multiples of these: in the mean of the
    joints with a gap, and over ground *under measured joint angles*. Nothing where no ``gap`` is significant.
    """
    over = np.maximum(trial.held_square / scoring.allowed_square - 1, 0.0)
    of_joints = [rows & (scoring.joint == j) for j in np.flatnonzero(gap.significant)]
    angle = [float(over[mine].mean()) for mine in of_joints if mine.any()]
    ground = rows & scoring.of_ground
    body = float(over[ground].mean()) if gap.ground_significant and ground.any() else 0.0
    return float(np.mean(angle)) if angle else 0.0, body


def _link_share(angles: AngleEvidence, simulator: Simulator, nominal: Trial) -> float | None:
    """Share of the angle's gap that vanishes when the set-points that the board applied are fed in; None if unknown."""
    from snakebot.effects.effect import Track

    if any(run.applied_rad is None or not np.isfinite(run.applied_rad).any() for run in angles.data.runs):
        return None
    stages = simulator.stages(())
    readings = []
    for index, run in enumerate(angles.data.runs):
        assert run.applied_rad is not None
        applied = np.where(np.isfinite(run.command_rad), run.applied_rad, np.nan)
        applied = np.where(np.isfinite(applied) | ~np.isfinite(run.command_rad), applied, run.command_rad)
        readings.append(simulator.joints(stages, index, Track(run.t_s, applied)).angle_rad)
    square = angles.mean_square(readings)
    floor = angles.floor_square
    plain = angles.mean_square(nominal.readings)
    whole = float(np.mean(plain - floor))
    left = float(np.mean(square - floor))
    # what the half tick between board and log does is not the link's doing
    if whole <= float(np.mean(angles.tolerance_square)):
        return 0.0
    share = 1 - max(left, 0.0) / whole
    return share if share > NEXT_TO_NOTHING else 0.0
