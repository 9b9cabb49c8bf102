"""Where a diagnosis fails: the split of made-up misses, and the seal that the oracle keeps."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from blind.seal import seal
from oracle_split import Line, SealedError, kind_of_miss, refuse_sealed, table, true_effects

SINGLE = {
    "stratum": "single",
    "effects": [{"name": "rate_limit", "stage": "servo", "joints": [1], "size": 3.0, "values": {}}],
}
PAIR = {
    "stratum": "pair",
    "effects": [
        *SINGLE["effects"],
        {"name": "backlash", "stage": "servo", "joints": [2], "size": 3.0, "values": {}},
    ],
}


def answer(*effects: str, after: float = 0.1, ranking: tuple[tuple[str, ...], ...] = ()) -> dict[str, Any]:
    return {
        "verdict": "explained" if effects else "no_gap",
        "causes": [{"effect": e, "indistinguishable_from": [], "probability": 0.9} for e in effects],
        "ranking": [{"effects": list(names)} for names in ranking],
        "closure": {
            "joint_angle": {"rms_after": after, "closed": 0.9 if effects else None},
            "forward_speed": None,
        },
    }


@pytest.mark.parametrize(
    ("label", "said", "alone", "kind"),
    [
        (SINGLE, answer("rate_limit"), None, "right"),
        (SINGLE, None, answer("rate_limit"), "no answer"),
        (SINGLE, answer("backlash"), None, "no answer"),
        (SINGLE, answer(), answer(), "not detectable"),
        (SINGLE, answer("compliance", after=0.1), answer("rate_limit", after=0.05), "not found"),
        (SINGLE, answer("compliance", after=0.1), answer("rate_limit", after=0.1), "not weighed"),
        (
            SINGLE,
            answer("compliance", after=0.1, ranking=(("compliance",), ("rate_limit",))),
            answer("rate_limit", after=0.05),
            "not weighed",
        ),
        (PAIR, answer("backlash", "rate_limit"), None, "right"),
        (PAIR, answer("rate_limit"), answer("rate_limit"), "not detectable"),
        (PAIR, answer("rate_limit", after=0.2), answer("rate_limit", "backlash", after=0.1), "not found"),
    ],
)
def test_misses_are_split(label: Any, said: Any, alone: Any, kind: str) -> None:
    assert kind_of_miss(label, said, alone) == kind
    assert kind in "\n".join(table([Line("a", label, said, alone)]))


def test_of_a_worn_robot_the_oracle_is_told_what_has_a_share() -> None:
    effects = [
        {"name": "backlash", "share": 0.6, "dominant": True},
        {"name": "servo_lag", "share": 0.2, "dominant": False},
        {"name": "joint_friction", "share": 0.0, "dominant": False},
    ]
    assert true_effects({"stratum": "worn", "effects": effects}) == ("backlash", "servo_lag")


@pytest.mark.parametrize("set_name", ["score", "worn", "reduced"])
def test_sets_under_seal_are_refused(set_name: str) -> None:
    refuse_sealed({"set": set_name, "seed": 4})
    refuse_sealed({"set": "tune", "seed": 7})
    with pytest.raises(SealedError, match="under seal"):
        refuse_sealed({"set": set_name, "seed": 5})


def test_the_command_refuses_a_sealed_set_in_a_line(root: Path, tmp_path: Path) -> None:
    folder, answers = tmp_path / "set", tmp_path / "answers"
    folder.mkdir()
    answers.mkdir()
    (answers / "answers.jsonl").write_text("")
    made = {"set": "score", "seed": 5, "cases": 1, "strata": {}}
    seal({"made": made, "cases": {}, "numbers": {}}, folder / "labels.sealed", tmp_path / "set.key")
    done = subprocess.run(
        [sys.executable, str(root / "tools" / "oracle"), str(folder), str(answers)],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 2
    assert "under seal" in done.stderr
    assert "Traceback" not in done.stderr
