"""Ranges and limits: what ``--within`` may say, and that no gait leaves them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snakebot.control.plans import RAMP_S
from snakebot.errors import BadInputError
from snakebot.gait import Gait, GaitMotion, check_motion
from snakebot.optimise.space import Space, parse_within
from snakebot.robot import Limits, load_robot

ROBOT = load_robot("penn_state")
ranges = st.tuples(st.floats(1, 60), st.floats(1, 40)).map(lambda ends: (ends[0], ends[0] + ends[1]))


@given(
    alpha=ranges, omega=st.tuples(st.floats(0.2, 3), st.floats(0, 5)), speed=st.floats(0.5, 8),
    acceleration=st.floats(2, 60), wanted=st.tuples(st.floats(0.01, 3), st.floats(-4, 4), st.floats(0.01, 20)),
)  # fmt: skip
def test_a_gait_moved_into_the_space_breaks_no_limit(
    alpha: tuple[float, float], omega: tuple[float, float], speed: float, acceleration: float,
    wanted: tuple[float, float, float],
) -> None:  # fmt: skip
    limits = Limits(angle_deg=70, speed_rad_s=speed, acceleration_rad_s2=acceleration)
    robot = ROBOT.model_copy(update={"limits": limits})
    within = {"alpha": alpha, "omega": (omega[0], omega[0] + omega[1])}
    try:
        space = Space.of(robot, within)
    except BadInputError:
        return
    for gait in (*space.nearest(np.array([wanted])), *space.grid(3, 2, 3)):
        a, b, w = gait
        assert np.radians(alpha[0]) * (1 - 1e-9) <= a <= np.radians(min(alpha[1], 70)) * (1 + 1e-9)
        assert space.beta_rad[0] <= b <= space.beta_rad[1]
        assert omega[0] * (1 - 1e-9) <= w <= (omega[0] + omega[1]) * (1 + 1e-9)
        assert a * w <= speed * (1 + 1e-9)
        assert a * w**2 <= acceleration * (1 + 1e-9)


@pytest.mark.parametrize(
    ("speed", "low"), [(0.5, 0.5), (0.5846915400456766, 0.5), (0.5, 0.49981329949697206)]
)
def test_the_widest_amplitude_leaves_the_slowest_omega(speed: float, low: float) -> None:
    """Rounding left an omega below the range, by the spacing of the table of swings."""
    limits = Limits(angle_deg=70, speed_rad_s=speed, acceleration_rad_s2=2)
    within = {"alpha": (20.0, 50.0), "omega": (low, 3.0)}
    space = Space.of(ROBOT.model_copy(update={"limits": limits}), within)
    omegas = [*space.grid(3, 2, 3)[:, 2], *space.nearest(np.array([[1.0, 1.0, 1.0]]))[:, 2]]
    assert min(omegas) >= low


def test_gaits_of_the_grid_pass_the_check_before_a_run() -> None:
    limits = Limits(angle_deg=50, speed_rad_s=1.5, acceleration_rad_s2=4)
    robot = ROBOT.model_copy(update={"limits": limits})
    for a, b, w in Space.of(robot).grid(4, 2, 4):
        check_motion(GaitMotion(Gait(a, b, w), robot.joints, 30.0, RAMP_S), robot)


def test_what_binds_is_told() -> None:
    robot = ROBOT.model_copy(update={"limits": Limits(angle_deg=50, speed_rad_s=2, acceleration_rad_s2=60)})
    space = Space.of(robot, margin=0.2)
    gait = np.array([np.radians(50), 1.5, 2 / np.radians(50)])
    assert space.binds(gait, 0.5) == ["joint angle", "joint speed"]
    assert "torque" in space.binds(gait, 0.8)
    assert space.binds(np.array([0.5, 1.5, 1.0]), 0.1) == []


def test_ranges_are_read() -> None:
    assert parse_within(None) == {}
    assert parse_within("alpha=20..60, omega=1..4") == {"alpha": (20, 60), "omega": (1, 4)}
    assert parse_within("beta=-90..-30") == {"beta": (-90, -30)}


@pytest.mark.parametrize(
    "text", ["", "alpha", "alpha=3", "alpha=5..x", "alpha=9..3", "omega=0..3", "alpha=1..2,alpha=1..2",
             "beta=nan..4", "omga=1..2", "alpha=1..2..3"],
)  # fmt: skip
def test_other_ranges_are_refused_in_one_line(text: str) -> None:
    with pytest.raises(BadInputError, match=r"^--within") as error:
        parse_within(text)
    assert "\n" not in str(error.value)


def test_ranges_outside_of_the_limits_are_refused() -> None:
    with pytest.raises(BadInputError, match="allows 95 deg"):
        Space.of(ROBOT, {"alpha": (100, 120)})
    with pytest.raises(BadInputError, match="allows joints 8 rad/s"):
        Space.of(ROBOT, {"alpha": (80, 90), "omega": (30, 40)})
    with pytest.raises(BadInputError, match="--margin"):
        Space.of(ROBOT, margin=1.0)


def test_no_gait_is_asked_for_whose_cycle_takes_minutes() -> None:
    with pytest.raises(BadInputError, match="at least"):
        parse_within("omega=1e-9..1e-8")
