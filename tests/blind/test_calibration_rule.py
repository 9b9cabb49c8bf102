"""The rule that turns evidence into a probability: fitted anew, or the present one carried on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from calibration import fit

from snakebot.arrays import Floats
from snakebot.diagnosis.verdict.probability import CauseFeatures, calibration


def causes(count: int, rng: np.random.Generator) -> list[CauseFeatures]:
    return [
        CauseFeatures(
            lead=rng.uniform(0, 2), rest=1.0, closed=rng.uniform(0.2, 0.99), share=rng.uniform(0.01, 1.0), motions=5,
            explained=bool(rng.random() < 0.5), own=bool(rng.random() < 0.3), worn=True, together=3,
        )
        for _ in range(count)
    ]  # fmt: skip


def chance(intercept: float, weights: Sequence[float], some: list[CauseFeatures]) -> Floats:
    x = np.array([c.vector() for c in some]) @ np.array(weights)
    return np.asarray(1 / (1 + np.exp(-(intercept + x))))


def present(some: list[CauseFeatures]) -> Floats:
    return chance(calibration().intercept, calibration().weights, some)


def test_causes_as_the_present_rule_says_leave_it_as_it_is() -> None:
    rng = np.random.default_rng(0)
    some = causes(400, rng)
    right = rng.random(400) < present(some)
    intercept, weights = fit(some, list(right), calibration())
    np.testing.assert_allclose(
        [intercept, *weights], [calibration().intercept, *calibration().weights], atol=0.5
    )


def test_many_causes_that_are_all_wrong_make_it_say_less_and_few_hardly() -> None:
    rng = np.random.default_rng(1)
    some = causes(400, rng)
    before = present(some)
    many = fit(some, [False] * 400, calibration())
    own = [c for c in some if c.own]
    few = fit(own[:4], [False] * 4, calibration())
    assert chance(*many, some).mean() < 0.5 * before.mean()
    assert chance(*few, own).mean() > 0.8 * present(own).mean()
