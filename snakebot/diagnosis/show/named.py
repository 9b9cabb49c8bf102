"""Causes, explanations and joints of a diagnosis in words; every word about an effect is the effect's own."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Sequence
from math import degrees

from snakebot.diagnosis.result import Cause, Diagnosis, GapStage, RankingEntry
from snakebot.diagnosis.sizes import NO_PERCENT
from snakebot.effects.effect import Effect
from snakebot.effects.parameter import Parameter
from snakebot.effects.registry import effects
from snakebot.effects.telling import STAGES_IN_WORDS, joints_in_words, sentence, shown, shown_span, title
from snakebot.in_words import listed, three

_LONG_NUMBER = re.compile(r"\d+\.\d+(e-?\d+)?")


def joint_count(found: Diagnosis) -> int:
    return len(found.where.joint_shares)


def effect_title(name: str) -> str:
    """What an effect is called in a lab; its name where it is not installed here."""
    known = effects().get(name)
    return title(known) if known is not None else name.replace("_", " ")


def effect_of(cause: Cause) -> Effect | None:
    return effects().get(cause.effect)


def values_of(cause: Cause) -> dict[str, float | tuple[float, ...]]:
    """Parameters by name, in their own units; a value for each joint where each has its own."""
    from snakebot.effects.spec import parse_effect
    from snakebot.errors import BadInputError

    values: dict[str, float | tuple[float, ...]] = {}
    with contextlib.suppress(BadInputError):  # of a package that is not installed here
        values |= parse_effect(cause.specification).values  # those that are held or read off are here alone
    for name, value in cause.parameters.items():
        own = tuple(joint.estimate for joint in value.by_joint)
        values[name] = own or value.estimate
    return values


def cause_sentence(cause: Cause, count: int) -> str:
    """What is said of the robot, without a full stop: "Joint 3 cannot turn faster than 2.00 rad/s"."""
    effect = effect_of(cause)
    if effect is None:
        return f"{effect_title(cause.effect)} on {joints_in_words(cause.joints, count)}"
    return sentence(effect, values_of(cause), cause.joints, count)


def cause_name(cause: Cause, count: int = 0) -> str:
    """What it is, those it cannot be told from, and where: "a dead band or play in the gear on joint 3"."""
    names = dict.fromkeys(effect_title(name) for name in (cause.effect, *cause.indistinguishable_from))
    name = listed(list(names), "or")
    if cause.stage == "body" or not cause.joints:
        return name
    return f"{name} on {joints_in_words(cause.joints, count)}"


def explanation(entry: RankingEntry, count: int) -> str:
    """An explanation that was tried, in words."""
    if not entry.effects:
        return "nothing: the simulation as it is"
    names = listed([effect_title(name) for name in entry.effects], "with")
    return f"{names}, {joints_in_words(entry.joints, count)}" if entry.joints else names


def stages(found: Diagnosis) -> tuple[GapStage, ...]:
    """Where in the signal it lies; of causes that tie, every stage that they lie in."""
    if not found.causes or found.verdict == "unexplained":
        return (found.where.stage,)
    named: list[GapStage] = []
    for cause in found.causes:
        rivals = [effects()[name].stage for name in cause.indistinguishable_from if name in effects()]
        named += [cause.stage, *rivals]
    return tuple(dict.fromkeys(named))


def stages_in_words(found: Diagnosis) -> str:
    """The same in words; of causes that tie "servo or sensor"."""
    ties = any(cause.indistinguishable_from for cause in found.causes)
    return listed([STAGES_IN_WORDS[stage] for stage in stages(found)], "or" if ties else "and")


def parameter_of(effect: str, name: str) -> Parameter | None:
    """A parameter of an effect; None of a package that is not installed here."""
    known = effects().get(effect)
    return next((p for p in known.parameters if p.name == name), None) if known is not None else None


def parameter_rows(cause: Cause) -> list[tuple[str, str, str]]:
    """Each parameter in words: what it is called, its value with its unit, its interval or why there is none."""
    rows = []
    for name, value in cause.parameters.items():
        parameter = parameter_of(cause.effect, name)
        if parameter is None:
            rows.append(
                (name.replace("_", " "), f"{three(value.estimate)} {value.unit}".strip(), value.reason or "")
            )
            continue
        if value.fixed and parameter.integer and value.estimate == parameter.default:
            continue  # a kind that is off
        if value.by_joint:
            for one in value.by_joint:
                ends = "not constrained" if one.ci95 is None else shown_span(parameter, one.ci95)
                rows.append((f"{parameter.called}, joint {one.joint}", shown(parameter, one.estimate), ends))
            continue
        ends = value.reason or ""
        if value.ci95 is not None:
            ends = shown_span(parameter, value.ci95)
        elif value.fixed:
            ends = "not fitted"
        rows.append((parameter.called, shown(parameter, value.estimate), ends))
    return rows


def cause_lines(cause: Cause) -> list[str]:
    """One line a parameter."""
    return [
        f"{name}: {value}" + (f" ({ends})" if ends else "") for name, value, ends in parameter_rows(cause)
    ]


def short_specification(cause: Cause) -> str:
    """After ``--effect``, numbers to four digits."""
    return _LONG_NUMBER.sub(lambda m: f"{float(m[0]):.4g}", cause.specification)


def plain(text: str) -> str:
    """A text with every name of an effect as it is called in a lab."""
    names = "|".join(sorted(effects(), key=len, reverse=True))
    return re.sub(rf"\b({names})\b", lambda m: effect_title(m[0]), text)


def in_degrees(rad: float) -> str:
    return three(degrees(rad))


def share_in_words(closed: float) -> str:
    """ "all", "97 %", "none": never more than all."""
    if closed >= 1 - NO_PERCENT:
        return "all"
    if closed < NO_PERCENT:
        return "none"
    return f"{100 * closed:.0f} %"


def runs_in_words(names: Sequence[str], of: int) -> str:
    """ "2 of 4 runs"."""
    return "every run" if len(names) >= of > 1 else f"{len(names)} of {of} runs"
