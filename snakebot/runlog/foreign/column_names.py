"""Finds out from their names what columns are: time, commands, measurements, and which joint each belongs to.

A name is cut into words: ``goal_position_3``, ``joint3.target``, ``Soll3``. Some words say what a column is, some its
unit; what is left is the joint's name. Only what is plain is taken: one command and one measurement a joint.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from snakebot.errors import BadInputError

_COMMAND = frozenset(
    {
        "cmd",
        "cmds",
        "command",
        "commanded",
        "commands",
        "goal",
        "target",
        "setpoint",
        "set",
        "ref",
        "reference",
    }
    | {"desired", "des", "action", "soll", "consigne"}
)
_MEASURED = frozenset(
    {
        "enc",
        "encoder",
        "encoders",
        "meas",
        "measured",
        "measure",
        "actual",
        "act",
        "present",
        "state",
        "observation",
    }
    | {"obs", "feedback", "fb", "pos", "position", "angle", "ist", "mesure", "real"}
)
_TIME = frozenset({"t", "time", "timestamp", "stamp", "ts", "zeit", "temps", "elapsed", "seconds", "sec"})
_FILL = frozenset({"joint", "joints", "motor", "servo", "axis", "point", "value", "j", "q"})
_NEITHER = frozenset(
    {
        "vel",
        "velocity",
        "speed",
        "current",
        "torque",
        "effort",
        "load",
        "temperature",
        "temp",
        "voltage",
        "volt",
    }
    | {"error", "err", "acc", "acceleration", "pwm", "power", "heading", "pose"}
)
_ANGLE_UNITS = {
    "rad": "rad", "radian": "rad", "radians": "rad", "deg": "deg", "degree": "deg", "degrees": "deg", "grad": "deg",
    "°": "deg", "counts": "counts", "count": "counts", "ticks": "counts", "steps": "counts", "raw": "counts",
}  # fmt: skip
_TIME_UNITS = {
    "s": "s", "sec": "s", "secs": "s", "seconds": "s", "ms": "ms", "msec": "ms", "us": "us", "µs": "us", "usec": "us",
    "ns": "ns", "nsec": "ns", "min": "min",
}  # fmt: skip
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-zµß-ÿ]+|[A-Z]+|\d+|°")


@dataclass(frozen=True)
class Columns:
    """Columns by what they are: ``time``, and of each joint ``command`` and ``measured``; ``units`` by column."""

    time: str | None
    joints: tuple[str, ...]
    command: tuple[str, ...]
    measured: tuple[str, ...]
    units: dict[str, str]


def _beside_the_command(name: str, names: Sequence[str]) -> bool:
    """What a table of snakebot's own says beside what was sent: what the board executed, what was wanted."""
    own = re.fullmatch(r"(applied|setpoint)_(\d+)_rad", name)
    return own is not None and (own[1] == "applied" or f"cmd_{own[2]}_rad" in names)


def find_columns(names: Sequence[str], where: str) -> Columns:
    """What the names of a table say.

    Raises:
        BadInputError: one line: what was not found, what was, and the option that says it.
    """
    found: dict[str, dict[str, str]] = {"command": {}, "measured": {}}
    units: dict[str, str] = {}
    times: list[str] = []
    for name in names:
        words = [word.lower() for word in _WORD.findall(name)]
        kind, joint = _kind(words)
        if kind == "time":
            times.append(name)
            units.update((name, _TIME_UNITS[word]) for word in words[1:] if word in _TIME_UNITS)
        elif kind is not None and not _beside_the_command(name, names):
            other = found[kind].setdefault(joint, name)
            if other != name:
                raise BadInputError(
                    f"{where}: {other} and {name} both look like the {_SAID[kind]} of one joint; "
                    "say which it is with --map"
                )
            units.update((name, _ANGLE_UNITS[word]) for word in words if word in _ANGLE_UNITS)
    command, measured = found["command"], found["measured"]
    joints = sorted(set(command) & set(measured), key=lambda joint: _order(joint, list(measured)))
    if not joints or set(command) != set(measured):
        alone = [*(found["command"][j] for j in command if j not in measured)]
        alone += [found["measured"][j] for j in measured if j not in command]
        there = ", ".join(list(names)[:20])
        why = (
            f"{', '.join(alone[:6])} without its counterpart"
            if alone
            else "neither commands nor measured angles"
        )
        raise BadInputError(
            f"{where}: names do not say which columns are commands and which measurements ({why}); say it with "
            f"--map 'cmd_*_rad=COMMAND*:deg' --map 'enc_*_rad=MEASURED*:deg'; found {there}"
        )
    return Columns(
        time=times[0] if times else None,
        joints=tuple(joints),
        command=tuple(command[joint] for joint in joints),
        measured=tuple(measured[joint] for joint in joints),
        units=units,
    )


_POSE = re.compile(
    r"(?P<what>x|y|heading|yaw|theta)[\s_]*[\[(]?\s*(?P<unit>m|cm|mm|rad|deg|°)?\s*[\])]?", re.IGNORECASE
)
_POSE_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_DEG = math.pi / 180
_TURN_UNITS = {"rad": 1.0, "deg": _DEG, "°": _DEG}


def find_pose(names: Sequence[str]) -> tuple[dict[str, tuple[str, float]], tuple[str, ...]]:
    """Where the robot is, if plain names say so: our columns with theirs and the factor to SI units, and columns that
    look like a pose but do not say their unit. Nothing without both x and y.
    """
    found: dict[str, tuple[str, float]] = {}
    open_: dict[str, str] = {}
    for name in names:
        match = _POSE.fullmatch(name.strip())
        if match is None:
            continue
        what, unit = match["what"].lower(), (match["unit"] or "").lower()
        ours, units = (f"{what}_m", _POSE_UNITS) if what in "xy" else ("heading_rad", _TURN_UNITS)
        if unit in units:
            found.setdefault(ours, (name, units[unit]))
        elif not unit:
            open_.setdefault(ours, name)
    if not {"x_m", "y_m"} <= set(found):
        both = {"x_m", "y_m"} <= set(open_)
        return {}, tuple(open_.values()) if both else ()
    return found, tuple(name for ours, name in open_.items() if ours not in found)


_SAID = {"command": "command", "measured": "measured angle"}


def _kind(words: Sequence[str]) -> tuple[str | None, str]:
    """``time``, ``command``, ``measured`` or None; and the joint that it is of."""
    said = set(words)
    if words and words[0] in _TIME and said <= _TIME | set(_TIME_UNITS):
        return "time", ""
    if said & _NEITHER:
        return None, ""
    kind = "command" if said & _COMMAND else "measured" if said & _MEASURED else None
    rest = [w for w in words if w not in _COMMAND | _MEASURED | _FILL and w not in _ANGLE_UNITS]
    numbers = [str(int(w)) if w.isdigit() else w for w in rest]
    return kind, " ".join(numbers)


def _order(joint: str, seen: Sequence[str]) -> tuple[int, int]:
    """By number where a joint has one, else in the order of the table."""
    number = re.search(r"\d+", joint)
    return (int(number[0]) if number else 0, seen.index(joint))
