"""Another explanation than the true one will do where the robot moves by it as it does."""

from __future__ import annotations

from typing import Any

import foretelling
import numpy as np
import pytest
from blind.cases import Case, Effect, Label, make_case
from blind.faults import FAULTS
from blind.motions import draw_motions
from blind.robot import Build, real_robot
from foretelling import case_of, differences_rad, foretells_the_same

from snakebot.diagnosis.proposal.menu import menu
from snakebot.robot import load_robot

FLOOR_RAD = 0.003
SNAKE = load_robot("penn_state")


@pytest.fixture(autouse=True)
def short_menu(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two motions of it: each takes the true robot a second."""
    monkeypatch.setattr(foretelling, "menu", lambda *given, **options: menu(*given, **options)[-2:])


def case_with(name: str, magnitude: float) -> Case:
    """The built-in robot, as healthy ones are off it, with one effect on all joints."""
    build, rng = Build(), np.random.default_rng(3)
    sound = real_robot(rng, build)
    faulty = sound.copy()
    values = FAULTS[name].apply(faulty, np.arange(build.joints), magnitude, np.random.default_rng(0))
    effect = Effect(name, FAULTS[name].stage, None, {k: float(v) for k, v in values.items()}, 5.0)
    label = Label("left_out", 5.0, [effect], FLOOR_RAD, FLOOR_RAD, build.joints)
    return Case(label, name, draw_motions(rng, 2, build.joints), build, faulty, rng, sound)


def said(*specifications: str) -> dict[str, Any]:
    return {"causes": [{"specification": text} for text in specifications]}


def test_an_offset_told_as_one_of_the_other_side_foretells_the_same_and_a_smaller_one_does_not() -> None:
    case = case_with("encoder_offset", 2.0)
    (offset_deg,) = case.label.effects[0].values.values()
    same = said(f"servo_offset:offset_deg={offset_deg}")
    readings, changes = differences_rad(SNAKE, case, same).T
    assert np.all(changes < 0.1 * FLOOR_RAD)
    assert np.all(readings > changes)  # the healthy robot is off as well
    assert foretells_the_same(SNAKE, case, same)
    assert not foretells_the_same(SNAKE, case, said(f"servo_offset:offset_deg={offset_deg / 2}"))
    assert not foretells_the_same(SNAKE, case, said())


def test_what_takes_the_place_of_a_stated_number_is_measured_by_the_readings() -> None:
    case = case_with("servo_lag", 0.03)
    case.sound.joint("lag_s")[:] *= 1.3  # type: ignore[union-attr]  # a healthy robot that is far off
    (lag_s,) = case.label.effects[0].values.values()
    of_session, _ = differences_rad(SNAKE, case, said(f"servo_lag:time_constant_s={lag_s}"))
    readings, changes = of_session
    assert readings < FLOOR_RAD < changes


@pytest.mark.slow
def test_a_case_is_drawn_again_from_its_label() -> None:
    made = {"set": "tune", "seed": 1, "cases": 24}
    number = next(n for n in range(24) if make_case("tune", 1, n, 24).label.stratum == "left_out")
    label = make_case("tune", 1, number, 24).label.mapping()
    assert case_of(made, label).label.mapping() == label
    with pytest.raises(LookupError):
        case_of(made, {**label, "asked_size": -1.0})
