"""Pictures of a score: what counts as wrongly named, its trace, and what was said beside what was right."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from blind.pictures import draw, draw_reliability, reliability
from blind.scores import accused
from blind.traces import Trace, draw_traces

PNG = b"\x89PNG"


def _answer(effect: str, probability: float, *alike: str) -> dict[str, Any]:
    cause = {"effect": effect, "probability": probability, "indistinguishable_from": list(alike)}
    return {"verdict": "explained", "causes": [cause]}


@pytest.mark.parametrize(
    ("stratum", "true", "answer", "wrong"),
    [
        ("single", ["backlash"], _answer("deadband", 0.8), True),
        ("single", ["backlash"], _answer("deadband", 0.4), False),  # a guess, and said to be one
        ("single", ["backlash"], _answer("deadband", 0.8, "backlash"), False),
        ("pair", ["slope", "backlash"], _answer("backlash", 0.8), False),
        ("no_gap", [], _answer("slope", 0.5), True),
        ("left_out", ["backlash"], _answer("backlash", 0.8), True),
        ("single", ["backlash"], {"verdict": "no_gap", "causes": []}, False),
        ("single", ["backlash"], None, False),
    ],
)
def test_a_wrong_cause_is_one_that_is_claimed(
    stratum: str, true: list[str], answer: dict[str, Any] | None, wrong: bool
) -> None:
    label = {"stratum": stratum, "effects": [{"name": name} for name in true]}
    assert accused(label, answer) is wrong


def test_a_trace_shows_the_joint_that_was_asked_for(tmp_path: Path) -> None:
    t = np.arange(0, 6, 0.02)
    rows = np.column_stack([t, np.zeros_like(t), np.sin(t), np.zeros_like(t), 0.9 * np.sin(t)])
    head = "t_s,cmd_1_rad,cmd_2_rad,enc_1_rad,enc_2_rad"
    np.savetxt(tmp_path / "run_01.csv", rows, delimiter=",", header=head, comments="")
    still, moving = draw_traces([Trace(tmp_path, 1, "nothing moves"), Trace(tmp_path, 2, "a gain")], tmp_path)
    assert (still.name, moving.name) == ("wrong_1.png", "wrong_2.png")
    assert still.read_bytes().startswith(PNG)
    assert still.read_bytes() != moving.read_bytes()


def test_what_was_said_stands_beside_what_was_right(tmp_path: Path) -> None:
    p, right = np.array([0.1, 0.85, 1.0, 0.9]), np.array([0.0, 1.0, 1.0, 0.0])
    low, high = reliability(p, right)
    assert (low.said, low.right, low.causes) == (0.1, 0.0, 1)
    assert high.said == pytest.approx(2.75 / 3)
    assert high.right == pytest.approx(2 / 3)
    assert high.causes == 3
    assert high.interval[0] < 2 / 3 < high.interval[1]
    assert draw_reliability(p, right, tmp_path).read_bytes().startswith(PNG)
    assert reliability(np.array([]), np.array([])) == []


def test_a_set_of_robots_that_have_many_effects_each_has_no_table_of_single_ones(tmp_path: Path) -> None:
    worn = {"stratum": "worn", "effects": [{"name": "backlash"}, {"name": "servo_lag"}]}
    assert draw([(worn, _answer("backlash", 0.8))], tmp_path) == [tmp_path / "reliability.png"]
    assert (tmp_path / "reliability.png").read_bytes().startswith(PNG)
