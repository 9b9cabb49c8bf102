#!/usr/bin/env python3
"""What every diagnosis must keep to, whatever the session: breaches of it, in words.

    tools/invariants.py OUT.json ...        exit status 1 if any is broken

Reads the JSON of ``snakebot diagnose`` (schema 1 or 2). It judges whether a verdict agrees with itself, not whether it
is right.
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf, isclose, sqrt
from pathlib import Path
from typing import Any

Answer = dict[str, Any]

HALF = 0.5  # closure from which a gap is explained; probability from which a cause is claimed
WITHIN = 0.1  # share of the squared floor, under which a mean square above the floor is no gap
APART = 0.5  # share of the gap, by which what is left may differ from what is not closed: they weigh runs differently
# Share of the gap that parts may close beyond the whole, which is not fitted to the angles alone.
UNDONE = 0.01
ROUNDED = 0.001  # of probabilities, as they are told
MOST_GUESSED = 0.5  # highest probability of a cause that no motion tests (docs/diagnosis-method.md)
UNTESTED = re.compile("nothing tests it|no run is held out")  # so an answer says that none does
BELOW_FLOOR = 0.95  # of the floor; errors that are lower cannot be by chance, over hundreds of blocks
SCATTER = {"encoder_noise"}  # shows in how readings scatter: no prediction of them comes nearer
MAY_SCATTER = SCATTER | {"command_loss"}  # may show there alone, with nothing to close in the mean
SAID_OF_FLOOR = re.compile(r"\b(floor|repeat)", re.IGNORECASE)


@dataclass(frozen=True)
class Breach:
    """An invariant that an answer breaks, and how."""

    invariant: str
    text: str

    def __str__(self) -> str:
        return f"{self.invariant}: {self.text}"


def breaches(answer: Answer) -> list[Breach]:
    """All of an answer; none if it agrees with itself."""
    return [Breach(check.__name__, text) for check in CHECKS for text in check(answer)]


def _parts(answer: Answer) -> dict[str, dict[str, Any]]:
    """Closure of joint angles and forward speed with the same keys, as far as they are given."""
    closure, made = answer["closure"], {}
    for name, stem in (("joint_angle", "rms_"), ("forward_speed", "error_")):
        part = closure.get(name)
        if part is not None:
            floor = part.get("rms_floor") if name == "joint_angle" else part.get("floor")
            made[name] = {
                "before": part[f"{stem}before"],
                "after": part[f"{stem}after"],
                "floor": floor,
                "reason": part.get("reason"),
                "closed": part["closed"],
            }
    return made


def _closed(answer: Answer) -> list[float]:
    """Every closure that is told: of joint angles, forward speed and the whole motion over ground; where all is said to
    be explained, also of what no tolerance of the stated numbers accounts for.
    """
    closure = answer["closure"]
    told = [part["closed"] for part in _parts(answer).values()]
    told.append((closure.get("ground") or {}).get("closed"))
    if answer["verdict"] == "explained":
        told.append((closure.get("joint_angle") or {}).get("closed_beyond_tolerance"))
    return [closed for closed in told if closed is not None]


def _of_scatter(answer: Answer) -> bool:
    """Whether all that is named may show in the scatter alone."""
    names = {cause["effect"] for cause in answer["causes"]}
    return bool(names) and names <= MAY_SCATTER


def no_cause_without_held_out_closure(answer: Answer) -> Iterator[str]:
    """A cause closes something on motions that it was not fitted to; scatter alone has nothing to close.

    Where there is one motion only, a cause is a guess and said to be one.
    """
    if {cause["effect"] for cause in answer["causes"]} - SCATTER:
        named = ", ".join(cause["effect"] for cause in answer["causes"])
        if not answer["closure"]["held_out_runs"]:
            if max(cause["probability"] for cause in answer["causes"]) > MOST_GUESSED:
                yield f"{named}: no run is held out, and it is no guess"
            reasons = [part.get("reason") or "" for part in _parts(answer).values()]
            if not any(UNTESTED.search(text) for text in (*answer["warnings"], *reasons)):
                yield f"{named}: no run is held out, and nothing says so"
        elif not _closed(answer) and not _of_scatter(answer):
            yield f"{named}: no closure is told"
        elif _closed(answer) and max(_closed(answer)) <= 0:
            yield f"{named}: closed {max(_closed(answer)):.2f}"


def the_whole_closes_most(answer: Answer) -> Iterator[str]:
    """All effects together close what any part of them closes, as far as can be told: of the joint angles what no
    tolerance accounts for, if that is told. One by one they need not: some help only together.
    """
    closure = answer["closure"]
    for key, name in (("joint_angle_closed", "joint_angle"), ("forward_speed_closed", "forward_speed")):
        beyond = f"{key}_beyond_tolerance"
        steps = closure.get("steps", ())
        told = beyond if steps and steps[-1].get(beyond) is not None else key
        found = [step[told] for step in steps if step.get(told) is not None]
        most = max([0.0, *found[:-1]])
        interval = (closure.get(name) or {}).get("ci95") if told == key else None
        if found and most > max(found[-1] + UNDONE, interval[1] if interval else -inf):
            yield f"{told}: {found[-1]:.3f} in all, {most:.3f} before"


def closure_is_what_it_says(answer: Answer) -> Iterator[str]:
    """closed = (before^2 - after^2) / (before^2 - floor^2), and lies within its interval."""
    for name, part in _parts(answer).items():
        if part["closed"] is None:
            continue
        b2, a2, f2 = part["before"] ** 2, part["after"] ** 2, (part["floor"] or 0.0) ** 2
        if not isclose(part["closed"], (b2 - a2) / (b2 - f2), abs_tol=1e-6):
            yield f"{name}: closed {part['closed']:.3f}, by its errors {(b2 - a2) / (b2 - f2):.3f}"
    angle = answer["closure"].get("joint_angle") or {}
    beyond = angle.get("closed_beyond_tolerance")
    if beyond is not None:
        b2, a2 = (angle[key] ** 2 for key in ("rms_before_within_tolerance", "rms_within_tolerance"))
        f2 = (angle["rms_floor"] or 0.0) ** 2
        if not isclose(beyond, (b2 - a2) / (b2 - f2), abs_tol=1e-6):
            yield f"beyond tolerance: closed {beyond:.3f}, by its errors {(b2 - a2) / (b2 - f2):.3f}"
    joints = answer["closure"].get("by_joint") or []
    for key in ("rms_before", "rms_after"):
        values = [joint[key] for joint in joints]
        if values and not min(values) * 0.999 <= angle[key] <= max(values) * 1.001:
            yield f"{key} of all joints, {angle[key]:.4f}, is beyond that of each"


def no_closure_within_the_floor(answer: Answer) -> Iterator[str]:
    """Where the error before is that of the floor there is nothing to close."""
    for name, part in _parts(answer).items():
        floor = part["floor"]
        if part["closed"] is not None and floor and part["before"] ** 2 <= (1 + WITHIN) * floor**2:
            yield f"{name}: {part['before']:.4g} before, floor {floor:.4g}, and closed {part['closed']:.2f}"


def below_the_floor_is_a_doubt(answer: Answer) -> Iterator[str]:
    """Joint angles nearer than the floor say that the floor is too high: a warning tells so.

    Not asked of the speed: it has one number a run, and few runs come nearer by chance.
    """
    if _of_scatter(answer):  # which is in the floor of repeats, too
        return
    said = any(SAID_OF_FLOOR.search(warning) for warning in answer["warnings"])
    part = _parts(answer).get("joint_angle")
    if part and part["floor"] and part["after"] < BELOW_FLOOR * part["floor"] and not said:
        yield f"{part['after']:.4g} after, floor {part['floor']:.4g}, and no warning of it"


def unexplained_claims_nothing(answer: Answer) -> Iterator[str]:
    """No cause is claimed where the verdict is that none explains the gap."""
    if answer["verdict"] == "unexplained":
        for cause in answer["causes"]:
            if cause["probability"] > HALF:
                yield f"{cause['effect']} at {cause['probability']:.2f}"


def explained_closes_half(answer: Answer) -> Iterator[str]:
    """What explains a gap closes half of it at least, of the joint angles or of the motion over ground.

    Where nothing beyond tolerance is left, that is half of what no tolerance of the stated numbers accounts for.
    """
    closed = _closed(answer)
    if answer["verdict"] in ("explained", "partly") and closed and max(closed) < HALF:
        yield f"{answer['verdict']}, closed {max(closed):.2f}"


def verdict_and_causes_agree(answer: Answer) -> Iterator[str]:
    """Causes explain, and nothing has none; what was fitted step by step is what is named."""
    verdict, causes, rest = answer["verdict"], answer["causes"], answer["unexplained"]
    if verdict in ("explained", "partly") and not causes:
        yield f"{verdict} without a cause"
    if verdict == "no_gap":
        if causes:
            yield "no_gap with a cause"
        if rest["significant"] or rest["share"] > 0:
            yield f"no_gap, and {rest['share']:.0%} left"
        if _closed(answer):
            yield "no_gap, and a closure"
    if (answer["where"]["stage"] == "none") != (verdict == "no_gap") and verdict != "unexplained":
        yield f"{verdict}, stage {answer['where']['stage']}"
    named = {name for cause in causes for name in (cause["effect"], *cause["indistinguishable_from"])}
    strange = {step["effect"] for step in answer["closure"].get("steps", ())} - named
    if strange and causes:
        yield f"closed by {', '.join(sorted(strange))}, which is no cause"


def rest_and_closure_agree(answer: Answer) -> Iterator[str]:
    """What is left and what is closed make up the gap, roughly."""
    part = _parts(answer).get("joint_angle")
    share = answer["unexplained"]["share"]
    if part is None or part["closed"] is None or answer["where"]["stage"] == "body":
        return
    if abs(1 - part["closed"] - share) > APART:
        yield f"closed {part['closed']:.2f}, and {share:.2f} left"


def traces_and_closure_agree(answer: Answer) -> Iterator[str]:
    """The pictures show what the figures say: held-out runs, and an error that falls where closure says so."""
    traces = (answer.get("details") or {}).get("traces") or []
    held = answer["closure"]["held_out_runs"]
    before = after = 0.0
    for trace in traces:
        if held and trace["run"] not in held:
            yield f"a trace of {trace['run']}, which is not held out"
        rows = zip(
            trace["measured_rad"], trace["before_rad"], trace["after_rad"], trace["command_rad"], strict=True
        )
        for measured, first, last, command in rows:
            if None not in (measured, first, last, command):
                before, after = before + (first - measured) ** 2, after + (last - measured) ** 2
    if not traces or before == 0:
        return
    steps, closed = answer["closure"].get("steps"), _parts(answer)["joint_angle"]["closed"]
    if not steps and not isclose(before, after, rel_tol=1e-6):
        yield "nothing was fitted, and the traces differ before and after"
    if closed is not None and closed > HALF and after >= before:
        yield f"closed {closed:.2f}, and the traces are {sqrt(after / before):.2f} times as far off after as before"


def what_lost_is_not_likelier(answer: Answer) -> Iterator[str]:
    """No explanation that is behind the one named, on motions left out, is told to be likelier than it."""
    named = {cause["effect"] for cause in answer["causes"]} - SCATTER
    mine = [entry for entry in answer.get("ranking", ()) if set(entry["effects"]) == named]
    if not named or not mine:
        return
    likely = max(entry["probability"] for entry in mine)
    score = min(entry["held_out_score"] for entry in mine)
    for entry in answer["ranking"]:
        if entry["held_out_score"] < score and entry["probability"] > likely + ROUNDED:
            yield f"{' and '.join(entry['effects'])} at {entry['probability']:.3f}, what is named at {likely:.3f}"


def shares_add_up(answer: Answer) -> Iterator[str]:
    """Shares are of a whole, and intervals hold their estimates."""
    where = answer["where"]
    for name, values in (
        ("stage_shares", list(where["stage_shares"].values())),
        ("joint_shares", where["joint_shares"]),
    ):
        total = sum(values)
        if min(values) < 0 or not (total == 0 or isclose(total, 1.0, abs_tol=0.01)):
            yield f"{name}: {', '.join(f'{value:.2f}' for value in values)}"
    for cause in answer["causes"]:
        for name, told in cause["parameters"].items():
            interval = told.get("ci95")
            if interval and not interval[0] <= told["estimate"] <= interval[1]:
                yield f"{cause['effect']} {name}: {told['estimate']:.4g} outside of {interval}"
    budget = [e for e in answer.get("budget") or [] if e.get("of", "joint_angle") == "joint_angle"]
    if budget and not isclose(
        sum(e["share"] for e in budget) + answer["unexplained"]["share"], 1.0, abs_tol=0.02
    ):
        yield "the budget and the rest do not add up to one"


CHECKS: tuple[Callable[[Answer], Iterator[str]], ...] = (
    no_cause_without_held_out_closure,
    the_whole_closes_most,
    closure_is_what_it_says,
    no_closure_within_the_floor,
    below_the_floor_is_a_doubt,
    unexplained_claims_nothing,
    explained_closes_half,
    verdict_and_causes_agree,
    rest_and_closure_agree,
    traces_and_closure_agree,
    shares_add_up,
    what_lost_is_not_likelier,
)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("answers", type=Path, nargs="+", metavar="OUT.json")
    paths = parser.parse_args().answers
    broken = 0
    for path in paths:
        try:
            answer = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            parser.error(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}")
        if not (isinstance(answer, dict) and str(answer.get("schema", "")).startswith("snakebot.diagnosis/")):
            parser.error(f"{path}: not an answer of snakebot diagnose --json")
        found = breaches(answer)
        broken += bool(found)
        for breach in found:
            print(f"{path}: {breach}")
    print(f"{len(paths) - broken} of {len(paths)} answers keep to all {len(CHECKS)} invariants")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
