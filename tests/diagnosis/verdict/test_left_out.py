"""What may not be named must not be named by another word."""

from __future__ import annotations

import pytest
from sessions import bench, make_session

from snakebot.diagnosis import diagnose
from snakebot.diagnosis.options import Options
from snakebot.diagnosis.result import Cause
from snakebot.diagnosis.show.words import summary
from snakebot.diagnosis.sizes import UNLIKELY
from snakebot.diagnosis.verdict.left_out import (
    another_word,
    doubted_for_left_out,
    told_of_left_out,
)
from snakebot.effects.effect import Usual
from snakebot.effects.spec import parse_effect

USUAL = Usual(load_nm=1.0, rate_rad_s=1.0)


def cause(specification: str, probability: float = 0.9) -> Cause:
    return Cause(
        effect=parse_effect(specification).name,
        joints=(1, 2),
        stage="servo",
        probability=probability,
        parameters={},
        specification=specification,
    )


@pytest.mark.parametrize(
    ("specification", "plain"),
    [
        ("voltage_sag:initial_rad_s=2,drop_per_s=0", "rate_limit"),
        ("torque_limit:limit_nm=0.1", "joint_free"),
        ("joint_friction:coulomb_nm=0,stiffness_nm_rad=9", "compliance"),
        ("second_order:natural_freq_rad_s=250,damping_ratio=4.9", "servo_lag"),
    ],
)
def test_a_cause_that_comes_to_what_was_left_out_is_held_back_and_told(
    specification: str, plain: str
) -> None:
    found, options = cause(specification), Options(exclude=(plain,))
    assert another_word(found, USUAL, options) == plain
    assert doubted_for_left_out(found, USUAL, options.exclude, options).probability == UNLIKELY
    (warning,) = told_of_left_out([], [found], USUAL, options.exclude, options)
    assert f"is, with these values, just {plain}, which was left out" in warning


@pytest.mark.parametrize(
    ("specification", "exclude"),
    [
        ("voltage_sag:initial_rad_s=2,drop_per_s=0", ()),  # the plainer one was tried, and did not do
        ("voltage_sag:initial_rad_s=2,drop_per_s=0.1", ("rate_limit",)),  # it sags
        ("torque_limit:limit_nm=0.4,joints=1", ("joint_free",)),
        ("voltage_sag:initial_rad_s=2+3,drop_per_s=0+0,joints=1+2", ("rate_limit",)),  # each joint its own
        ("command_delay:delay_s=0.05", ("servo_lag",)),  # nothing is plainer
    ],
)
def test_others_are_left_as_they_are(specification: str, exclude: tuple[str, ...]) -> None:
    found, options = cause(specification), Options(exclude=exclude)
    assert doubted_for_left_out(found, USUAL, (), options) == found
    assert told_of_left_out([], [found], USUAL, (), options) == []


@pytest.mark.parametrize(
    ("drop_per_s", "said"),
    [
        (0.1, ["rate_limit was left out", "torque_limit was left out"]),
        (0.0, ["torque_limit was left out", "voltage_sag is, with these values"]),
    ],
)
def test_another_word_is_not_told_as_the_same_mark_once_more(drop_per_s: float, said: list[str]) -> None:
    found = cause(f"voltage_sag:initial_rad_s=2,drop_per_s={drop_per_s}")
    options = Options(exclude=("rate_limit", "torque_limit"))
    told = told_of_left_out(["voltage_sag"], [found, found], USUAL, options.exclude, options)
    assert [line[: len(start)] for line, start in zip(told, said, strict=True)] == said


@pytest.mark.parametrize(
    ("options", "ties", "probability"),
    [
        (Options(exclude=("encoder_gain",)), (), 0.45),
        (Options(absent=("encoder_gain",)), (), 0.9),  # whoever knows that it is not there
        (Options(exclude=("backlash",)), (), 0.9),  # no look-alike
        (Options(exclude=("encoder_gain", "servo_lag")), (), 0.3),
        (Options(exclude=("servo_lag",)), ("encoder_gain",), 0.6),
    ],
)
def test_a_look_alike_that_may_not_be_named_has_its_part_of_the_probability(
    options: Options, ties: tuple[str, ...], probability: float
) -> None:
    found = cause("command_gain:gain=0.9").model_copy(update={"indistinguishable_from": ties})
    assert doubted_for_left_out(found, USUAL, options.exclude, options).probability == pytest.approx(
        probability
    )


def test_an_encoder_that_may_not_be_named_makes_the_joint_a_guess() -> None:
    session = make_session(bench(), ["encoder_gain:gain=0.93,joints=2"])
    found = diagnose(session, exclude=["encoder_gain"], quick=True)
    assert [c.effect for c in found.causes] == ["command_gain"]
    assert found.causes[0].probability < 0.5
    assert any(
        "an effect that would look the same may not be named" in line.lower() for line in summary(found)
    )
    assert any("--absent encoder_gain" in w for w in found.warnings)
    assert diagnose(session, only=["command_gain"], quick=True).causes[0].probability > 0.85
    sure = diagnose(session, absent=["encoder_gain"], exclude=["encoder_gain"], quick=True)
    assert [c.effect for c in sure.causes] == ["command_gain"]
    assert sure.causes[0].probability > 0.85
    assert not any("left out" in w for w in sure.warnings)


def test_less_probability_is_not_raised() -> None:
    found = cause("voltage_sag:initial_rad_s=2,drop_per_s=0", 0.1)
    options = Options(exclude=("rate_limit",))
    assert doubted_for_left_out(found, USUAL, options.exclude, options).probability == 0.1


def test_a_constant_limit_of_speed_is_no_supply_that_falls() -> None:
    session = make_session(bench(), ["rate_limit:limit_rad_s=1.2,joints=2"])
    found = diagnose(session, exclude=["rate_limit", "torque_speed"], quick=True)
    assert {c.effect: c.probability for c in found.causes}["voltage_sag"] == UNLIKELY
    assert any("with these values, just a limit of speed, which" in line for line in summary(found))


def test_what_this_robot_cannot_have_has_no_part_of_the_probability() -> None:
    """A load on an arm that nobody described, of a bench without one."""
    session = make_session(bench(), ["servo_offset:offset_deg=3,joints=2"])
    found = diagnose(
        session, exclude=["arm_payload", "encoder_offset"], absent=["encoder_offset"], quick=True
    )
    assert found.causes[0].effect == "servo_offset"
    assert found.causes[0].probability > 0.85
    assert not any("left out" in w for w in found.warnings)
