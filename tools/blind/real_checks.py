"""Verdicts on real recordings against what was expected of them beforehand.

The expectations are data (``real_expectations.yaml``, which lists the kinds of checks); here is what each kind means.
An answer is the JSON of ``snakebot diagnose`` (schema snakebot.diagnosis/2).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml

Answer = dict[str, Any]
Rule = dict[str, Any]
# Whether it holds, and what was found; None where the check has nothing to look at.
Outcome = tuple[bool | None, str]

SCHEMA = "snakebot.real_expectations/1"


class ExpectationError(ValueError):
    """The file of expectations cannot be used."""


@dataclass(frozen=True)
class Check:
    """One line of the table. ``holds`` is None where nothing of the kind was found, which breaks nothing."""

    recording: str
    id: str
    must_not: bool
    holds: bool | None
    expected: str
    found: str

    def mapping(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True)
class Expectations:
    """What was fixed beforehand."""

    claim: float
    everywhere: dict[str, list[Rule]]
    recordings: dict[str, dict[str, list[Rule]]]
    across: list[Rule]


def read_expectations(path: Path) -> Expectations:
    """
    Raises:
        ExpectationError: not the schema, a kind of check that is not known, or the same name twice in a recording.
    """
    try:
        text = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise ExpectationError(f"{path}: {error}") from None
    if not isinstance(text, dict) or text.get("schema") != SCHEMA:
        raise ExpectationError(f"{path}: not of schema {SCHEMA}")
    made = Expectations(text["claim"], text["everywhere"], text["recordings"], text["across"])
    for name, parts in {"everywhere": made.everywhere, **made.recordings}.items():
        rules = [rule for part in ("should", "must_not") for rule in parts[part]]
        if name != "everywhere":
            rules += [rule for part in ("should", "must_not") for rule in made.everywhere[part]]
        if len({rule["id"] for rule in rules}) != len(rules):
            raise ExpectationError(f"{path}: {name}: an id stands twice")
        if not all(isinstance(rule["id"], str) for rule in rules):  # YAML reads `off` as a truth value
            raise ExpectationError(f"{path}: {name}: an id is no word")
        unknown = {rule["kind"] for rule in rules} - set(KINDS)
        if unknown:
            raise ExpectationError(f"{path}: {name}: no such kind of check: {', '.join(sorted(unknown))}")
    unknown = {rule["kind"] for rule in made.across} - set(ACROSS)
    if unknown:
        raise ExpectationError(f"{path}: across: no such kind of check: {', '.join(sorted(unknown))}")
    return made


def check_one(expected: Expectations, recording: str, answer: Answer) -> list[Check]:
    """All checks of one recording, those that hold everywhere among them."""
    lines = []
    for part in ("should", "must_not"):
        for rule in [*expected.recordings[recording][part], *expected.everywhere[part]]:
            holds, found = KINDS[rule["kind"]](rule, answer, expected.claim)
            lines.append(Check(recording, rule["id"], part == "must_not", holds, _wanted(rule), found))
    return lines


def check_across(expected: Expectations, answers: dict[str, Answer]) -> list[Check]:
    """Checks over several recordings; those of which a recording is missing are left out."""
    lines = []
    for rule in expected.across:
        if all(name in answers for name in rule["over"]):
            holds, found = ACROSS[rule["kind"]](rule, [answers[name] for name in rule["over"]])
            place = rule["over"][0].split("/")[0]
            lines.append(Check(f"{place}: across", rule["id"], False, holds, _wanted(rule), found))
    return lines


def _wanted(rule: Rule) -> str:
    kind, effects = rule["kind"], ", ".join(rule.get("effects", ()))
    within = "{:g} to {:g}".format(*rule["within"]) if isinstance(rule.get("within"), list) else ""
    return {
        "cause_any": f"one of {effects}",
        "load": f"one of {effects}, claimed; or unexplained",
        "rest_matches": f"if unexplained: the rest told in words like {rule.get('words', '')}",
        "where_matches": f"if unexplained: told in words like {rule.get('words', '')}",
        "parameter": f"{rule.get('effect')}, if named: {rule.get('parameter')} {within}",
        "error_after_deg": f"error after {within} deg RMS",
        "error_before_deg": f"error before {within} deg RMS",
        "floor_deg": f"floor {within} deg RMS",
        "no_floor": "no floor",
        "closure": "held-out runs and an interval",
        "stage": f"stage {' or '.join(rule.get('stages', ()))}",
        "warning": f"a warning like {rule.get('words', '')}",
        "cause_none": f"none of {effects}",
        "not_sure_of": f"no claim of {effects}",
        "not_resolved": f"no claim of {effects} without a tie",
        "ties": f"{rule.get('of')} only beside {rule.get('with')}",
        "not_sure_alone": f"not explained without {effects}",
        "parameter_rises": f"rises {rule.get('factor', 1):g}-fold from first to last",
        "error_before_falls": "the gap falls from first to last",
        "parameter_ratios": "in the ratios " + " : ".join(f"{r:g}" for r in rule.get("ratios", ())),
        "parameter_differs_less": f"differs by less than {rule.get('factor', 1):g}-fold",
    }[kind]


# --- one recording ---


def _group(cause: dict[str, Any]) -> set[str]:
    return {cause["effect"], *cause["indistinguishable_from"]}


def _told(causes: list[dict[str, Any]]) -> str:
    """Causes as a person would say them."""
    said = [
        f"{' or '.join([c['effect'], *c['indistinguishable_from']])} {c['probability']:.2f}" for c in causes
    ]
    return "; ".join(said) or "no cause"


def _joint_angle(answer: Answer) -> dict[str, Any]:
    return answer["closure"]["joint_angle"] or {}


def _cause_any(rule: Rule, answer: Answer, claim: float) -> Outcome:
    wanted = set(rule["effects"])
    hits = [c for c in answer["causes"] if wanted & _group(c)]
    return bool(hits), _told(hits or answer["causes"])


def _load(rule: Rule, answer: Answer, claim: float) -> Outcome:
    wanted = set(rule["effects"])
    claimed = [c for c in answer["causes"] if wanted & _group(c) and c["probability"] >= claim]
    if claimed:
        return True, _told(claimed)
    rest = answer["unexplained"]
    open_rest = answer["verdict"] in ("partly", "unexplained") and bool(rest["significant"])
    return open_rest, f"{answer['verdict']}, rest {rest['share']:.2f}; {_told(answer['causes'])}"


def _where_matches(rule: Rule, answer: Answer, claim: float) -> Outcome:
    if answer["verdict"] not in ("partly", "unexplained"):
        return None, answer["verdict"]
    told = f"{answer['unexplained']['where']}; {answer['where']['regime']}"
    return re.search(rule["words"], told) is not None, told


def _rest_matches(rule: Rule, answer: Answer, claim: float) -> Outcome:
    if answer["verdict"] not in ("partly", "unexplained"):
        return None, answer["verdict"]
    told = answer["unexplained"]["where"]
    return re.search(rule["words"], told) is not None, told


def _parameter(rule: Rule, answer: Answer, claim: float) -> Outcome:
    value = _value(answer, rule["effect"], rule["parameter"])
    if value is None:
        return None, "not named"
    low, high = rule["within"]
    return low <= value <= high, f"{value:.3g}"


def _value(answer: Answer, effect: str, parameter: str) -> float | None:
    for cause in answer["causes"]:
        if cause["effect"] == effect and parameter in cause["parameters"]:
            return float(cause["parameters"][parameter]["estimate"])
    return None


def _degrees(key: str) -> Callable[[Rule, Answer, float], Outcome]:
    def look(rule: Rule, answer: Answer, claim: float) -> Outcome:
        value = _joint_angle(answer).get(key)
        if value is None:
            return False, "none given"
        low, high = rule["within"]
        return low <= math.degrees(value) <= high, f"{math.degrees(value):.2f} deg"

    return look


def _no_floor(rule: Rule, answer: Answer, claim: float) -> Outcome:
    value = _joint_angle(answer).get("rms_floor")
    return value is None, "none" if value is None else f"{math.degrees(value):.2f} deg"


def _closure(rule: Rule, answer: Answer, claim: float) -> Outcome:
    runs, interval = answer["closure"]["held_out_runs"], _joint_angle(answer).get("ci95")
    given = "no interval" if interval is None else "{:.2f} to {:.2f}".format(*interval)
    return bool(runs) and interval is not None, f"{len(runs)} runs, {given}"


def _stage(rule: Rule, answer: Answer, claim: float) -> Outcome:
    stage = answer["where"]["stage"]
    return stage in rule["stages"], stage


def _warning(rule: Rule, answer: Answer, claim: float) -> Outcome:
    hits = [w for w in answer["warnings"] if re.search(rule["words"], w)]
    return bool(hits), hits[0] if hits else "no such warning"


def _cause_none(rule: Rule, answer: Answer, claim: float) -> Outcome:
    hits = [c for c in answer["causes"] if c["effect"] in rule["effects"]]
    return not hits, _told(hits)


def _not_sure_of(rule: Rule, answer: Answer, claim: float) -> Outcome:
    hits = [c for c in answer["causes"] if c["effect"] in rule["effects"]]
    return all(c["probability"] < claim for c in hits), _told(hits)


def _not_resolved(rule: Rule, answer: Answer, claim: float) -> Outcome:
    hits = [c for c in answer["causes"] if c["effect"] in rule["effects"]]
    return not any(c["probability"] >= claim and not c["indistinguishable_from"] for c in hits), _told(hits)


def _ties(rule: Rule, answer: Answer, claim: float) -> Outcome:
    hits = [c for c in answer["causes"] if c["effect"] == rule["of"]]
    if not hits:
        return None, "not named"
    named = set().union(*(_group(c) for c in answer["causes"]))
    return rule["with"] in named, _told(hits)


def _not_sure_alone(rule: Rule, answer: Answer, claim: float) -> Outcome:
    causes, wanted = answer["causes"], set(rule["effects"])
    sure = answer["verdict"] == "explained" and all(c["probability"] >= claim for c in causes)
    knows = any(wanted & _group(c) for c in causes)
    return not sure or knows, f"{answer['verdict']}; {_told(causes)}"


KINDS: dict[str, Callable[[Rule, Answer, float], Outcome]] = {
    "cause_any": _cause_any,
    "load": _load,
    "where_matches": _where_matches,
    "rest_matches": _rest_matches,
    "parameter": _parameter,
    "error_after_deg": _degrees("rms_after"),
    "error_before_deg": _degrees("rms_before"),
    "floor_deg": _degrees("rms_floor"),
    "no_floor": _no_floor,
    "closure": _closure,
    "stage": _stage,
    "warning": _warning,
    "cause_none": _cause_none,
    "not_sure_of": _not_sure_of,
    "not_resolved": _not_resolved,
    "ties": _ties,
    "not_sure_alone": _not_sure_alone,
}


# --- several recordings ---


def _parameter_rises(rule: Rule, answers: list[Answer]) -> Outcome:
    """True where one of the parameters is given for all recordings and rises from each to the next."""
    seen = []
    for effect, parameter in rule["any_of"]:
        values = [_value(answer, effect, parameter) for answer in answers]
        given = [v for v in values if v is not None]
        if not given:
            continue
        seen.append(f"{effect} " + ", ".join("-" if v is None else f"{v:.3g}" for v in values))
        rises = len(given) == len(values) and given == sorted(given)
        if rises and given[-1] >= rule["factor"] * given[0]:
            return True, seen[-1]
    return False, "; ".join(seen) or "none of them named"


def _error_before_falls(rule: Rule, answers: list[Answer]) -> Outcome:
    values = [math.degrees(_joint_angle(answer).get("rms_before") or math.nan) for answer in answers]
    falls = all(a > b for a, b in pairwise(values))
    return falls, ", ".join(f"{v:.1f}" for v in values) + " deg"


def _parameter_ratios(rule: Rule, answers: list[Answer]) -> Outcome:
    """Of each value to the first, within a share; not named in one of them is not found."""
    values = [_value(answer, *rule["of"]) for answer in answers]
    given = [v for v in values if v is not None]
    if len(given) < len(values):
        return False, "not named in all: " + ", ".join("-" if v is None else f"{v:.3g}" for v in values)
    found = [v / given[0] for v in given]
    near = all(abs(f / wanted - 1) <= rule["within"] for f, wanted in zip(found, rule["ratios"], strict=True))
    return near, " : ".join(f"{f:.2f}" for f in found)


def _parameter_differs_less(rule: Rule, answers: list[Answer]) -> Outcome:
    values = [_value(answer, *rule["of"]) for answer in answers]
    given = [v for v in values if v is not None]
    if len(given) < len(values):
        return None, "not named in all"
    return max(given) < rule["factor"] * min(given), ", ".join(f"{v:.3g}" for v in given)


ACROSS: dict[str, Callable[[Rule, list[Answer]], Outcome]] = {
    "parameter_rises": _parameter_rises,
    "error_before_falls": _error_before_falls,
    "parameter_ratios": _parameter_ratios,
    "parameter_differs_less": _parameter_differs_less,
}
