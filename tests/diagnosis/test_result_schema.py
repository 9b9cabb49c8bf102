"""The published schemas."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema

import snakebot.diagnosis.result as result
from snakebot.diagnosis.result import (
    AngleClosure,
    Cause,
    Closure,
    Diagnosis,
    Estimate,
    JointEstimate,
    StageShares,
    Unexplained,
    Where,
)

FOUND = Diagnosis(
    verdict="partly",
    where=Where(
        stage="servo", stage_shares=StageShares(servo=1.0), joints=(1, 2), joint_shares=(0.5, 0.5), regime=""
    ),
    causes=(
        Cause(
            effect="servo_lag",
            joints=(1, 2),
            stage="servo",
            probability=0.9,
            parameters={
                "time_constant_s": Estimate(
                    estimate=0.05,
                    ci95=None,
                    unit="s",
                    by_joint=tuple(JointEstimate(joint=j, estimate=0.04, ci95=(0.03, 0.05)) for j in (1, 2)),
                )
            },
            specification="servo_lag:time_constant_s=0.04+0.04,joints=1+2",
        ),
    ),
    ranking=(),
    closure=Closure(
        held_out_runs=("a.csv",),
        joint_angle=AngleClosure(rms_before=0.1, rms_after=0.05, rms_floor=None, closed=0.75),
        forward_speed=None,
    ),
    unexplained=Unexplained(share=0.25, where="", significant=True),
    next_experiment=None,
)


def _published(number: int) -> dict[str, object]:
    path = Path(result.__file__).with_name(f"diagnosis-{number}.schema.json")
    read: dict[str, object] = json.loads(path.read_text())
    return read


def test_the_published_schema_is_the_one_of_the_types() -> None:
    assert _published(2) == result.json_schema()


def test_what_schema_2_adds_is_left_out_of_schema_1() -> None:
    jsonschema.validate(FOUND.to_mapping(), _published(2))
    first = FOUND.to_mapping(first=True)
    jsonschema.validate(first, _published(1))
    assert (first["schema"], first["verdict"]) == ("snakebot.diagnosis/1", "unexplained")
