"""A cause that a fit drives to the end of what it may be is likely to be another one."""

from __future__ import annotations

import pytest
from sessions import bench, make_session

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.result import Cause, Estimate
from snakebot.diagnosis.sizes import UNLIKELY
from snakebot.diagnosis.verdict.at_end import at_end, held_back
from snakebot.effects.registry import find_effect


def cause(effect: str, parameters: dict[str, Estimate], probability: float = 0.9) -> Cause:
    return Cause(
        effect=effect,
        joints=(1,),
        stage="servo",
        probability=probability,
        parameters=parameters,
        specification=effect,
    )


@pytest.mark.parametrize("ci95", [(0.05, 0.08), (0.05, 0.5), (0.05, 40.0), None])
def test_a_limit_of_speed_of_next_to_nothing_is_told_and_held_back(ci95: tuple[float, float] | None) -> None:
    """However well it is known how little it is; and where nothing is known of it, there is no more to this effect."""
    stuck = cause("rate_limit", {"limit_rad_s": Estimate(estimate=0.05, ci95=ci95)})
    assert "at the end of what it may be" in (at_end(stuck) or "")
    assert held_back(stuck).probability == UNLIKELY


@pytest.mark.parametrize(
    ("effect", "name", "estimate"),
    [
        ("rate_limit", "limit_rad_s", Estimate(estimate=1.2, ci95=(1.1, 1.3))),  # well inside
        ("rate_limit", "limit_rad_s", Estimate(estimate=0.05, ci95=(0.05, 0.06), fixed=True)),  # given
        ("deadband", "width_deg", Estimate(estimate=0.0, ci95=(0.0, 0.01))),  # absent
        ("position_loop", "full_drive_deg", Estimate(estimate=360.0, ci95=(359.0, 360.0))),  # without a limit
    ],
)
def test_others_are_left_as_they_are(effect: str, name: str, estimate: Estimate) -> None:
    sound = cause(effect, {name: estimate})
    assert at_end(sound) is None
    assert held_back(sound) == sound


@pytest.mark.parametrize("ci95", [(0.05, 3.0), None])
def test_a_damping_that_the_data_do_not_care_about_is_no_end(ci95: tuple[float, float] | None) -> None:
    swing = {
        "natural_freq_rad_s": Estimate(estimate=20.0, ci95=(19.0, 21.0)),
        "damping_ratio": Estimate(
            estimate=find_effect("second_order").parameter("damping_ratio").lower, ci95=ci95
        ),
    }
    assert at_end(cause("second_order", swing)) is None


def test_a_dead_band_as_wide_as_one_may_be_is_a_joint_that_stands() -> None:
    still = {
        "width_deg": Estimate(estimate=30.0, ci95=(0.0, 30.0)),
        "hard": Estimate(estimate=0.0, ci95=None, fixed=True),
    }
    assert held_back(cause("deadband", still)).probability == UNLIKELY


def test_less_probability_is_not_raised() -> None:
    stuck = cause("rate_limit", {"limit_rad_s": Estimate(estimate=0.05, ci95=(0.05, 0.08))}, 0.1)
    assert held_back(stuck).probability == 0.1


def test_a_joint_that_stands_is_no_slow_one() -> None:
    session = make_session(bench(), ["joint_rigid:angle_deg=-8,joints=2"])
    found = diagnose(session, exclude=["joint_rigid"], quick=True)
    assert [(c.effect, c.probability) for c in found.causes] == [("rate_limit", UNLIKELY)]
    assert at_end(found.causes[0]) in found.warnings
