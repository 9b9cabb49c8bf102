"""Scores of proposed experiments: what they settle, how many it takes, and the same with gaits drawn at random."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from blind.scores import PLAIN, Answer, Figure, Label, Pair, first_cause, names_it, share, size

ARMS = ("proposed", "random")


def open_group(answer: Answer | None) -> bool:
    """Whether the first cause could as well be another."""
    cause = first_cause(answer)
    return cause is not None and bool(cause["indistinguishable_from"])


def wanted(label: Label, answer: Answer) -> bool:
    """Whether the lab does what is proposed: for single effects that are large enough to count."""
    return bool(label["stratum"] == "single" and size(label) >= PLAIN and answer["next_experiment"])


@dataclass(frozen=True)
class Trail:
    """The answers about one case, the first one before any experiment."""

    label: Label
    answers: list[Answer]

    @property
    def made(self) -> int:
        """Experiments until the group was resolved, or all of them."""
        return next((i for i, a in enumerate(self.answers) if i and not open_group(a)), len(self.answers) - 1)

    @property
    def resolved(self) -> bool:
        """Whether one cause was left, and the right one."""
        cause = first_cause(self.answers[self.made])
        return (
            cause is not None
            and not cause["indistinguishable_from"]
            and cause["effect"] == self.label["effects"][0]["name"]
        )


def trails(folder: Path, tokens: list[str], pairs: list[Pair]) -> dict[str, dict[str, Trail]]:
    """What tools/blind/experiment has written, by arm and token."""
    found: dict[str, dict[str, Trail]] = {arm: {} for arm in ARMS}
    for token, (label, answer) in zip(tokens, pairs, strict=True):
        for arm in ARMS:
            paths = [folder / f"{token}.{arm}.{n}.json" for n in range(1, 100)]
            later = [json.loads(p.read_text()) for p in paths if p.exists()]
            if answer is not None and later:
                found[arm][token] = Trail(label, [answer, *later])
    return found


def _rate(trail: list[Trail], least: float) -> float:
    """Experiments for one group resolved; those that never were count with all that was tried.

    ``least``: taken for the number resolved where none was. One half is against whom it is said of, one is for them.
    """
    return sum(t.made for t in trail) / max(sum(t.resolved for t in trail), least)


def _bootstrap(values: list[float]) -> tuple[float, float]:
    low, high = np.quantile(values, [0.025, 0.975])
    return float(low), float(high)


def experiment_figures(
    tokens: list[str], pairs: list[Pair], found: dict[str, dict[str, Trail]]
) -> list[Figure]:
    """Lines of the table. Where nothing was tried their value is None."""
    every = [(t, lab, a) for t, (lab, a) in zip(tokens, pairs, strict=True)]
    plain = [(t, lab, a) for t, lab, a in every if lab["stratum"] == "single" and size(lab) >= PLAIN]
    last = [(lab, found["proposed"][t].answers[-1] if t in found["proposed"] else a) for t, lab, a in plain]
    tried = bool(found["proposed"]) or not any(a and a["next_experiment"] for _, _, a in plain)
    rows = [
        share(
            "named_after", "cause named, single >= 3x, with experiments", ">= 95 %", 0.95, None,
            [names_it(*x) for x in last] if tried else [],
        )
    ]  # fmt: skip
    arms = {arm: {t: x for t, x in found[arm].items() if open_group(x.answers[0])} for arm in ARMS}
    mine = list(arms["proposed"].values())
    rows.append(
        share("resolved", "group resolved to the right cause", "", None, None, [t.resolved for t in mine])
    )
    rng = np.random.default_rng(0)
    if any(t.resolved for t in mine):
        drawn = [_rate([mine[i] for i in rng.integers(len(mine), size=len(mine))], 0.5) for _ in range(500)]
        low, high = _bootstrap(drawn)
        value = _rate(mine, 0.5)
        rows.append(
            Figure(
                "experiments",
                "experiments to resolve a group",
                "<= 2",
                value,
                low,
                high,
                len(mine),
                value <= 2,
            )
        )
    else:
        rows.append(
            Figure(
                "experiments", "experiments to resolve a group (none resolved)", "<= 2",
                None, None, None, len(mine), False if mine else None,
            )
        )  # fmt: skip
    both = [(arms["proposed"][t], arms["random"][t]) for t in arms["random"] if t in arms["proposed"]]

    def ratio(pick: list[tuple[Trail, Trail]]) -> float:
        return _rate([b for _, b in pick], 1.0) / max(_rate([a for a, _ in pick], 0.5), 1e-9)

    if both and any(a.resolved for a, _ in both):
        drawn = [ratio([both[i] for i in rng.integers(len(both), size=len(both))]) for _ in range(500)]
        low, high = _bootstrap(drawn)
        value = ratio(both)
        rows.append(
            Figure(
                "fewer",
                "times as many at random, same cases",
                ">= 2",
                value,
                low,
                high,
                len(both),
                value >= 2,
            )
        )
    else:
        rows.append(
            Figure("fewer", "times as many at random, same cases", ">= 2", None, None, None, len(both), None)
        )
    return rows
