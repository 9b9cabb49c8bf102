"""Why a diagnosis missed: could the effect not be seen, was it not looked at, or was it given too little weight?

The oracle knows the true effects and is asked with them alone (``--only``). Its answer and the usual one decide:

* *not detectable*: even alone, a true effect does not earn its place;
* *not found*: it does, and its errors on held-out motions are lower than those of what was said: the search did not
  get there;
* *not weighed*: it does, and the usual answer had it among its explanations, or has one that predicts as well: the
  choice went wrong, not the search.

A case that the usual run or the oracle gave no answer to in time is none of these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from blind.cases import CALIBRATING_SETS, SEVERAL
from blind.scores import LOW_PROBABILITY, Answer, Label, all_named, first_cause, group, names_it
from blind.worn_scores import dominant_named

Kind = Literal["right", "no answer", "not detectable", "not found", "not weighed"]
KINDS: tuple[Kind, ...] = ("right", "no answer", "not detectable", "not found", "not weighed")
ASKED = ("single", *SEVERAL, "worn")  # strata whose effects the library holds
LOWER = 0.98  # of the other's error after, from which an error is lower
OPENED_SETS = ("tune", *CALIBRATING_SETS)
OPENED_BELOW = 5  # seeds of the other sets that were opened by a report


class SealedError(ValueError):
    """The set is under seal."""


def refuse_sealed(made: dict[str, Any]) -> None:
    """
    Raises:
        SealedError: the set has not been opened by a report: nobody learns from it.
    """
    if made["set"] not in OPENED_SETS and made["seed"] >= OPENED_BELOW:
        raise SealedError(
            f"set {made['set']}, seed {made['seed']}: under seal; seeds below {OPENED_BELOW} are open"
        )


def true_effects(label: Label) -> tuple[str, ...]:
    """The effects that the oracle is told: of a worn robot, those that stand out and those with a share."""
    effects = label["effects"]
    if label["stratum"] == "worn":
        effects = [e for e in effects if e["dominant"] or e["share"] >= 0.05]
    return tuple(dict.fromkeys(e["name"] for e in effects))


def asked_for(label: Label) -> tuple[str, ...]:
    """Those that an answer must name."""
    if label["stratum"] == "worn":
        return tuple(e["name"] for e in label["effects"] if e["dominant"])[:1]
    return true_effects(label)


def right(label: Label, answer: Answer | None) -> bool:
    """Whether an answer names what it must."""
    if label["stratum"] == "worn":
        return dominant_named(label, answer)
    if label["stratum"] in SEVERAL:
        return all_named(label, answer)
    return names_it(label, answer)


def undetectable(label: Label, oracle: Answer) -> tuple[str, ...]:
    """True effects that even the oracle does not name."""
    named: set[str] = set().union(*(group(cause) for cause in oracle["causes"]))
    return tuple(name for name in asked_for(label) if name not in named)


def error_after(answer: Answer, label: Label) -> float:
    """On held-out motions: of the joint angles, or of the speed where the first effect is the body's."""
    speed = answer["closure"]["forward_speed"]
    if label["effects"][0]["stage"] == "body" and speed is not None:
        return float(speed["error_after"])
    return float(answer["closure"]["joint_angle"]["rms_after"])


def had_it(label: Label, answer: Answer) -> bool:
    """Whether the true effects were among the explanations that were weighed."""
    wanted = set(asked_for(label))
    tried = [set(entry["effects"]) for entry in answer["ranking"]]
    return any(wanted <= names for names in tried)


def kind_of_miss(label: Label, answer: Answer | None, oracle: Answer | None) -> Kind:
    """Where an answer went wrong."""
    if answer is None:
        return "no answer"
    if right(label, answer):
        return "right"
    if oracle is None:
        return "no answer"
    if undetectable(label, oracle):
        return "not detectable"
    if had_it(label, answer) or error_after(oracle, label) >= LOWER * error_after(answer, label):
        return "not weighed"
    return "not found"


@dataclass(frozen=True)
class Line:
    """One case in the table."""

    token: str
    label: Label
    answer: Answer | None
    oracle: Answer | None

    @property
    def kind(self) -> Kind:
        return kind_of_miss(self.label, self.answer, self.oracle)

    def told(self) -> str:
        wanted = asked_for(self.label)
        true = ", ".join(f"{e['name']} {e['size']:.1f}" for e in self.label["effects"] if e["name"] in wanted)
        said, alone = _said(self.answer), _said(self.oracle)
        return f"{self.label['stratum']:<7} {self.kind:<15} {true:<44} said {said}; alone {alone}"


def _said(answer: Answer | None) -> str:
    if answer is None:
        return "nothing"
    cause = first_cause(answer)
    closed = (answer["closure"]["joint_angle"] or {}).get("closed")
    share = "" if closed is None else f", closed {closed:.2f}"
    if cause is None:
        return f"{answer['verdict']}{share}"
    sure = "" if cause["probability"] >= LOW_PROBABILITY else "?"
    return f"{answer['verdict']} {'+'.join(c['effect'] for c in answer['causes'])}{sure}{share}"


def table(lines: Sequence[Line]) -> list[str]:
    """Each miss in a line, and how many there are of each kind, by stratum and true effect."""
    missed = sorted((x for x in lines if x.kind != "right"), key=lambda x: (x.kind, x.label["stratum"]))
    out = [line.told() for line in missed]
    out += ["", f"{'':<28}" + "".join(f"{kind:>16}" for kind in KINDS)]
    rows: dict[str, list[Line]] = {}
    for line in lines:
        rows.setdefault(line.label["stratum"], []).append(line)
    for line in lines:
        if line.label["stratum"] == "single":
            rows.setdefault(f"  {line.label['effects'][0]['name']}", []).append(line)
    for name, some in {**rows, "all": list(lines)}.items():
        out.append(f"{name:<28}" + "".join(f"{sum(x.kind == kind for x in some):>16}" for kind in KINDS))
    return out
