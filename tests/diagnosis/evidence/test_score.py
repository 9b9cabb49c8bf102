"""What a score credits, and what it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.diagnosis.evidence.score import GROUND, Scoring

JOINT = np.array([0] * 20 + [1] * 20 + [GROUND] * 20)  # of each block; joint 1 alone has a gap
NOMINAL = np.where(JOINT == 1, 25.0, 1.0)


@pytest.fixture
def scoring() -> Scoring:
    ones = np.ones(JOINT.size)
    plain = Scoring(
        joints=2, run=np.tile([0, 1], JOINT.size // 2), joint=JOINT, kind=np.full(JOINT.size, -1), samples=ones,
        floor_square=ones, allowed_square=ones, decides=np.ones(JOINT.size, dtype=bool),
    )  # fmt: skip
    return plain.without_credit(JOINT != 1, NOMINAL)


def scattered(about: float) -> Floats:
    """Mean squares about so many times the nominal ones, higher and lower by turns."""
    return np.asarray(NOMINAL * about * np.tile([1.5, 1 / 1.5], JOINT.size // 2))


@pytest.mark.parametrize("about", [0.6, 0.95])
def test_where_there_is_no_gap_doing_better_or_as_well_is_neither_credit_nor_debit(
    scoring: Scoring, about: float
) -> None:
    """By chance every explanation is worse in some blocks: these alone would speak against it."""
    found = scoring.credited(scattered(about))
    healthy = JOINT != 1
    assert np.array_equal(found[healthy], NOMINAL[healthy])
    assert np.array_equal(found[~healthy], scattered(about)[~healthy])


def test_doing_worse_where_there_is_no_gap_is_a_debit_of_that_joint_alone(scoring: Scoring) -> None:
    square = np.where(JOINT == 0, scattered(1.4), scattered(0.9))
    found = scoring.credited(square)
    assert np.array_equal(found[JOINT == 0], square[JOINT == 0])
    assert np.array_equal(found[JOINT == GROUND], NOMINAL[JOINT == GROUND])


def test_blocks_that_decide_nothing_have_no_say(scoring: Scoring) -> None:
    """The user holds some runs out: what an explanation does there is no evidence for it."""
    some = replace(scoring, decides=scoring.run == 0)
    square = np.where(scoring.run == 0, 1.2, 0.2) * NOMINAL
    assert np.array_equal(some.credited(square)[JOINT == 0], square[JOINT == 0])
