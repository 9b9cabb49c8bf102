"""Two answers of ``snakebot diagnose`` to one session, field by field (schema snakebot.diagnosis/2)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

PROBABILITY = 0.01  # largest difference of two probabilities that are the same
OF_INTERVAL = 0.005  # largest difference of two values of a parameter, over the width of its 95 % interval
RELATIVE = 1e-6  # ... over the value, where there is no interval


@dataclass(frozen=True)
class Asked:
    """What one commit said to a session: exit status, CPU seconds, the answer's JSON (None: no answer)."""

    status: int
    said: str
    cpu_s: float
    answer: dict[str, Any] | None

    def mapping(self) -> dict[str, Any]:
        return asdict(self)

    @staticmethod
    def read(text: str) -> Asked:
        return Asked(**json.loads(text))


@dataclass(frozen=True)
class Row:
    """One session. ``differences``: a line each, nothing where the answers are the same; ``identical``: every field."""

    name: str
    verdict: str
    causes: str
    differences: tuple[str, ...]
    identical: bool
    cpu_s: tuple[float, float]

    @property
    def same(self) -> bool:
        return not self.differences


def compare(name: str, before: Asked, after: Asked) -> Row:
    """Both answers to one session."""
    cpu_s = (before.cpu_s, after.cpu_s)
    if before.answer is None or after.answer is None:
        ends = (before.status, after.status)
        same = before.answer is after.answer and ends[0] == ends[1]
        lines = () if same else (f"exit status {ends[0]} / {ends[1]}: {after.said or before.said}",)
        return Row(name, f"none ({ends[0]})", "", lines, before == after, cpu_s)
    a, b = before.answer, after.answer
    shown = ", ".join(_named(cause) for cause in a["causes"]) or "-"
    return Row(name, a["verdict"], shown, tuple(_differences(a, b)), a == b, cpu_s)


def _named(cause: dict[str, Any]) -> str:
    names = "|".join((cause["effect"], *cause["indistinguishable_from"]))
    return f"{names}@{'+'.join(map(str, cause['joints']))} {cause['probability']:.2f}"


def _differences(a: dict[str, Any], b: dict[str, Any]) -> list[str]:
    lines = []
    if a["verdict"] != b["verdict"]:
        lines.append(f"verdict {a['verdict']} / {b['verdict']}")

    def names(answer: dict[str, Any]) -> list[tuple[str, tuple[int, ...], tuple[str, ...]]]:
        return [
            (c["effect"], tuple(c["joints"]), tuple(c["indistinguishable_from"])) for c in answer["causes"]
        ]

    if names(a) != names(b):
        lines.append(f"causes {', '.join(map(_named, a['causes']))} / {', '.join(map(_named, b['causes']))}")
        return lines
    for one, other in zip(a["causes"], b["causes"], strict=True):
        if abs(one["probability"] - other["probability"]) > PROBABILITY:
            lines.append(
                f"{one['effect']}: probability {one['probability']:.3f} / {other['probability']:.3f}"
            )
        for parameter, value in one["parameters"].items():
            x, y, ends = value["estimate"], other["parameters"][parameter]["estimate"], value["ci95"]
            room = RELATIVE * abs(x) if ends is None else OF_INTERVAL * (ends[1] - ends[0])
            if abs(x - y) > room:
                lines.append(f"{one['effect']}.{parameter}: {x:.6g} / {y:.6g}")
    return lines


def table(rows: Sequence[Row], before: str, after: str) -> list[str]:
    """Lines: a session each, its differences below it, and the sums."""
    lines = [f"{'session':<34} {'verdict':<12} {'same':<10} {'CPU s before':>12} {'after':>7}  causes"]
    for row in rows:
        how = "identical" if row.identical else "yes" if row.same else "NO"
        lines.append(
            f"{row.name:<34} {row.verdict:<12} {how:<10} {row.cpu_s[0]:12.1f} {row.cpu_s[1]:7.1f}  {row.causes}"
        )
        lines += [f"    {line}" for line in row.differences]
    totals = [sum(row.cpu_s[i] for row in rows) for i in (0, 1)]
    same, identical = sum(row.same for row in rows), sum(row.identical for row in rows)
    lines.append(
        f"{before} and {after}: {same} of {len(rows)} the same, {identical} of them in every field; "
        f"CPU {totals[0]:.0f} s and {totals[1]:.0f} s"
    )
    return lines
