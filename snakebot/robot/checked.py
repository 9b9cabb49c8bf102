"""A parsed description, checked: the first fault is told with its line and key."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from snakebot.errors import BadInputError
from snakebot.nearest import misspelt, not_known
from snakebot.robot.description import (
    BODY_KEYS,
    SCHEMA,
    Friction,
    Limits,
    Provenance,
    Recorded,
    Robot,
    Tolerance,
)
from snakebot.safe_yaml import NO_LINES, Lines

_SERVO_KEYS = ("time_constant_s", "arm")  # those that something here reads
_MISSPELT = 0.85  # how like a known key one must be that is not kept as another program's: a letter or two


def robot_from_mapping(data: object, where: str, lines: Lines = NO_LINES) -> Robot:
    """Check a parsed description.

    Args:
        lines: of the document that it stands in.

    Raises:
        BadInputError: one line that names ``where``, the key and what is wrong with it.
    """
    if not isinstance(data, Mapping):
        raise BadInputError(f"{where}: a robot description is a mapping of keys to values")
    _check_keys(data, where, lines)
    schema = data.get("schema", SCHEMA)
    if schema != SCHEMA:
        raise BadInputError(f"{where}: schema is {schema!r}, this version reads {SCHEMA!r}")
    try:
        return Robot.model_validate(data)
    except ValidationError as error:
        raise BadInputError(f"{where}: {_first_fault(error, data, lines)}") from None


def _check_keys(data: Mapping[Any, Any], where: str, lines: Lines) -> None:
    """A misspelt key is the fault to tell, before those that come of it.

    Raises:
        BadInputError: a key that is not known; of the servo, which may have more, one that is nearly a known one.
    """
    parts: list[tuple[tuple[str, ...], Any, tuple[str, ...]]] = [
        ((), data, ("schema", *BODY_KEYS, *Robot.model_fields)),
        (("friction",), data.get("friction"), tuple(Friction.model_fields)),
        (("limits",), data.get("limits"), tuple(Limits.model_fields)),
        (("recorded",), data.get("recorded"), tuple(Recorded.model_fields)),
        (("tolerance",), data.get("tolerance"), tuple(Tolerance.model_fields)),
    ]
    provenance = data.get("provenance")
    if isinstance(provenance, Mapping):
        known = tuple(Provenance.model_fields)
        parts += [(("provenance", str(name)), entry, known) for name, entry in provenance.items()]
    for path, part, known in parts:
        for key in part if isinstance(part, Mapping) else ():
            if key not in known:
                shown, owner = [name for name in known if name != "body"], ".".join(path) or "a robot"
                fault = not_known(key, shown, owner, above="".join(f"{name}." for name in path))
                raise BadInputError(f"{where}: {lines.of(*path, key)}{fault}")
    servo = data.get("servo")
    found = misspelt(servo, _SERVO_KEYS, _SERVO_KEYS, _MISSPELT) if isinstance(servo, Mapping) else None
    if found is not None:
        fault = not_known(found[0], _SERVO_KEYS, "servo", above="servo.")
        raise BadInputError(f"{where}: {lines.of('servo', found[0])}{fault}")


def _first_fault(error: ValidationError, data: Mapping[Any, Any], lines: Lines) -> str:
    faults = [(_place(fault["loc"], data), fault) for fault in error.errors()]
    places = [place for place, _ in faults]
    # A list that is no number, and one item of it that is none either: the item is the fault.
    told = [(p, fault) for p, fault in faults if not any(o[: len(p)] == p and o != p for o in places)]
    path, fault = told[0]
    key = ".".join(str(part) for part in path) or "description"
    given = fault.get("input")
    shown = f" (found {given!r})" if isinstance(given, (int, float, str, bool)) else ""
    others = len({place for place, _ in told}) - 1
    more = f"; and {others} more" if others else ""
    return f"{lines.of(*path)}{key}: {fault['msg'].removeprefix('Value error, ')}{shown}{more}"


def _place(location: tuple[int | str, ...], data: object) -> tuple[int | str, ...]:
    """Where a fault is, as the file has it: pydantic adds ``body``, and what kind of value it tried ("float")."""
    place: list[int | str] = []
    for part in location[location[:1] == ("body",) :]:
        if isinstance(data, Mapping):
            data = data.get(part)
        elif isinstance(data, Sequence) and not isinstance(data, str) and isinstance(part, int):
            data = data[part] if part < len(data) else None
        else:
            continue
        place.append(part)
    return tuple(place)
