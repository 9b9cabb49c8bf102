"""Simpler ways to name a cause, scored beside the diagnosis on the same cases.

``error``, ``aic`` and ``bic`` pick among the fits of single effects and of none that stand in the answer
(``details.fits``), by the cost in training, 2 cost + 2 p, or 2 cost + p ln n. ``forest`` (tools/blind/baseline) and
``fit_all`` (tools/blind/fit_all) have written their answers to a file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blind.scores import PLAIN, Answer, Label, Pair, all_named, first_cause, names_it, size, unexplained

Named = list[str]  # effects that a baseline names, the largest first; empty: no gap
CRITERIA: dict[str, Callable[[Mapping[str, Any]], float]] = {
    "error": lambda fit: float(fit["cost"]),
    "aic": lambda fit: 2 * fit["cost"] + 2 * fit["parameters"],
    "bic": lambda fit: 2 * fit["cost"] + fit["parameters"] * math.log(max(fit["samples"], 1)),
}
TEXTS = {
    "error": "smallest training error",
    "aic": "smallest AIC",
    "bic": "smallest BIC",
    "forest": "random forest on features",
    "fit_all": "every effect fitted at once",
}
FILES = ("forest", "fit_all")


@dataclass(frozen=True)
class Comparison:
    """Shares right of a baseline and of the diagnosis on the same cases; ``beaten`` None: the cases do not tell."""

    baseline: str
    metric: str
    value: float
    diagnosis: float
    low: float  # of diagnosis less baseline
    high: float
    cases: int
    beaten: bool | None

    def mapping(self) -> dict[str, Any]:
        return asdict(self)


def picked(answer: Answer | None, criterion: str) -> Named | None:
    """What a criterion picks; None where the answer holds no fits."""
    fits = ((answer or {}).get("details") or {}).get("fits")
    if not fits:
        return None
    return list(min(fits, key=CRITERIA[criterion])["effects"])


def baseline_answers(
    folder: Path, tokens: Sequence[str], pairs: Sequence[Pair]
) -> dict[str, list[Named | None]]:
    """Of every baseline that has any, one for each case; None where it was not asked."""
    found: dict[str, list[Named | None]] = {c: [picked(a, c) for _, a in pairs] for c in CRITERIA}
    for name in FILES:
        path = folder / f"{name}.json"
        said = json.loads(path.read_text()) if path.exists() else {}
        found[name] = [said.get(token) for token in tokens]
    return {name: row for name, row in found.items() if any(x is not None for x in row)}


def _same(label: Label, named: Named) -> bool:
    """Whether a baseline's whole answer is right; it has no word for what is not in the library."""
    true = {e["name"] for e in label["effects"]}
    if label["stratum"] == "unknown":
        return False
    return set(named[: max(len(true), 1)]) == true


def _whole(label: Label, answer: Answer | None) -> bool:
    """Whether the whole answer of the diagnosis is right."""
    if answer is None:
        return False
    if label["stratum"] == "no_gap":
        return answer["verdict"] == "no_gap" and not answer["causes"]
    if label["stratum"] == "unknown":
        return unexplained(answer)
    if len(label["effects"]) > 1:
        return all_named(label, answer)
    return names_it(label, answer)


def _strict(label: Label, answer: Answer | None) -> bool:
    cause = first_cause(answer)
    return cause is not None and cause["effect"] == label["effects"][0]["name"]


def _first(label: Label, named: Named) -> bool:
    return bool(named) and named[0] == label["effects"][0]["name"]


METRICS: tuple[
    tuple[str, str, Callable[[Label, Answer | None], bool], Callable[[Label, Named], bool]], ...
] = (
    ("single", "named, single >= 3x, group counts", names_it, _first),
    ("single", "named, single >= 3x, first name only", _strict, _first),
    ("no_gap", "no gap called no gap", _whole, lambda _, named: not named),
    ("", "whole answer right, all but left out", _whole, _same),
)


def compare(pairs: Sequence[Pair], answers: Mapping[str, Sequence[Named | None]]) -> list[Comparison]:
    """Each baseline on each metric, with a paired bootstrap interval of the difference."""
    rows = []
    for name, said in answers.items():
        for stratum, text, mine, its in METRICS:
            use = [
                (label, answer, named)
                for (label, answer), named in zip(pairs, said, strict=True)
                if named is not None
                and (label["stratum"] == stratum if stratum else label["stratum"] != "left_out")
                and (not label["effects"] or size(label) >= PLAIN)
            ]
            if not use:
                continue
            here = np.array([mine(label, answer) for label, answer, _ in use], dtype=float)
            there = np.array([its(label, named) for label, _, named in use], dtype=float)
            draws = np.random.default_rng(0).integers(len(use), size=(2000, len(use)))
            low, high = np.quantile((here - there)[draws].mean(axis=1), [0.025, 0.975])
            beaten = True if low > 0 else False if high < 0 else None
            rows.append(
                Comparison(
                    name,
                    text,
                    float(there.mean()),
                    float(here.mean()),
                    float(low),
                    float(high),
                    len(use),
                    beaten,
                )
            )
    return rows


def table(rows: Sequence[Comparison]) -> list[str]:
    """As text, a line a comparison."""
    lines = [
        f"{'baseline':<28}{'right':<38}{'its':>6} {'diagnosis':>10} {'difference, 95 %':>18} {'cases':>6}"
    ]
    said = {True: "beaten", False: "BETTER THAN THE DIAGNOSIS", None: "NOT SHOWN TO BE BEATEN"}
    for r in rows:
        interval = f"[{r.low:+.3f}, {r.high:+.3f}]"
        lines.append(
            f"{TEXTS[r.baseline]:<28}{r.metric:<38}{r.value:6.3f} {r.diagnosis:10.3f} {interval:>18} {r.cases:6d}  "
            f"{said[r.beaten]}"
        )
    asked = {r.baseline for r in rows}
    lines += [f"{text:<28}not run" for name, text in TEXTS.items() if name not in asked]
    return lines
