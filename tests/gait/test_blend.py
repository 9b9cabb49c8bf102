"""The blend of all ramps: one curve, for numbers and for arrays, and its integral."""

from __future__ import annotations

import numpy as np
import pytest

from snakebot.gait.blend import (
    BLEND_PEAK_CURVATURE,
    BLEND_PEAK_SLOPE,
    blend,
    blend_integral,
    blend_integrals,
    blends,
)

S = np.linspace(-0.5, 1.5, 2001)


def test_numbers_and_arrays_are_of_one_curve() -> None:
    assert blends(S) == pytest.approx([blend(s) for s in S], abs=1e-15)
    assert blend_integrals(S) == pytest.approx([blend_integral(s) for s in S], abs=1e-15)


def test_it_goes_from_0_to_1_and_is_constant_outside() -> None:
    assert (blend(-1.0), blend(0.0), blend(0.5), blend(1.0), blend(2.0)) == (0.0, 0.0, 0.5, 1.0, 1.0)
    assert (blend_integral(-1.0), blend_integral(1.0), blend_integral(3.0)) == (0.0, 0.5, 2.5)


def test_the_integral_is_that_of_the_blend() -> None:
    middle = 0.5 * (blends(S)[1:] + blends(S)[:-1])
    assert blend_integrals(S) == pytest.approx(
        np.concatenate([[0.0], np.cumsum(middle * np.diff(S))]), abs=1e-6
    )


def test_its_largest_slope_and_curvature_are_those_stated() -> None:
    slope = np.gradient(blends(S), S)
    assert slope.max() == pytest.approx(BLEND_PEAK_SLOPE, rel=1e-4)
    assert np.abs(np.gradient(slope, S)).max() == pytest.approx(BLEND_PEAK_CURVATURE, rel=1e-2)
