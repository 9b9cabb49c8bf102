"""A verdict in words: a tie is never called sure."""

from __future__ import annotations

import pytest

from snakebot.diagnosis.result import (
    AngleClosure,
    Cause,
    Closure,
    Diagnosis,
    RankingEntry,
    StageShares,
    Unexplained,
    Where,
)
from snakebot.diagnosis.show.words import headline, summary


def verdict(
    probability: float,
    *others: str,
    rivals: float = 0.0,
    ranking: tuple[float, ...] = (),
) -> Diagnosis:
    shares = StageShares(servo=1.0)
    return Diagnosis(
        verdict="explained",
        where=Where(stage="servo", stage_shares=shares, joints=(3,), joint_shares=(1.0,), regime=""),
        causes=(
            Cause(
                effect="deadband",
                joints=(3,),
                stage="servo",
                probability=probability,
                parameters={},
                indistinguishable_from=others,
                specification="deadband:width_deg=3,joints=3",
                evidence={"rivals": rivals},
            ),
        ),
        ranking=tuple(
            RankingEntry(
                effects=("deadband",),
                joints=(joint,),
                held_out_score=-0.1,
                delta=0.0,
                delta_se=0.0,
                probability=p,
            )
            for joint, p in enumerate(ranking, start=1)
        ),
        closure=Closure(
            held_out_runs=(),
            joint_angle=AngleClosure(rms_before=0.1, rms_after=0.0, rms_floor=0.0, closed=1.0),
            forward_speed=None,
        ),
        unexplained=Unexplained(share=0.0, where="", significant=False),
        next_experiment=None,
    )


@pytest.mark.parametrize(
    ("found", "word"),
    [
        (verdict(0.95), "sure"),
        (verdict(0.95, ranking=(0.95, 0.02)), "sure"),
        (verdict(0.7), "likely"),
        (verdict(0.3), "a guess"),
        (verdict(0.95, "backlash"), "a tie"),
        (verdict(0.7, "backlash"), "a tie"),
        (verdict(0.3, "backlash"), "a guess"),
        (verdict(0.95, rivals=1.0), "a tie"),  # the same effect, on another joint
        (verdict(0.95, ranking=(0.48, 0.47)), "a tie"),
        (verdict(0.95, ranking=(0.02, 0.48, 0.47)), "a tie"),
    ],
)
def test_what_cannot_be_told_apart_is_not_sure(found: Diagnosis, word: str) -> None:
    assert headline(found).startswith(f"Explained ({word}): ")
    assert "tand" in headline(found)
    assert summary(found)[0] == headline(found)
