"""Two commits' answers, field by field."""

from __future__ import annotations

import copy
from typing import Any

from answers_compared import Asked, compare, table


def answer(probability: float = 0.8, estimate: float = 1.5, verdict: str = "explained") -> dict[str, Any]:
    value = {"estimate": estimate, "ci95": [1.0, 2.0], "unit": "rad/s"}
    cause = {
        "effect": "rate_limit",
        "joints": [2],
        "indistinguishable_from": [],
        "probability": probability,
        "parameters": {"limit_rad_s": value},
    }
    return {"verdict": verdict, "causes": [cause]}


def asked(given: dict[str, Any] | None, status: int = 0) -> Asked:
    return Asked(status, "said", 3.0, given)


def test_small_changes_are_the_same_and_told_from_identical_ones() -> None:
    before = asked(answer())
    assert compare("a", before, asked(answer())).identical
    near = compare("a", before, asked(answer(probability=0.809, estimate=1.504)))
    assert near.same
    assert not near.identical


def test_each_field_that_counts_makes_a_difference() -> None:
    before = asked(answer())
    other_joint, tie = answer(), answer()
    other_joint["causes"][0]["joints"] = [3]
    tie["causes"][0]["indistinguishable_from"] = ["voltage_sag"]
    for changed, word in (
        (answer(probability=0.82), "probability"),
        (answer(estimate=1.507), "limit_rad_s"),
        (answer(verdict="unexplained"), "verdict"),
        (other_joint, "causes"),
        (tie, "causes"),
    ):
        row = compare("a", before, asked(changed))
        assert not row.same
        assert word in row.differences[0]


def test_a_fixed_parameter_has_no_room() -> None:
    fixed = answer()
    fixed["causes"][0]["parameters"]["limit_rad_s"]["ci95"] = None
    moved = copy.deepcopy(fixed)
    moved["causes"][0]["parameters"]["limit_rad_s"]["estimate"] = 1.501
    assert compare("a", asked(fixed), asked(copy.deepcopy(fixed))).same
    assert not compare("a", asked(fixed), asked(moved)).same


def test_no_answer_is_the_same_as_no_answer_alone() -> None:
    assert compare("a", asked(None, 2), asked(None, 2)).same
    assert not compare("a", asked(None, 2), asked(None, 1)).same
    assert not compare("a", asked(answer()), asked(None, 1)).same


def test_the_table_counts_and_adds_up() -> None:
    rows = [compare("a", asked(answer()), asked(answer())), compare("b", asked(answer()), asked(None, 2))]
    lines = table(rows, "old", "new")
    assert "NO" in lines[2]
    assert lines[-1] == "old and new: 1 of 2 the same, 1 of them in every field; CPU 6 s and 6 s"
