"""Which joints are named as those where the gap lies: of a real robot every joint has a little of one."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.diagnosis.evidence.gap import Gap, named_joints


@pytest.mark.parametrize(
    ("square", "significant", "named"),
    [
        ([1.0, 50.0, 2.0], [True, True, True], (2,)),
        ([1.0, 50.0, 30.0], [True, True, True], (2, 3)),
        ([1.0, 1.0, 0.9], [True, False, True], (1, 3)),
        ([0.0, 0.0, 0.0], [False, False, False], ()),
    ],
)
def test_joints_with_little_of_the_gap_are_not_named(
    square: list[float], significant: list[bool], named: tuple[int, ...]
) -> None:
    assert named_joints(Gap(np.array(square), np.array(significant), float("nan"), False)) == named
