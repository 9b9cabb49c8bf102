"""The least of a quadratic within bounds is what a library finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from snakebot.diagnosis.evidence.within_bounds import minimum_within


@settings(deadline=None)  # the first call may compile a kernel
@given(st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_within_bounds_the_minimum_is_that_of_a_library(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(count + 3, count)) * 10.0 ** rng.uniform(-1, 1, count)
    wanted, edge = rng.normal(size=count + 3), rng.uniform(0.01, 1, (2, count))
    least, most = -edge[0] * rng.integers(0, 2, count), edge[1]
    begin = rng.uniform(least, most)
    share = minimum_within(root.T @ root, root.T @ wanted, least, most, begin)
    assert np.all((share >= least) & (share <= most))
    known = lsq_linear(root, wanted, (least, most), method="bvls", tol=1e-14).x
    left, least_left = (np.linalg.norm(root @ x - wanted) for x in (share, known))
    assert left == pytest.approx(least_left, rel=1e-6)
