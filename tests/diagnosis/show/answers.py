"""Diagnoses of every kind, made by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from snakebot.diagnosis.result import (
    AngleClosure,
    BudgetEntry,
    Cause,
    Closure,
    Details,
    Diagnosis,
    Estimate,
    GaitDegrees,
    NextExperiment,
    RankingEntry,
    SpeedClosure,
    StageShares,
    StatedNumber,
    Trace,
    Unexplained,
    Where,
)

RUNS = ("run_01.csv", "run_02.csv", "run_03.csv")
LIMIT = Cause(
    effect="rate_limit",
    joints=(3,),
    stage="servo",
    probability=0.97,
    parameters={"limit_rad_s": Estimate(estimate=1.999979752561277, ci95=(1.978, 2.021), unit="rad/s")},
    specification="rate_limit:limit_rad_s=1.999979752561277,joints=3",
)
SCALE = Cause(
    effect="command_gain",
    joints=(1,),
    stage="servo",
    probability=0.93,
    parameters={"gain": Estimate(estimate=0.9001, ci95=(0.89, 0.91))},
    indistinguishable_from=("encoder_gain",),
    specification="command_gain:gain=0.9001,joints=1",
)
WEIGHT = Cause(
    effect="payload",
    joints=(),
    stage="body",
    probability=0.9,
    parameters={
        "link": Estimate(estimate=5, ci95=None, fixed=True),
        "mass_kg": Estimate(estimate=0.512, ci95=(0.44, 0.58), unit="kg"),
    },
    specification="payload:link=5,mass_kg=0.512",
)
NEXT = NextExperiment(
    gait=GaitDegrees(alpha_deg=20, beta_deg=80, omega_rad_s=5),
    duration_s=12,
    ramp_s=2,
    motion="a gait, alpha 20 deg, beta 80 deg, omega 5 rad/s, 12 s",
    separates=(("command_gain", "encoder_gain"),),
    expected_probability_after=0.95,
    reason="the predictions of command_gain and encoder_gain differ by 12 times the noise there",
    command="snakebot run --alpha 20 --beta 80 --omega 5 --duration 12 --ramp 2",
)


def trace(cause: int | None) -> Trace:
    t = np.linspace(0, 6, 60)
    rows = {name: tuple(float(v) for v in k * np.sin(t)) for name, k in (("command", 1.0), ("measured", 0.8))}
    return Trace(
        run=RUNS[0],
        joint=3,
        t_s=tuple(float(v) for v in t),
        command_rad=rows["command"],
        measured_rad=rows["measured"],
        before_rad=rows["command"],
        after_rad=rows["measured"],
        cause=cause,
    )


def made(
    verdict: str,
    *causes: Cause,
    closed: float | None = 1.03,
    left: float = 0.0,
    experiment: NextExperiment | None = None,
    speed: SpeedClosure | None = None,
    held_out: tuple[str, ...] = RUNS,
    slow: bool = False,
    warnings: tuple[str, ...] = (),
) -> Diagnosis:
    joints = tuple(sorted({j for cause in causes for j in cause.joints}))
    shares = (0.04, 0.0, 0.96, 0.0, 0.0) if verdict != "no_gap" else (0.0,) * 5
    after = {"no_gap": 0.0143, "unexplained": 0.0135}.get(verdict, 0.000226 if left == 0 else 0.0088)
    rivals = [
        RankingEntry(
            effects=("servo_lag",),
            joints=(3,),
            held_out_score=-1.0,
            delta=0.8,
            delta_se=0.1,
            probability=0.01,
            parameters=1,
            rms_after=0.012,
            worse_in=RUNS[:2],
        ),
        RankingEntry(effects=(), joints=(), held_out_score=-2.0, delta=1.8, delta_se=0.1, probability=0.0),
    ]
    best = RankingEntry(
        effects=tuple(c.effect for c in causes),
        joints=joints,
        held_out_score=-0.2,
        delta=0.0,
        delta_se=0.0,
        probability=0.9,
        parameters=1,
        rms_after=after,
    )
    return Diagnosis(
        verdict=verdict,  # type: ignore[arg-type]
        where=Where(
            stage=causes[0].stage if causes else "servo" if verdict == "unexplained" else "none",
            stage_shares=StageShares(servo=1.0 if verdict != "no_gap" else 0.0),
            joints=joints or ((3,) if verdict == "unexplained" else ()),
            joint_shares=shares,
            regime="the gap is largest by speed of the joint: 2 deg rms above 2 rad/s",
        ),
        causes=causes,
        ranking=tuple([best, *rivals] if causes else rivals),
        closure=Closure(
            held_out_runs=held_out,
            joint_angle=AngleClosure(
                rms_before=0.0143, rms_after=after, rms_floor=0.000209, closed=closed, ci95=(0.99, 1.05)
            ),
            forward_speed=speed,
        ),
        unexplained=Unexplained(share=left, where="joint 3", significant=left > 0),
        next_experiment=experiment,
        warnings=warnings,
        nominal=(
            StatedNumber(
                number="servo.time_constant_s",
                joints=(2,),
                stated=0.03,
                tolerance=0.0018,
                estimate=0.0371,
                ci95=(0.0366, 0.0376),
            ),
        ),
        budget=tuple(_entry(number, (1 - left) / len(causes)) for number in range(len(causes))),
        budget_rest=(_entry(None, left),) if causes else (),
        details=Details(
            floor_rad=(0.0002,) * 5,
            gap_rms_rad=(0.001, 0.0002, 0.02, 0.0002, 0.0002),
            rest_rms_rad=(0.0002,) * 5,
            traces=(*(trace(i) for i in range(len(causes))), trace(None)),
            slow_log=slow,
        ),
    )


KINDS: dict[str, Callable[[], Diagnosis]] = {
    "sure": lambda: made("explained", LIMIT),
    "two causes that tie": lambda: made("explained", LIMIT, SCALE, experiment=NEXT),
    "likely": lambda: made("explained", LIMIT.model_copy(update={"probability": 0.7})),
    "a guess": lambda: made("explained", LIMIT.model_copy(update={"probability": 0.4})),
    "slow log": lambda: made("explained", LIMIT.model_copy(update={"probability": 0.8}), slow=True),
    "one motion": lambda: made(
        "explained", LIMIT.model_copy(update={"probability": 0.5}), held_out=(), closed=None
    ),
    "partly": lambda: made("partly", LIMIT, closed=0.62, left=0.38),
    "over ground": lambda: made(
        "explained",
        WEIGHT,
        closed=None,
        speed=SpeedClosure(error_before=0.0612, error_after=0.00757, floor=0.003, closed=0.97),
    ),
    "unexplained": lambda: made("unexplained", LIMIT, closed=0.12),
    "unexplained, nothing near": lambda: made("unexplained"),
    "no gap": lambda: made("no_gap", closed=None),
}


def _entry(cause: int | None, share: float) -> BudgetEntry:
    return BudgetEntry(
        cause=cause,
        of="joint_angle",
        share=share,
        ci95=(share - 0.02, share + 0.02),
        by_joint=(None, None, share, None, None),
        by_run=dict.fromkeys(RUNS, share),
    )
