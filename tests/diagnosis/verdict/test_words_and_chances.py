"""Probabilities, and the sentence on where a gap is largest."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

import snakebot.diagnosis.result as result
from snakebot.diagnosis.verdict.probability import CauseFeatures, beside, calibration, probability, shared
from snakebot.diagnosis.verdict.regime import sentence


def test_probabilities_rise_with_the_lead_and_fall_with_the_rest() -> None:
    poor = CauseFeatures(
        lead=3.0,
        rest=500.0,
        closed=0.98,
        share=1.0,
        motions=4,
        explained=True,
        own=False,
        worn=False,
        together=1,
    )
    assert probability(poor) <= 0.6  # so much left over: not the whole story
    base = replace(poor, lead=0.3, rest=1.0)
    assert probability(replace(base, lead=1.0)) >= probability(base) >= probability(replace(base, lead=0.0))
    assert probability(replace(base, rest=50.0)) < probability(base)
    assert probability(replace(base, motions=1)) <= 0.5
    worn = replace(base, explained=False, own=True, worn=True, together=6)
    assert probability(worn) > probability(replace(worn, own=False, worn=False, together=1))
    assert probability(replace(worn, lead=5.0)) == probability(worn)
    assert probability(replace(worn, share=0.02)) < probability(replace(worn, share=0.2)) < probability(worn)
    assert probability(replace(base, share=0.02)) == probability(base)  # alone it carries what is closed
    assert calibration().cases > 0
    assert "calibrate" in calibration().command
    assert sum(shared(0.9, [-0.1, -0.2, -0.1])) == pytest.approx(0.9)


@given(st.floats(0, 1), st.lists(st.floats(-10, 10), min_size=1), st.floats(0, 0.5))
def test_what_lost_is_never_likelier_than_what_won(best: float, scores: list[float], most: float) -> None:
    made = beside(best, 0.0, scores, most)
    assert max(made) <= best
    assert sum(made) <= most * (1 + 1e-9)
    order = sorted(range(len(scores)), key=lambda i: scores[i])
    assert [made[i] for i in order] == sorted(made)


def test_the_sentence_names_the_load_or_the_angle_beside_the_largest_regime() -> None:
    def bins(axis: str, *rms: float) -> list[result.Regime]:
        return [
            result.Regime(axis=axis, bin=f"bin {i}", rms_before_rad=r, rms_after_rad=r / 2, samples=50)
            for i, r in enumerate(rms)
        ]

    time, angle = bins("time since start", 0.1, 0.5), bins("angle", 0.1, 0.3)
    both = sentence([*time, *angle])
    assert both.startswith("the gap is largest by time since start: 29 deg rms bin 1, 5.7 deg rms bin 0")
    assert both.endswith("; by angle: 17 deg rms bin 1, 5.7 deg rms bin 0")
    assert "angle" not in sentence([*time, *bins("angle", 0.1, 0.12)])
    assert sentence(angle, rest=True) == "the rest is largest by angle: 8.6 deg rms bin 1, 2.9 deg rms bin 0"
    assert "much the same" in sentence(bins("load", 0.1, 0.11))
