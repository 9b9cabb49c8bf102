"""Every effect says in words what it is, what a robot with it does, what to look at, what its numbers are called."""

from __future__ import annotations

import re

import pytest

from snakebot.effects.effect import Effect
from snakebot.effects.registry import LIBRARY, find_effect
from snakebot.effects.spec import parse_effect
from snakebot.effects.telling import joints_in_words, sentence, shown, shown_span, title
from snakebot.in_words import listed, shortened, span, three


@pytest.mark.parametrize("name", LIBRARY)
def test_every_effect_of_the_library_is_told_in_words(name: str) -> None:
    effect = find_effect(name)
    assert title(effect) == effect.title != ""
    assert len(effect.look) > 30
    assert effect.look.endswith(".")
    assert effect.sentence
    for parameter in effect.parameters:
        assert parameter.words, parameter.name
        assert "_" not in parameter.words
        assert not re.search(r"_|rad_s", parameter.shown_unit)
    words = (effect.title, effect.sentence.replace("_", ""), effect.look)
    assert not any(re.search(r"[a-z]_[a-z]", text) for text in words)


@pytest.mark.parametrize("name", LIBRARY)
def test_its_sentence_stands_with_the_numbers_of_its_example(name: str) -> None:
    effect = find_effect(name)
    spec = parse_effect(effect.example)
    values = {p.name: p.default for p in effect.parameters if p.default is not None and p.fitted}
    for joints in ((3,), (2, 4), (1, 2, 3, 4, 5)):
        text = sentence(effect, {**values, **spec.values}, joints, 5)
        assert not re.search(r"[\[\]{}|_]|unknown", text), text
        assert not text[0].islower()
        assert not text.endswith(".")


def test_numbers_stand_in_the_units_of_a_lab_and_joints_in_words() -> None:
    limit = find_effect("rate_limit")
    assert (
        sentence(limit, {"limit_rad_s": 1.999979752561277}, (3,), 5)
        == "Joint 3 cannot turn faster than 2.00 rad/s"
    )
    delay = find_effect("command_delay")
    assert (
        sentence(delay, {"delay_s": 0.0452}, (1, 2, 4), 5)
        == "Joints 1, 2 and 4 get their commands 45.2 ms late"
    )
    assert shown_span(delay.parameter("delay_s"), (0.0431, 0.0472)) == "43 to 47 ms"
    assert shown(limit.parameter("limit_rad_s"), (1.2, 1.5)) == "1.20 and 1.50 rad/s"
    assert joints_in_words((1, 2), 2) == "all joints"
    assert joints_in_words((1,), 1) == "joint 1"


def test_many_joints_and_values_are_told_in_short() -> None:
    limit = find_effect("rate_limit").parameter("limit_rad_s")
    assert joints_in_words((1, 2, 3, 4), 5) == "joints 1, 2, 3 and 4"
    assert joints_in_words((1, 2, 3, 4, 5, 6, 7, 9), 11) == "joints 1 to 7 and 9"
    assert joints_in_words((1, 3, 5, 6, 11), 11) == "joints 1, 3, 5, 6 and 11"
    assert shown(limit, (2.3, 1.3, 1.5, 1.7, 1.9)) == "1.3 to 2.3 rad/s"
    assert shown(limit, (1.2, 1.2, 1.2)) == "1.20 rad/s"


def test_an_effect_of_another_package_needs_none_of_it() -> None:
    class Strange(Effect):
        name, stage, summary, mark = "strange_one", "servo", "Something is strange.", "It shows."
        example = "strange_one"

    assert title(Strange()) == "strange one"
    assert sentence(Strange(), {}, (2,), 5) == "Something is strange: joint 2"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1.999979, "2.00"),
        (0.0131234, "0.0131"),
        (1234.5, "1230"),
        (99.96, "100"),
        (1e-9, "1.00e-09"),
    ],
)
def test_three_digits(value: float, text: str) -> None:
    assert three(value) == text


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [(1.8, 2.3, "1.8 to 2.3"), (1.978, 2.021, "1.98 to 2.02"), (0.0, 3.2, "0.0 to 3.2"), (2.0, 2.0, "2.0")],
)
def test_an_interval(low: float, high: float, text: str) -> None:
    assert span(low, high) == text


def test_a_long_name_loses_its_middle() -> None:
    assert shortened("short") == "short"
    long = "20261121T081530Z_a_very_long_name_of_a_run_that_goes_on.mcap"
    assert len(shortened(long)) == 44
    assert shortened(long).startswith("20261121T081530Z")
    assert shortened(long).endswith("goes_on.mcap")


def test_a_list() -> None:
    assert listed([1]) == "1"
    assert listed([1, 2, 4]) == "1, 2 and 4"
    assert listed(["servo", "sensor"], "or") == "servo or sensor"


def test_a_share_has_no_unit_in_its_bounds() -> None:
    gain, width = find_effect("command_gain").parameters[0], find_effect("backlash").parameters[0]
    assert gain.bounds_text == "0.2 to 3"
    assert width.bounds_text.endswith(" deg")
