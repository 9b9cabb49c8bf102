"""A set of wire cases on disk: names drawn by lot, labels sealed before anything runs, answers and scores.

The layout is that of ``tools/blind/make`` (``cases/TOKEN``, ``plan.json``, ``labels.sealed``, ``seal.txt``, the key
beside the folder), so that ``answer`` and ``score`` take it as it is. ``logs/TOKEN`` holds the logs as recorded.
"""

from __future__ import annotations

import json
import math
import secrets
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from blind.scores import first_cause, group
from blind.seal import digest, seal, unseal
from blind.wire_cases import WireCase

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class WireSet:
    """``numbers``: the case of each token, known to the maker alone."""

    out: Path
    numbers: dict[str, int]

    @property
    def labels(self) -> Path:
        return self.out / "labels.sealed"

    @property
    def answers(self) -> Path:
        return self.out.with_name(self.out.name + ".answers")


def open_set(out: Path, head: dict[str, Any], draw: Callable[[int], WireCase]) -> WireSet:
    """A new set, its labels under seal, or the one that was begun there with the same head.

    Raises:
        ValueError: another set is there.
    """
    key = out.with_name(out.name + ".key")
    if (out / "labels.sealed").exists():
        labels = unseal(out / "labels.sealed", key)
        if labels["made"] != head:
            raise ValueError(f"{out}: holds a set made with other options; take another folder")
        return WireSet(out, {token: label["number"] for token, label in labels["cases"].items()})
    (out / "cases").mkdir(parents=True, exist_ok=True)
    numbers = {secrets.token_hex(6): number for number in range(head["cases"])}
    cases = {
        token: draw(number).label.mapping() | {"number": number} for token, number in sorted(numbers.items())
    }
    (out / "plan.json").write_text(json.dumps(dict.fromkeys(sorted(numbers)), indent=1) + "\n")
    told = seal({"made": head, "cases": cases}, out / "labels.sealed", key)
    (out / "seal.txt").write_text(f"{told}  labels.sealed\n")
    print(f"SHA-256 of the seal: {told}", flush=True)
    return WireSet(out, numbers)


def call(script: str, *options: str) -> str:
    """Run one of the scripts beside this file; what it said.

    Raises:
        RuntimeError: it failed.
    """
    done = subprocess.run([sys.executable, str(HERE / script), *options], stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise RuntimeError(f"{script} ended with exit status {done.returncode}")
    return done.stdout


def note(path: Path, entry: dict[str, Any]) -> None:
    with path.open("a") as file:
        file.write(json.dumps(entry) + "\n")


def noted(path: Path) -> dict[str, dict[str, Any]]:
    """The last entry of each token."""
    if not path.exists():
        return {}
    entries = [json.loads(line) for line in path.read_text().splitlines() if line.endswith("}")]
    return {entry["token"]: entry for entry in entries}


def table(made: WireSet, how: dict[str, str]) -> list[str]:
    """A line a case: how it ran (by token), what was true and what was said of it. Opens the seal."""
    labels = unseal(made.labels, made.out.with_name(made.out.name + ".key"))["cases"]
    lines = [f"SHA-256 of the seal: {digest(made.labels)}", ""]
    lines.append(f"{'how':<26} {'truth':<34} {'size':>5}  {'verdict':<12} {'closed':>6}  said")
    for token in sorted(labels, key=lambda t: labels[t]["number"]):
        label, path = labels[token], made.answers / f"{token}.json"
        true = label["effects"][0] if label["effects"] else None
        truth = "no gap" if true is None else f"{true['name']}{_of(true['joints'])}{_values(true['values'])}"
        size = "" if true is None else f"{true['size']:.1f}"
        if path.exists():
            answer = json.loads(path.read_text())
            angle = answer["closure"]["joint_angle"] or {}
            closed = "" if angle.get("closed") is None else f"{angle['closed']:.2f}"
            said = "; ".join(_cause(c) for c in answer["causes"]) or "nothing"
            lines.append(
                f"{how.get(token, ''):<26} {truth:<34} {size:>5}  {answer['verdict']:<12} {closed:>6}  {said}"
            )
        else:
            lines.append(f"{how.get(token, ''):<26} {truth:<34} {size:>5}  no answer")
    return lines


def _of(joints: list[int] | None) -> str:
    return "" if joints is None else " all" if len(joints) > 2 else " " + "+".join(map(str, joints))


def _values(values: dict[str, float]) -> str:
    return "" if not values else " " + ", ".join(f"{v:.3g}" for v in values.values())


def _cause(cause: dict[str, Any]) -> str:
    found = {k: p["estimate"] for k, p in cause["parameters"].items() if p.get("estimate") is not None}
    known = {k: v for k, v in found.items() if isinstance(v, int | float) and math.isfinite(v)}
    ties = f" or {len(cause['indistinguishable_from'])} more" if cause["indistinguishable_from"] else ""
    return f"{cause['effect']}{_of(cause['joints'])}{_values(known)}{ties} p={cause['probability']:.2f}"


def named(label: dict[str, Any], answer: dict[str, Any]) -> bool:
    """Whether the answer is right: the effect is in the first cause's group, or nothing was said where nothing is."""
    if label["stratum"] == "unknown":
        return bool(answer["verdict"] in ("partly", "unexplained"))
    if not label["effects"]:
        return bool(answer["verdict"] == "no_gap" and not answer["causes"])
    cause = first_cause(answer)
    return cause is not None and label["effects"][0]["name"] in group(cause)
