"""What an answer is worth, against the table of honest answers in ``faults``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from blind.scores import (
    Answer,
    Figure,
    Label,
    Pair,
    calibration_error,
    claims_another,
    first_cause,
    group,
    has_cause_or_gap,
    share,
)

from blind_wheels.faults import FAULTS

PLAIN = 2.7  # floors from which a fault must be found, as for the first robot


def named(label: Label, answer: Answer | None) -> bool:
    """The first cause, or one that it cannot be told from, says what is the matter."""
    cause = first_cause(answer)
    return cause is not None and bool(group(cause) & FAULTS[label["fault"]].names)


def left_open(label: Label, answer: Answer | None) -> bool:
    """Partly or unexplained, at the right stage, where that is honest."""
    fault = FAULTS[label["fault"]]
    return (
        answer is not None
        and fault.open
        and answer["verdict"] in ("partly", "unexplained")
        and answer["where"]["stage"] in fault.stages
    )


def honest(label: Label, answer: Answer | None) -> bool:
    return named(label, answer) or left_open(label, answer)


def accused(label: Label, answer: Answer | None) -> bool:
    """A cause that is none, with a probability of a half or more."""
    return claims_another(answer, FAULTS[label["fault"]].names if label["fault"] else frozenset())


def stage_right(label: Label, answer: Answer | None) -> bool:
    return answer is not None and answer["where"]["stage"] in FAULTS[label["fault"]].stages


def joints_right(label: Label, answer: Answer | None) -> bool:
    return answer is not None and sorted(answer["where"]["joints"]) == sorted(label["joints"])


def covered(pairs: Sequence[Pair]) -> list[bool]:
    """Whether the 95 % interval of a number that is known in the library's units holds it."""
    found = []
    for label, answer in pairs:
        for cause in answer["causes"] if answer else ():
            for name, told in cause["parameters"].items():
                if name in label["values"] and told.get("ci95") and not told.get("fixed"):
                    found.append(told["ci95"][0] <= label["values"][name] <= told["ci95"][1])
    return found


def probabilities(pairs: Sequence[Pair]) -> tuple[np.ndarray, np.ndarray]:
    """Of every cause in every answer, and whether it is one."""
    p, right = [], []
    for label, answer in pairs:
        names = FAULTS[label["fault"]].names if label["fault"] else frozenset()
        for cause in answer["causes"] if answer else ():
            p.append(float(cause["probability"]))
            right.append(bool(group(cause) & names))
    return np.array(p), np.array(right, dtype=float)


def figures(pairs: Sequence[Pair]) -> list[Figure]:
    faulty = [(lab, a) for lab, a in pairs if lab["fault"]]
    plain = [(lab, a) for lab, a in faulty if lab["size"] >= PLAIN]
    healthy = [(lab, a) for lab, a in pairs if not lab["fault"]]
    at_joints = [(lab, a) for lab, a in plain if lab["joints"]]
    p, right = probabilities(pairs)
    alarms = [has_cause_or_gap(a) for _, a in healthy]
    rows = [
        share("honest", "honest answer, faults at >= 2.7 floors", ">= 85 %", 0.85, None, [honest(*x) for x in plain]),
        share("named", "of these by a name that counts", "", None, None, [named(*x) for x in plain]),
        share("open", "of these left open", "", None, None, [not named(*x) and left_open(*x) for x in plain]),
        share("all", "honest answer, faults of any size", "", None, None, [honest(*x) for x in faulty]),
        share("accused", "wrong first cause at p >= 0.5, all", "<= 5 %", None, 0.05, [accused(*x) for x in pairs]),
        share("stage", "stage right", ">= 98 %", 0.98, None, [stage_right(*x) for x in plain]),
        share("joints", "joints right", ">= 98 %", 0.98, None, [joints_right(*x) for x in at_joints]),
        share("healthy", "healthy robots with a cause or a gap", "<= 2 %", None, 0.02, alarms),
        share("coverage", "coverage of 95 % intervals", "90-98 %", 0.9, 0.98, covered(plain)),
    ]  # fmt: skip
    if p.size:
        error = calibration_error(p, right, bins=5)
        brier = float(np.mean((p - right) ** 2))
        met = error <= 0.05
        rows.append(Figure("ece", "calibration error, five bins", "<= 0.05", error, None, None, p.size, met))
        rows.append(Figure("brier", "Brier score", "<= 0.10", brier, None, None, p.size, brier <= 0.1))
    return rows


def told(label: Label, answer: Answer | None) -> dict[str, Any]:
    """One case in a line: what was put in, what was said, what that is worth."""
    cause = first_cause(answer)
    said = "no answer" if answer is None else answer["verdict"]
    if cause is not None:
        said += ": " + "/".join([cause["effect"], *cause["indistinguishable_from"]])
    fault = label["fault"]
    if fault is None:
        worth = "false alarm" if has_cause_or_gap(answer) else "right"
    else:
        worth = "named" if named(label, answer) else "open" if left_open(label, answer) else "WRONG"
    return {
        "fault": fault or "healthy", "size": label["size"], "joints": label["joints"], "said": said,
        "probability": None if cause is None else cause["probability"],
        "where": None if answer is None else [answer["where"]["stage"], answer["where"]["joints"]], "worth": worth,
    }  # fmt: skip
