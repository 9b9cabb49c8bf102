"""Scores of worn robots: is the fault that stands out named, and are the shares of the gap told as they are?

Fixed before any answer was seen. Shares are those of a kind (``KINDS``): its members leave nearly the same mark, and
nobody could divide a gap between them. The first cause counts as what an answer says stands out; where two dominant
faults of a robot differ by less than ``CLOSE`` in their share, either will do.
"""

from __future__ import annotations

from typing import Any

from blind.worn_kinds import kind_of

CLOSE = 0.1  # of the gap
LEAST = 0.05  # of the gap, below which a kind has no share to speak of, in truth and answer
Answer = dict[str, Any]
Label = dict[str, Any]


def group(cause: dict[str, Any]) -> set[str]:
    return {cause["effect"], *cause["indistinguishable_from"]}


def dominant_named(label: Label, answer: Answer | None) -> bool:
    """Whether the first cause is the fault that stands out."""
    if answer is None or not answer["causes"]:
        return False
    standing = [e for e in label["effects"] if e["dominant"]]
    most = max(e["share"] for e in standing)
    either = {e["name"] for e in standing if e["share"] > most - CLOSE}
    return bool(either & group(answer["causes"][0]))


def true_shares(label: Label) -> dict[str, float]:
    """Share of the gap by kind."""
    made: dict[str, float] = {}
    for effect in label["effects"]:
        kind = kind_of(effect["name"])
        made[kind] = made.get(kind, 0.0) + effect["share"]
    return made


def told_shares(answer: Answer) -> dict[str, float]:
    """The same as an answer tells it: its ``budget``; without one, what each step of the closure adds."""
    causes = answer["causes"]
    if answer.get("budget"):
        pairs = [(causes[entry["cause"]]["effect"], float(entry["share"])) for entry in answer["budget"]]
    else:
        pairs, before = [], 0.0
        for step in answer["closure"].get("steps", ()):
            closed = step["joint_angle_closed"]
            if closed is not None:
                pairs.append((step["effect"], float(closed) - before))
                before = float(closed)
    made: dict[str, float] = {}
    for name, share in pairs:
        made[kind_of(name)] = made.get(kind_of(name), 0.0) + share
    return made


def share_errors(label: Label, answer: Answer | None) -> list[float]:
    """By how much each share is off, of every kind that has one in truth or answer; no answer tells none."""
    true = true_shares(label)
    told = {} if answer is None else told_shares(answer)
    kinds = [k for k in {**true, **told} if max(true.get(k, 0.0), told.get(k, 0.0)) >= LEAST]
    return [abs(told.get(k, 0.0) - true.get(k, 0.0)) for k in sorted(kinds)]
