"""The verdict is one function of a few facts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from snakebot.diagnosis.evidence.gap import Gap
from snakebot.diagnosis.search.acceptance import MOST_LEFT
from snakebot.diagnosis.sizes import HALF
from snakebot.diagnosis.verdict.decision import VerdictFacts, decide
from snakebot.diagnosis.verdict.rest import Rest

GAP = Gap(np.array([1e-3]), np.array([True]), np.nan, False)
NONE = Gap(np.zeros(1), np.array([False]), np.nan, False)
NO_REST = Rest(share=0.0, of_angles=0.0, of_ground=0.0, gap=NONE)
FACTS = VerdictFacts(
    gap=GAP,
    explanation=True,
    rest=NO_REST,
    noisy=False,
    in_scatter=False,
    in_scatter_alone=False,
    floor_hides_gap=False,
    rest_held_out=None,
)


def rest(share: float) -> Rest:
    return Rest(share, share, share, GAP)


def test_a_gap_that_closes_is_explained_and_one_without_an_explanation_is_not() -> None:
    assert decide(FACTS) == "explained"
    assert decide(replace(FACTS, explanation=False)) == "unexplained"


@pytest.mark.parametrize(
    ("left", "verdict"),
    [
        (rest(0.9 * MOST_LEFT), "explained"),
        (rest(1.1 * MOST_LEFT), "partly"),
        (Rest(1.1 * MOST_LEFT, 0.0, 1.1 * MOST_LEFT, replace(NONE, ground_significant=True)), "partly"),
        (Rest(0.01, 0.0, 1.0, replace(NONE, ground_significant=True)), "partly"),
        (Rest(0.01, 1.0, 0.0, replace(NONE, ground_significant=True)), "explained"),
        (rest(1.1 * HALF), "unexplained"),
        (replace(NO_REST, share=1.0), "explained"),  # within noise and tolerance
    ],
)
def test_a_rest_counts_by_its_size_where_it_is_beyond_noise_and_tolerance(left: Rest, verdict: str) -> None:
    assert decide(replace(FACTS, rest=left)) == verdict


def test_what_chance_leaves_over_is_no_reason_to_explain_nothing() -> None:
    left = replace(FACTS, rest=rest(1.1 * HALF))
    assert decide(replace(left, in_scatter=True)) == "partly"
    assert decide(replace(left, in_scatter=True, explanation=False)) == "unexplained"


def test_without_a_gap_there_is_none_unless_the_encoders_shake_or_the_floor_hides_it() -> None:
    quiet = replace(FACTS, gap=NONE, explanation=False)
    assert decide(quiet) == "no_gap"
    assert decide(replace(quiet, noisy=True)) == "explained"
    assert decide(replace(quiet, floor_hides_gap=True)) == "unexplained"


def test_what_is_left_in_held_out_runs_overrides_all_but_the_scatter() -> None:
    failing = replace(FACTS, rest_held_out=rest(1.1 * HALF))
    assert decide(failing) == "unexplained"
    assert decide(replace(failing, rest_held_out=rest(0.9 * HALF))) == "partly"
    assert decide(replace(failing, gap=NONE)) == "unexplained"
    assert decide(replace(failing, gap=NONE, in_scatter_alone=True)) == "explained"


def test_a_cause_in_the_scatter_alone_is_explained_if_it_has_a_name() -> None:
    lost = replace(FACTS, gap=NONE, in_scatter_alone=True, floor_hides_gap=True)
    assert decide(lost) == "explained"
    assert decide(replace(lost, explanation=False)) == "unexplained"
