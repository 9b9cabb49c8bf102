"""``effect``, ``gait``: what is there by name; and what a shell completes."""

from __future__ import annotations

import json

import pytest
from click.shell_completion import ShellComplete
from click.testing import CliRunner

from snakebot.cli.main import cli
from snakebot.effects.registry import LIBRARY
from snakebot.errors import BadInputError


def call(*arguments: str) -> str:
    result = CliRunner().invoke(cli, arguments, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def completed(*line: str) -> list[str]:
    shell = ShellComplete(cli, {}, "snakebot", "_SNAKEBOT_COMPLETE")
    return [item.value for item in shell.get_completions(list(line[:-1]), line[-1])]


def test_effects_are_listed_in_the_order_of_the_signal_and_told_in_words() -> None:
    lines = call("effect", "list").splitlines()
    assert len(lines) >= len(LIBRARY)
    assert any(line.split()[:2] == ["backlash", "servo"] and "play in the gear" in line for line in lines)
    assert {row["stage"] for row in json.loads(call("effect", "list", "--stage", "body", "--json"))} == {
        "body"
    }
    shown = call("effect", "show", "backlash")
    assert "backlash: play in the gear (servo)" in shown
    assert "Its mark: After each reversal" in shown
    assert "width_deg: full play, 0 to 40 deg" in shown
    assert (
        json.loads(call("effect", "show", "rate_limit", "--json"))["parameters"][0]["words"] == "fastest turn"
    )


def test_a_misspelt_effect_or_gait_is_guessed() -> None:
    with pytest.raises(BadInputError, match="did you mean backlash"):
        CliRunner().invoke(cli, ["effect", "show", "baklash"], catch_exceptions=False)
    with pytest.raises(BadInputError, match="did you mean gentle"):
        CliRunner().invoke(cli, ["gait", "show", "gentel"], catch_exceptions=False)


def test_gaits_say_what_they_ask_of_a_robot() -> None:
    assert "penn_state_optimum  alpha" in call("gait", "list")
    assert json.loads(call("gait", "list", "--json"))[0]["name"] == "gentle"
    assert "within the limits of penn_state" in call("gait", "show", "gentle")
    told = json.loads(call("gait", "show", "gentle", "--json"))
    assert told["most_speed_rad_s"] == pytest.approx(0.174533, abs=1e-5)
    assert told["refused"] is None


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        (("run", "--robot", "sai"), ["saito", "saito_wheeled"]),
        (("robot", "show", "penn"), ["penn_state"]),
        (("run", "--gait", "g"), ["gentle"]),
        (("run", "--effect", "rate"), ["rate_limit"]),
        (("run", "--effect", "backlash:"), ["backlash:width_deg=", "backlash:loaded=", "backlash:joints="]),
        (("run", "--effect", "backlash:width_deg=3,jo"), ["backlash:width_deg=3,joints="]),
        (("run", "--effect", "worn"), ["worn_servo"]),
        (("effect", "show", "enc"), ["encoder_gain", "encoder_offset", "encoder_noise"]),
        (("diagnose", "--only", "joint_f"), ["joint_friction", "joint_free"]),
        (("jog", "--joint", ""), ["1", "2", "3", "4", "5"]),
        (("run", "--port", "sim"), ["sim:"]),
    ],
)
def test_a_shell_completes_names(line: tuple[str, ...], wanted: list[str]) -> None:
    assert completed(*line) == wanted


def test_where_no_name_fits_files_are_completed() -> None:
    shell = ShellComplete(cli, {}, "snakebot", "_SNAKEBOT_COMPLETE")
    (item,) = shell.get_completions(["run", "--robot"], "my/robot")
    assert item.type == "file"
