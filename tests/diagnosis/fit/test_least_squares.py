"""Bounded fits of a Cauchy loss."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from snakebot.arrays import Floats
from snakebot.diagnosis.fit.least_squares import minimise, multi_start, refit
from snakebot.diagnosis.fit.step import Problem

STEPS = 25  # more than any of these fits takes


def test_fit_of_several_units_at_once_finds_each_ones_parameters() -> None:
    x = np.linspace(0, 4, 200)[:, None]
    truth = np.array([[2.0, 0.5], [0.7, 3.0]])
    data = truth[:, 0] * np.exp(-x * truth[:, 1])

    def residual(theta: np.ndarray) -> np.ndarray:
        return np.asarray(data - theta[:, 0] * np.exp(-x * theta[:, 1]))

    block = (np.arange(200) // 20)[:, None] + np.array([0, 10])
    problem = Problem(
        residual, np.array([0, 1]), block, np.full(20, 1e-4), np.array([0.01, 0.01]), np.array([10.0, 10.0]),
        np.array([True, False]),
    )  # fmt: skip
    fit = multi_start(problem, [np.ones((2, 2)), np.full((2, 2), 5.0)], 2, STEPS)
    assert fit.theta == pytest.approx(truth, rel=1e-3)


def test_a_fit_stays_within_bounds() -> None:
    def residual(theta: np.ndarray) -> np.ndarray:
        return np.repeat(theta - 5.0, 10, axis=0)

    block = np.zeros((10, 1), dtype=np.int64)
    problem = Problem(
        residual, np.array([0]), block, np.ones(1), np.array([0.0]), np.array([2.0]), np.array([False])
    )
    assert minimise(problem, np.array([[1.0]]), STEPS).theta[0, 0] == pytest.approx(2.0)


def test_half_or_less_of_a_step_that_failed_is_tried_next() -> None:
    """Behind steps that succeeded the damping is next to none: a little more of it would be the same step."""
    tried: list[float] = []

    def residual(theta: np.ndarray) -> np.ndarray:
        tried.append(float(theta[0, 0]))
        # slopes before a wall tell nothing of what lies behind
        return np.where(theta[0, 0] < 3.0, theta[0, 0] - 8.0, 50.0) * np.ones((10, 1))

    block = np.zeros((10, 1), dtype=np.int64)
    box = (np.array([-10.0]), np.array([100.0]), np.array([False]))
    problem = Problem(residual, np.array([0]), block, np.full(1, 1e6), *box, secant=True)
    fit = minimise(problem, np.array([[0.0]]), STEPS, covariance=False)
    assert 2.7 < fit.theta[0, 0] < 3.0
    first = next(i for i, theta in enumerate(tried) if theta >= 3.0)
    assert tried[first] == pytest.approx(8.0, rel=0.01)
    assert 0.1 * 8.0 * 0.99 < tried[first + 1] < 0.5 * 8.0


def ramp_problem(slope: float, noise: float = 0.0) -> Problem:
    """A straight line through zero, its slope unknown; forty samples in four blocks."""
    x = np.arange(1.0, 41.0)[:, None]
    seen = slope * x + noise * np.random.default_rng(3).normal(size=x.shape)
    block = np.repeat(np.arange(4), 10)[:, None]
    box = (np.array([0.0]), np.array([10.0]), np.array([False]))
    return Problem(lambda theta: theta[0, 0] * x - seen, np.zeros(1, dtype=np.int64), block, np.ones(4), *box)


def test_a_refit_is_the_minimum_of_what_counts() -> None:
    problem = ramp_problem(2.0, noise=0.5)
    whole = minimise(problem, np.array([[1.0]]), STEPS).theta[0]
    for out in range(4):
        use = problem.block != out
        left = replace(problem, block=np.where(use, problem.block, -1))
        exact = minimise(left, whole[None], STEPS).theta[0]
        (near,) = refit(problem, whole[None], [use])
        assert near.theta[0] == pytest.approx(exact, abs=0.2 * abs(exact - whole)[0] + 1e-6)


def far_steps_problem() -> tuple[Problem, Floats]:
    """What is seen in a first block wants 1, in a second 9, where the curve is so flat that a straight line leads far
    beyond; and a place between the two.
    """

    def residual(theta: np.ndarray) -> np.ndarray:
        return np.asarray(np.arctan(4 * (theta[0, 0] - np.repeat([1.0, 9.0], 10)))[:, None])

    box = (np.array([-100.0]), np.array([100.0]), np.array([False]))
    block = np.repeat([0, 1], 10)[:, None]
    return Problem(residual, np.zeros(1, dtype=np.int64), block, np.full(2, 0.1), *box), np.array([[3.0]])


@pytest.mark.parametrize("out", [0, 1])
@pytest.mark.parametrize("body", [False, True])
def test_a_refit_that_would_go_too_far_goes_less_far(out: int, body: bool) -> None:
    problem, start = far_steps_problem()
    if body:  # judged by what costs less
        cheap = problem
        problem = replace(problem, near=lambda theta: cheap, near_for=np.array([True]))
    use = problem.block != out

    def left(theta: Floats) -> float:
        return float(np.square(problem.residual(theta)[use]).sum())

    (near,) = refit(problem, start, [use])
    assert left(near.theta) < left(start)
    (far,) = refit(replace(problem, near=None, secant=True), start, [use])
    assert left(far.theta) > left(start), "one straight step leads too far here"


def test_no_search_begins_where_what_is_fitted_does_nothing() -> None:
    """A limit above all that is seen costs as little as none, and a search that starts there stays there."""
    x = np.linspace(0, 2, 40)[:, None]
    seen = np.minimum(x, 1.6)

    def residual(theta: np.ndarray) -> np.ndarray:
        return np.asarray(np.minimum(x, theta[0, 0]) - seen)

    box = (np.array([0.1]), np.array([10.0]), np.array([False]))
    block = np.zeros((40, 1), dtype=np.int64)
    problem = Problem(residual, np.zeros(1, dtype=np.int64), block, np.ones(1), *box)
    starts = [np.array([[5.0]]), np.array([[0.9]])]
    assert multi_start(problem, starts, 1, STEPS).theta[0, 0] == pytest.approx(5.0)
    awake = replace(problem, idle=residual(np.array([[np.inf]])))
    assert multi_start(awake, starts, 1, STEPS).theta[0, 0] == pytest.approx(1.6, abs=1e-3)


@pytest.mark.parametrize(("stride", "end"), [(0.0, 0.0), (0.02, 0.1)])
def test_a_parameter_that_acts_by_whole_ticks_is_found_over_a_stride(stride: float, end: float) -> None:
    """A delay of held set-points: small changes of it show nothing."""
    tick_s = 0.02
    t = np.arange(200) * tick_s

    def late(delay_s: float) -> np.ndarray:
        return np.asarray(np.sin(2 * (t - tick_s * np.ceil(delay_s / tick_s - 1e-9))))

    def residual(theta: np.ndarray) -> np.ndarray:
        return np.asarray((late(0.1) - late(theta[0, 0]))[:, None])

    block = (np.arange(200) // 20)[:, None]
    box = (np.zeros(1), np.array([0.5]), np.zeros(1, dtype=bool), np.array([stride]))
    problem = Problem(residual, np.zeros(1, dtype=np.int64), block, np.full(10, 1e-6), *box)
    found = minimise(problem, np.array([[0.011]]), STEPS).theta[0, 0]
    assert found == pytest.approx(0.011 if stride == 0 else end, abs=0.011 if stride else 1e-9)


def test_parameters_that_share_no_column_are_perturbed_together_and_come_out_alike() -> None:
    x, calls = np.linspace(0, 4, 100)[:, None], [0]
    truth = np.array([2.0, 0.7, 1.4, 0.3])

    def residual(theta: np.ndarray) -> np.ndarray:
        calls[0] += 1
        size, rate = theta[0, :2], theta[0, 2:]
        return np.asarray(truth[:2] * np.exp(-x * truth[2:]) - size * np.exp(-x * rate))

    block = (np.arange(100) // 10)[:, None] + np.array([0, 10])
    problem = Problem(
        residual, np.array([0, 0]), block, np.full(20, 1e-4), np.full(4, 0.01), np.full(4, 10.0),
        np.zeros(4, dtype=bool),
    )  # fmt: skip
    plain = minimise(problem, np.ones((1, 4)), STEPS, covariance=False)
    alone, calls[0] = calls[0], 0
    touches = np.array([[True, False], [False, True], [True, False], [False, True]])
    together = minimise(replace(problem, touches=touches), np.ones((1, 4)), STEPS, covariance=False)
    assert together.theta == pytest.approx(plain.theta, rel=1e-9)
    assert calls[0] < 0.8 * alone


def test_carried_slopes_lead_to_the_same_end_with_fewer_residuals() -> None:
    x = np.linspace(0, 4, 200)[:, None]
    truth = np.array([2.0, 1.5, 0.7, 0.3])
    calls = []

    def curve(t: np.ndarray) -> np.ndarray:
        return np.asarray(t[0] * np.exp(-x * t[1]) + t[2] * np.sin(x + t[3]))

    def residual(theta: np.ndarray) -> np.ndarray:
        calls.append(1)
        return np.asarray(curve(truth) - curve(theta[0]))

    block = (np.arange(200) // 20)[:, None]
    box = (np.full(4, 0.01), np.full(4, 10.0), np.zeros(4, dtype=bool))
    exact = Problem(residual, np.zeros(1, dtype=np.int64), block, np.full(10, 1e-4), *box)
    ends, needed = [], []
    for problem in (exact, replace(exact, secant=True)):
        calls.clear()
        ends.append(minimise(problem, np.ones((1, 4)), STEPS))
        needed.append(len(calls))
    assert ends[0].theta[0] == pytest.approx(truth, rel=1e-3)
    assert ends[1].theta[0] == pytest.approx(truth, rel=1e-3)
    assert needed[1] < 0.8 * needed[0]
