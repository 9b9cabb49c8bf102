"""A diagnosis in plain words, in about ten lines for a terminal."""

from __future__ import annotations

from snakebot.diagnosis.result import Diagnosis
from snakebot.diagnosis.show import answer, certainty
from snakebot.diagnosis.show.named import (
    cause_name,
    effect_title,
    in_degrees,
    joint_count,
    parameter_rows,
    plain,
    stages_in_words,
)
from snakebot.diagnosis.sizes import NO_PERCENT
from snakebot.effects.telling import joints_in_words
from snakebot.in_words import listed, three

VERDICTS = {
    "explained": "Explained",
    "partly": "Partly explained",
    "no_gap": "No gap",
    "unexplained": "Unexplained",
}


def verdict_words(found: Diagnosis) -> str:
    """ "Explained (sure)", "No gap"."""
    said = certainty.word(found)
    return VERDICTS[found.verdict] + (f" ({said})" if said else "")


def headline(found: Diagnosis) -> str:
    """The verdict in one sentence."""
    return f"{verdict_words(found)}: {answer.statement(found, hedged=False)}"


def summary(found: Diagnosis) -> list[str]:
    """The whole answer, line by line."""
    lines = [headline(found), *answer.effect_on_error(found)]
    why = certainty.why(found)
    if why:
        lines.append(f"{why}.")
    lines += [f"  {line}" for line in _numbers(found)]
    if found.verdict != "no_gap":
        lines.append(f"Where: {_where(found)}")
    lines += _shares(found)
    if found.unexplained.significant and found.verdict == "explained":
        lines.append(f"Left over: {found.unexplained.share:.1%} of the gap; {found.unexplained.where}")
    for one in answer.advice(found):
        lines.append(f"{one.where}: {one.text}")
        if one.command:
            lines.append(f"  {one.command}")
    return [*lines, *(f"Warning: {plain(warning)}" for warning in found.warnings)]


def _numbers(found: Diagnosis) -> list[str]:
    """A line for each cause: what its numbers are, between which ends."""
    lines = []
    for cause in found.causes:
        rows = [
            f"{name} {value}" + (f" ({ends})" if ends else "") for name, value, ends in parameter_rows(cause)
        ]
        numbers = f": {', '.join(rows)}" if rows else ""
        lines.append(f"{cause_name(cause, joint_count(found))}{numbers}; probability {cause.probability:.0%}")
    return lines


def _where(found: Diagnosis) -> str:
    parts = [stages_in_words(found)]
    if found.where.joints:
        parts.append(joints_in_words(found.where.joints, joint_count(found)))
    return f"{', '.join(parts)}; {found.where.regime}"


def _shares(found: Diagnosis) -> list[str]:
    """What each cause carries, where there are several or a rest."""
    lines = []
    for of, name in (("joint_angle", "joint angles"), ("ground", "motion over ground")):
        entries = found.shares_of(of)
        told = [entry for entry in entries if entry.cause is not None or entry.share >= NO_PERCENT]
        if len(told) > 1:
            parts = [
                f"{'the rest' if e.cause is None else effect_title(found.causes[e.cause].effect)} {e.share:.0%}"
                for e in told
            ]
            lines.append(f"Of the gap of {name}: {listed(parts)}")
    angle, speed = found.closure.joint_angle, found.closure.forward_speed
    if found.verdict in ("explained", "partly"):
        if angle.rms_floor is not None and angle.closed is not None:
            lines.append(f"Noise floor: {in_degrees(angle.rms_floor)} deg")
        if speed is not None and speed.closed is not None and angle.closed is not None:
            lines.append(
                f"Forward speed: off by {three(speed.error_before)} m/s before, {three(speed.error_after)} after"
            )
    return lines
