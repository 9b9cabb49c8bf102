"""What an effect declares of itself, put into words: its sentence with numbers and joints, its parameters.

In a ``sentence``, ``{where}`` is the joints with a capital ("Joint 3", "All joints"), ``{on}`` the same in the midst of
a sentence, ``{name}`` a parameter with its unit as a lab says it, and ``[is|are]`` depends on the number of joints.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from snakebot.in_words import listed, span, three, with_unit

if TYPE_CHECKING:
    from snakebot.effects.effect import Effect
    from snakebot.effects.parameter import Parameter

Value = float | tuple[float, ...]

STAGES_IN_WORDS = {
    "link": "link to the servos",
    "servo": "servo",
    "sensor": "sensor",
    "body": "motion over ground",
    "none": "nowhere",
}
FEW = 4  # joints, and values of as many, that are all listed; chosen
_CHOICE = re.compile(r"\[([^\[\]|]*)\|([^\[\]|]*)\]")
_FIELD = re.compile(r"\{(\w+)\}")


def joints_in_words(joints: Sequence[int], count: int) -> str:
    """ "joint 3", "joints 1, 2 and 4", "joints 1 to 7 and 9", "all joints" of ``count``."""
    if not joints or (len(joints) == count and count > 1):
        return "all joints"
    return (
        f"joint{'s' if len(joints) > 1 else ''} {listed(_in_runs(joints) if len(joints) > FEW else joints)}"
    )


def _in_runs(joints: Sequence[int]) -> list[str]:
    """Neighbours together: "1 to 7"."""
    runs: list[list[int]] = []
    for joint in sorted(joints):
        if runs and joint == runs[-1][-1] + 1:
            runs[-1].append(joint)
        else:
            runs.append([joint])
    out: list[str] = []
    for run in runs:
        out += [f"{run[0]} to {run[-1]}"] if len(run) > 2 else map(str, run)
    return out


def sentence(effect: Effect, values: Mapping[str, Value], joints: Sequence[int], count: int) -> str:
    """What is said of a robot with so many joints that has this effect on some; without a full stop.

    Args:
        values: parameters by name, in their own units; several where each joint has its own.
        joints: 1-based.
    """
    on = joints_in_words(joints, count)
    text = effect.said(values) or f"{effect.summary.rstrip('.')}: {{on}}"
    plural = len(joints) != 1
    text = _CHOICE.sub(lambda m: m[2] if plural else m[1], text)
    if on == "all joints":
        text = text.replace("{where} cannot", "No joint can")

    def field(match: re.Match[str]) -> str:
        name = match[1]
        if name in ("where", "on"):
            return on[0].upper() + on[1:] if name == "where" else on
        return shown(effect.parameter(name), values[name]) if name in values else "an unknown amount"

    return _FIELD.sub(field, text)


def shown(parameter: Parameter, value: Value) -> str:
    """A value as a lab says it: "45.0 ms"; of several, each; of many, between which they are."""
    many = value if isinstance(value, tuple) else (value,)
    texts = [str(round(v)) if parameter.integer else three(parameter.in_shown_unit(v)) for v in many]
    if len(many) > FEW and len(set(texts)) > 1:
        low, high = min(many), max(many)
        return shown_span(parameter, (low, high))
    return with_unit(listed(texts) if len(set(texts)) > 1 else texts[0], parameter.shown_unit)


def shown_span(parameter: Parameter, ends: tuple[float, float]) -> str:
    """An interval in the unit of the lab: "1.8 to 2.3 rad/s"."""
    low, high = sorted(parameter.in_shown_unit(end) for end in ends)
    return with_unit(span(low, high), parameter.shown_unit)


def title(effect: Effect) -> str:
    """What it is called in a lab."""
    return effect.title or effect.name.replace("_", " ")
