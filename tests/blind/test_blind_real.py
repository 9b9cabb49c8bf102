"""Expectations of real recordings: the file is sound, each kind of check can fail, the tool tells both."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from blind.real_checks import (
    ACROSS,
    KINDS,
    Check,
    ExpectationError,
    check_across,
    check_one,
    read_expectations,
)
from recordings import AT_HAND, REAL, Answers
from tool_calls import called

BARE, WEIGHT = "pwm_servo_pendulum/without_weight", "pwm_servo_pendulum/with_weight"


@pytest.fixture(scope="module")
def file(root: Path) -> Path:
    return root / "tools" / "blind" / "real_expectations.yaml"


def cause(effect: str, probability: float, ties: tuple[str, ...] = (), **values: float) -> dict[str, Any]:
    return {
        "effect": effect,
        "probability": probability,
        "indistinguishable_from": list(ties),
        "parameters": {name: {"estimate": value, "ci95": [value, value]} for name, value in values.items()},
    }


def answer(verdict: str, *causes: dict[str, Any], where: str = "", **changes: Any) -> dict[str, Any]:
    angle = {"rms_before": 0.8, "rms_after": 0.09, "rms_floor": None, "closed": 0.98, "ci95": [0.97, 0.99]}
    return {
        "verdict": verdict,
        "where": {"stage": "servo", "regime": "by speed"},
        "causes": list(causes),
        "closure": {"held_out_runs": ["a.csv"], "joint_angle": angle | changes},
        "unexplained": {"share": 0.2, "significant": verdict == "unexplained", "where": where},
        "warnings": ["the servo is off in 2% of the samples"],
    }


RIGHT = answer(
    "explained",
    cause("rate_limit", 0.8, limit_rad_s=5.0),
    cause("command_delay", 0.7, delay_s=0.05),
    cause("deadband", 0.4, ("backlash",), width_deg=1.8),
)


def broken(checks: list[Check]) -> set[str]:
    return {check.id for check in checks if check.holds is False}


def test_every_kind_of_check_is_used(file: Path) -> None:
    expected = read_expectations(file)
    parts = [expected.everywhere, *expected.recordings.values()]
    used = {rule["kind"] for part in parts for rule in [*part["should"], *part["must_not"]]}
    assert used == set(KINDS)
    assert {rule["kind"] for rule in expected.across} == set(ACROSS)
    assert all(
        rule["why"] for part in parts for rules in part.values() for rule in [*rules, *expected.across]
    )


def test_names_are_those_of_the_library(file: Path) -> None:
    from snakebot.effects import effects

    expected = read_expectations(file)
    parts = [expected.everywhere, *expected.recordings.values()]
    for rule in (rule for part in parts for rules in part.values() for rule in rules):
        for name in [*rule.get("effects", ()), *(rule[k] for k in ("of", "with", "effect") if k in rule)]:
            assert name in effects()
        if "parameter" in rule:
            assert rule["parameter"] in {p.name for p in effects()[rule["effect"]].parameters}


def test_what_was_expected_holds_nothing_against_it(file: Path) -> None:
    assert broken(check_one(read_expectations(file), BARE, RIGHT)) == set()


@pytest.mark.parametrize(
    ("given", "caught"),
    [
        (answer("explained", cause("command_delay", 0.7)), {"speed"}),
        (answer("explained", cause("rate_limit", 0.7, limit_rad_s=5.0)), {"late"}),
        (answer("explained", *RIGHT["causes"], cause("payload", 0.1)), {"no_body"}),
        (answer("explained", *RIGHT["causes"], cause("joint_free", 0.1)), {"not_broken"}),
        (answer("explained", *RIGHT["causes"], cause("clock_drift", 0.6)), {"no_clock"}),
        (answer("explained", *RIGHT["causes"], cause("clock_drift", 0.3)), set()),
        (answer("explained", *RIGHT["causes"], cause("encoder_offset", 0.3)), {"offset_either"}),
        (answer("explained", *RIGHT["causes"], cause("encoder_offset", 0.3, ("servo_offset",))), set()),
        (answer("explained", *RIGHT["causes"], cause("torque_speed", 0.9)), {"no_torque_resolved"}),
        (answer("explained", *RIGHT["causes"], cause("torque_speed", 0.9, ("rate_limit",))), set()),
        (answer("explained", *RIGHT["causes"], rms_after=0.2), {"error"}),
        (answer("explained", *RIGHT["causes"], rms_floor=0.02), {"no_repeats"}),
        (answer("explained", *RIGHT["causes"], ci95=None), {"held_out"}),
        (
            answer("explained", cause("rate_limit", 0.8, limit_rad_s=9.0), cause("servo_lag", 0.7)),
            {"speed_value"},
        ),
    ],
)
def test_each_departure_is_caught(file: Path, given: dict[str, Any], caught: set[str]) -> None:
    assert broken(check_one(read_expectations(file), BARE, given)) == caught


def test_under_weight_a_cause_without_load_is_not_the_whole_story(file: Path) -> None:
    expected = read_expectations(file)
    plain = [cause("rate_limit", 0.8, limit_rad_s=5.0), cause("command_delay", 0.8)]
    sure = answer("explained", *plain, rms_floor=0.04)
    assert broken(check_one(expected, WEIGHT, sure)) == {"load", "no_load"}
    rest = answer("unexplained", *plain, where="largest at high load", rms_floor=0.04)
    assert broken(check_one(expected, WEIGHT, rest)) == set()
    elsewhere = answer("unexplained", *plain, where="largest late in the run", rms_floor=0.04)
    assert broken(check_one(expected, WEIGHT, elsewhere)) == {"load_where", "rest_where"}
    loaded = answer("explained", *plain, cause("torque_limit", 0.6, ("torque_speed",)), rms_floor=0.04)
    assert broken(check_one(expected, WEIGHT, loaded)) == set()


def test_gains_of_the_folders_must_rise_and_gaps_fall(file: Path) -> None:
    expected = read_expectations(file)
    names = [f"xl330_pendulum/kp_{kp}" for kp in (100, 200, 400, 800)]

    def found(gains: list[float], gaps: list[float], stiffness: list[float]) -> set[str]:
        answers = {
            name: answer(
                "explained",
                cause("command_gain", 0.3, gain=g),
                cause("position_loop", 0.3, stiffness_nm_rad=k),
                rms_before=e,
            )
            for name, g, e, k in zip(names, gains, gaps, stiffness, strict=True)
        }
        return broken(check_across(expected, answers))

    double, falling = [1.0, 2.1, 3.9, 8.8], [0.7, 0.6, 0.5, 0.4]
    assert found([0.25, 0.4, 0.6, 0.7], falling, double) == set()
    assert found([0.25, 0.4, 0.3, 0.7], falling, double) == {"gain_shows"}
    assert found([0.25, 0.26, 0.27, 0.28], [0.7, 0.6, 0.5, 0.5], double) == {"gain_shows", "gap_shrinks"}
    assert found([0.25, 0.4, 0.6, 0.7], falling, [1.0, 2.1, 3.9, 9.3]) == {"loop_doubles"}
    unnamed = {name: answer("explained", cause("command_gain", 0.3, gain=0.25)) for name in names}
    assert "loop_doubles" in broken(check_across(expected, unnamed))
    assert check_across(expected, {names[0]: RIGHT}) == []


def test_a_file_that_is_no_expectation_is_refused(tmp_path: Path, file: Path) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text("- nonsense")
    with pytest.raises(ExpectationError, match="not of schema"):
        read_expectations(bad)
    bad.write_text(file.read_text().replace("kind: no_floor", "kind: hunch"))
    with pytest.raises(ExpectationError, match="no such kind of check: hunch"):
        read_expectations(bad)
    bad.write_text(file.read_text().replace("id: late", "id: on"))
    with pytest.raises(ExpectationError, match="an id is no word"):
        read_expectations(bad)
    bad.write_text(file.read_text().replace("id: late", "id: speed"))
    with pytest.raises(ExpectationError, match="stands twice"):
        read_expectations(bad)


def real(root: Path, *options: str) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, str(root / "tools" / "blind" / "real"), *options]
    return subprocess.run(words, capture_output=True, text=True)


def test_without_recordings_one_line_says_so(root: Path, tmp_path: Path) -> None:
    done = called(root / "tools" / "blind" / "real", str(tmp_path / "none"))
    assert done.returncode == 0
    assert done.stdout.startswith("skipped: ")
    assert done.stdout.count("\n") == 1


@pytest.mark.slow
@pytest.mark.timeout(1200)
@AT_HAND
def test_recordings_of_real_servos(root: Path, tmp_path: Path, answers: Answers) -> None:
    """The tables come out, and nothing is claimed that must not be; what is missed is on docs/blind-check-wire.md."""
    names = ["xl330_pendulum/kp_100", "xl330_pendulum/kp_800", BARE]
    for name in names:
        shutil.copy(answers.path(name), tmp_path)
    only = [word for name in names for word in ("--only", name)]
    done = real(root, str(REAL), "--out", str(tmp_path), "--resume", "--quick", *only)
    assert done.returncode == 0, done.stderr
    result = json.loads((tmp_path / "real.json").read_text())
    assert result["no_verdict"] == []
    assert {c["recording"] for c in result["checks"]} >= {BARE, "xl330_pendulum/kp_100"}
    assert [c for c in result["checks"] if c["must_not"] and c["holds"] is False] == []
    assert [c for c in result["checks"] if c["id"] in ("held_out", "power_off") and not c["holds"]] == []
    assert "as expected" in done.stdout


def test_commands_and_figures_of_the_page_are_those_of_the_code(root: Path) -> None:
    from blind.wire_cases import KINDS
    from blind.wire_runs import RUN_S, TRIES

    text = (root / "docs" / "blind-check-wire.md").read_text(encoding="utf-8")
    commands = [line.split() for line in text.splitlines() if line.startswith("    tools/")]
    assert {words[0] for words in commands} == {f"tools/blind/{name}" for name in ("wire", "live", "real")}
    for script, *words in commands:
        done = called(root / script, "--help")
        assert done.returncode == 0
        assert all(word in done.stdout for word in words if word.startswith("--"))
    assert (len(KINDS), RUN_S, TRIES) == (8, 8.0, 4)
    assert "eight kinds" in text
    assert "three gaits of 8 s" in text
    assert "up to four times" in text
